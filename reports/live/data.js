// What stands in the page is read here: plain data, packed data, series, and rows of a cycle.

// The data of a block, null where the page has none.
const jsonOf = (id) => {
  const block = document.getElementById(id);
  return block ? JSON.parse(block.textContent) : null;
};

const bytesOf = (text) => { // of base64; the loop is many times faster than Uint8Array.from
  const packed = atob(text.trim()), bytes = new Uint8Array(packed.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = packed.charCodeAt(i);
  return bytes;
};

// Bytes out of base64 of gzip. Rejects with words, in which `what` names the data: "the stress".
const unzipped = async (text, what) => {
  if (typeof DecompressionStream !== "function")
    throw new Error(`this browser is too old to unpack ${what}: no DecompressionStream`);
  try {
    const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  } catch (error) {
    throw new Error(`${what} in this page is damaged: it cannot be unpacked`, { cause: error });
  }
};
// The same of JSON, as reports/packed.py writes it.
const unzippedJson = async (text, what) => {
  const bytes = await unzipped(text, what);
  try {
    return JSON.parse(new TextDecoder().decode(bytes));
  } catch (error) {
    throw new Error(`${what} in this page is damaged: it cannot be read`, { cause: error });
  }
};

// Numbers of a series as reports/packed.py writes it: value k is from + step * (d[0] + ... + d[k]).
const series = ({ from, step, d }) => {
  let sum = 0;
  return Float64Array.from(d, (change) => from + step * (sum += change));
};

// Where a value stands in a rising list, as a fractional row; outside of the list its nearer end.
const rowIn = (list, value) => {
  let low = 0, high = list.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= value) low = middle; else high = middle;
  }
  const step = list[high] - list[low];
  return step > 0 ? low + Math.min(1, Math.max(0, (value - list[low]) / step)) : low;
};

// A list at a fractional row, on the straight line between its neighbours.
const atRow = (list, row) => {
  const low = Math.floor(row), high = Math.min(low + 1, list.length - 1);
  return list[low] + (row - low) * (list[high] - list[low]);
};
