// Reading the stress of a part out of the page.
//
// WHAT STANDS IN THE PAGE
// <script type="application/json" id="live-header"> tells of every part what there is; a part's
// numbers stand in <script type="text/plain" id="live-part-K">: base64 of gzip of planes of bytes.
// reports/live/encode.py writes them, tests/reports/live/decode.py reads them in Python as here.
//
// Everything is whole numbers. An array of `length` numbers in p planes is p * length bytes: the
// lowest byte of every number, then the next byte of every number, and so on; p = 0 says that all
// are 0. A number v stands as 2 v, or as -2 v - 1 if it is negative. header.parts[K].coding.layout
// lists the sections in their order: {name, length, planes: [p of each of its arrays]}.
//
//   triangles       3 arrays: first node less the first node of the triangle before; second less
//                   first; third less first. The first is the smallest; against the clock from
//                   outside. Nodes are numbered along Morton's curve.
//   positions       3 arrays, x, y, z at the nodes: coding.origin + coding.step * number, mm
//   utilisation, amplitude, mean   1 array each: coding.fatigue[name] * number; constant over time
//   stress          6 arrays per field, xx, yy, zz, xy, yz, zx: coding.stress.steps[c] * number
//   displacement    3 arrays per field, x, y, z: coding.displacement.steps[c] * number
//   stress weights Q, displacement weights Q    an array per field: its weights at the kept
//                   positions of cycle Q, coding.stress.weights[Q] * number, MPa (or mm)
//   mode            3 arrays, x, y, z of the buckling mode: coding.mode * number, the largest 1
//
// stress at a position = sum over the fields of weight * field. The fields are no unit loads any
// more but the fewest combinations of them that give the same sum (reports/live/fitting.py).
// cycles[Q].positions are the kept positions, numbers of the cycle's own; between them the weights,
// never the stresses, are taken from the straight line.
//
// Arrays at nodes hold what is left of a value when its neighbours have said what they expect:
// value - floor((2 s + k) / (2 k)), s the sum of the k neighbours with smaller numbers, each once;
// where there is none, the value of the node before. Rows of weights hold what is left when each is
// expected on the line through the last two. All of it in whole numbers: Python and the browser
// agree to the last bit.
//
// What is lost is the rounding to whole steps, and of the unit fields to single precision before.
// The largest error of the von Mises stress by rounding is measured at all nodes and positions when
// the page is written, and what single precision may cost is added: accuracy.share, of the peak of
// the position's cycle, or of 1e-4 of the largest cycle's peak, if that is more; accuracy.between
// is the largest of all positions, those that were left out among them.
// accuracy.mises[Q] and .principal[Q] are the same in MPa over all of cycle Q, .moved[Q] of the
// displacement in mm; fields over the duty are off by half of coding.fatigue[name].
//
// scale[field] are the ends of a field over all nodes and all kept positions. utilisation counts
// the required safety in: limits.fatigue is 1, or null where the check counts it in another way.
// limits.yield and .allowed are MPa, of the von Mises stress, without and with required safety.
// decides is false where no check is decided by this stress: one of a mesh to look at alone.
// scale.principal is even on both sides of 0.

const decodePart = (() => {
  // Edges at which the surface turns by more are drawn, and shaded as sharp.
  const CREASE = Math.cos((40 * Math.PI) / 180);

  // A part's geometry and fields out of its text and its entry in the header. Rejects with words.
  async function decodePart(text, head) {
    const take = planeReader(await unzipped(text, "the stress"), head.coding.layout);
    const n = head.nodes;
    const corners = readTriangles(take("triangles"), head.triangles);
    const near = lowerNeighbours(corners, n);
    const steps = take("positions").map((left) => atNodes(left, near));
    const places = new Float32Array(3 * n);
    for (let axis = 0; axis < 3; axis += 1) {
      const { origin, step } = head.coding;
      for (let i = 0; i < n; i += 1) places[3 * i + axis] = origin[axis] + step * steps[axis][i];
    }
    const part = { name: head.name, head, n, ...shaded(places, corners, n), over: {} };
    for (const name of Object.keys(head.coding.fatigue)) {
      part.over[name] = scaled(atNodes(take(name)[0], near), head.coding.fatigue[name]);
    }
    for (const name of ["stress", "displacement"]) {
      if (!(name in head.coding)) continue;
      const { steps: worth, weights } = head.coding[name];
      const fields = take(name).map((left) => narrowed(atNodes(left, near)));
      part[name] = { fields, worth, components: worth.length, weights: weights.map(() => null) };
    }
    for (let cycle = 0; cycle < head.cycles.length; cycle += 1) {
      for (const name of ["stress", "displacement"]) {
        if (head.cycles[cycle] === null || part[name] === undefined) continue;
        const worth = head.coding[name].weights[cycle];
        part[name].weights[cycle] = take(`${name} weights ${cycle}`).map((left) =>
          scaled(alongLine(left), worth),
        );
      }
    }
    if (head.coding.mode) {
      part.mode = take("mode").map((left) => scaled(atNodes(left, near), head.coding.mode));
    }
    return part;
  }

  // What takes the next section's arrays: sections must be asked for in their order.
  function planeReader(bytes, layout) {
    let place = 0;
    let next = 0;
    const size = layout.reduce(
      (sum, { length, planes }) => sum + length * planes.reduce((all, count) => all + count, 0),
      0,
    );
    if (size !== bytes.length) {
      throw new Error(`the stress in this page is damaged: ${bytes.length} bytes, not ${size}`);
    }
    return (name) => {
      const section = layout[next];
      next += 1;
      if (section === undefined || section.name !== name) {
        throw new Error(`the stress in this page is damaged: ${name} does not stand in its place`);
      }
      return section.planes.map((planes) => {
        const values = new Int32Array(section.length);
        for (let plane = 0; plane < planes; plane += 1) {
          const shift = 8 * plane;
          for (let i = 0; i < values.length; i += 1) values[i] |= bytes[place + i] << shift;
          place += values.length;
        }
        for (let i = 0; i < values.length; i += 1) values[i] = (values[i] >>> 1) ^ -(values[i] & 1);
        values.empty = planes === 0;
        return values;
      });
    };
  }

  function readTriangles([first, second, third], m) {
    const corners = new Uint32Array(3 * m);
    let node = 0;
    for (let t = 0; t < m; t += 1) {
      node += first[t];
      corners[3 * t] = node;
      corners[3 * t + 1] = node + second[t];
      corners[3 * t + 2] = node + third[t];
    }
    return corners;
  }

  // The neighbours of node i with smaller numbers: list[k] for start[i] <= k < end[i], each once.
  function lowerNeighbours(corners, n) {
    const start = new Uint32Array(n + 1);
    for (let c = 0; c < corners.length; c += 1) {
      start[Math.max(corners[c], corners[following(c)]) + 1] += 1;
    }
    for (let i = 0; i < n; i += 1) start[i + 1] += start[i];
    const end = start.slice(0, n);
    const list = new Uint32Array(start[n]);
    for (let c = 0; c < corners.length; c += 1) {
      const other = corners[following(c)];
      const low = Math.min(corners[c], other);
      const high = Math.max(corners[c], other);
      let k = start[high];
      while (k < end[high] && list[k] !== low) k += 1;
      if (k === end[high]) {
        list[k] = low;
        end[high] += 1;
      }
    }
    return { start, end, list };
  }

  // The corner after a corner in its triangle.
  function following(c) {
    return c % 3 === 2 ? c - 2 : c + 1;
  }

  // Values at the nodes, in the place of what was left of them.
  function atNodes(values, { start, end, list }) {
    if (values.empty) return values;
    let last = 0;
    for (let i = 0; i < values.length; i += 1) {
      const from = start[i];
      const count = end[i] - from;
      let said = last;
      if (count > 0) {
        let sum = 0;
        for (let k = from; k < end[i]; k += 1) sum += values[list[k]];
        said = Math.floor((2 * sum + count) / (2 * count));
      }
      last = values[i] + said;
      values[i] = last;
    }
    return values;
  }

  function alongLine(values) {
    let slope = 0;
    let value = 0;
    for (let i = 0; i < values.length; i += 1) {
      slope += values[i];
      value += slope;
      values[i] = value;
    }
    return values;
  }

  function scaled(values, step) {
    const result = new Float64Array(values.length);
    for (let i = 0; i < values.length; i += 1) result[i] = step * values[i];
    return result;
  }

  // Half of the memory where 16 bits are enough; null of an array without a number.
  function narrowed(values) {
    let low = 0;
    let high = 0;
    for (let i = 0; i < values.length; i += 1) {
      if (values[i] < low) low = values[i];
      else if (values[i] > high) high = values[i];
    }
    if (low === 0 && high === 0) return null;
    return low >= -32768 && high <= 32767 ? Int16Array.from(values) : values;
  }

  // Vertices: the nodes, then one more of a node for each further side of a sharp edge there; unit
  // normals at them; triangles of vertices; and the sharp and the open edges.
  function shaded(places, corners, n) {
    const faces = faceNormals(places, corners);
    const { side, edges } = smoothSides(corners, faces, n);
    const vertexOf = new Int32Array(corners.length).fill(-1);
    const nodes = [];
    const first = new Uint8Array(n);
    const triangles = new Uint32Array(corners.length);
    for (let c = 0; c < corners.length; c += 1) {
      const root = rootOf(side, c);
      if (vertexOf[root] < 0) {
        const node = corners[c];
        vertexOf[root] = first[node] === 0 ? node : n + nodes.push(node) - 1;
        first[node] = 1;
      }
      triangles[c] = vertexOf[root];
    }
    const node = new Uint32Array(n + nodes.length);
    for (let i = 0; i < n; i += 1) node[i] = i;
    node.set(nodes, n);
    const positions = new Float32Array(3 * node.length);
    const normals = new Float32Array(3 * node.length);
    for (let v = 0; v < node.length; v += 1) {
      for (let axis = 0; axis < 3; axis += 1) positions[3 * v + axis] = places[3 * node[v] + axis];
    }
    for (let c = 0; c < triangles.length; c += 1) {
      const t = 3 * Math.floor(c / 3);
      for (let axis = 0; axis < 3; axis += 1) normals[3 * triangles[c] + axis] += faces[t + axis];
    }
    for (let v = 0; v < node.length; v += 1) {
      const [x, y, z] = [normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]];
      const length = Math.hypot(x, y, z) || 1;
      normals[3 * v] = x / length;
      normals[3 * v + 1] = y / length;
      normals[3 * v + 2] = z / length;
    }
    return { node, positions, normals, triangles, edges };
  }

  // Normals of the triangles, as long as twice their area.
  function faceNormals(p, corners) {
    const normals = new Float32Array(corners.length);
    for (let t = 0; t < corners.length; t += 3) {
      const [a, b, c] = [3 * corners[t], 3 * corners[t + 1], 3 * corners[t + 2]];
      const [ux, uy, uz] = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]];
      const [vx, vy, vz] = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
      normals[t] = uy * vz - uz * vy;
      normals[t + 1] = uz * vx - ux * vz;
      normals[t + 2] = ux * vy - uy * vx;
    }
    return normals;
  }

  // Which corners of triangles are on one smooth side of their node (a forest), and sharp edges.
  function smoothSides(corners, faces, n) {
    const side = new Uint32Array(corners.length);
    const start = new Uint32Array(n + 1);
    for (let c = 0; c < corners.length; c += 1) {
      side[c] = c;
      start[Math.max(corners[c], corners[following(c)]) + 1] += 1;
    }
    for (let i = 0; i < n; i += 1) start[i + 1] += start[i];
    const end = start.slice(0, n);
    const waiting = new Int32Array(start[n]); // edges that have met one triangle; -1: both
    const edges = [];
    for (let c = 0; c < corners.length; c += 1) {
      const d = following(c);
      const low = Math.min(corners[c], corners[d]);
      const high = Math.max(corners[c], corners[d]);
      let k = start[high];
      while (k < end[high] && !(waiting[k] >= 0 && lowEnd(waiting[k], corners) === low)) k += 1;
      if (k === end[high]) {
        waiting[k] = c;
        end[high] += 1;
        continue;
      }
      const other = waiting[k];
      waiting[k] = -1;
      if (sharp(faces, c, other)) {
        edges.push(corners[c], corners[d]);
        continue;
      }
      const ends = [other, following(other)];
      for (const mine of [c, d]) {
        const theirs = corners[ends[0]] === corners[mine] ? ends[0] : ends[1];
        side[rootOf(side, mine)] = rootOf(side, theirs);
      }
    }
    for (let i = 0; i < n; i += 1) {
      for (let k = start[i]; k < end[i]; k += 1) {
        if (waiting[k] >= 0) edges.push(corners[waiting[k]], corners[following(waiting[k])]);
      }
    }
    return { side, edges: Uint32Array.from(edges) };
  }

  function lowEnd(c, corners) {
    return Math.min(corners[c], corners[following(c)]);
  }

  function sharp(faces, c, other) {
    const s = 3 * Math.floor(c / 3);
    const t = 3 * Math.floor(other / 3);
    const [ax, ay, az] = [faces[s], faces[s + 1], faces[s + 2]];
    const [bx, by, bz] = [faces[t], faces[t + 1], faces[t + 2]];
    const lengths = Math.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz));
    return ax * bx + ay * by + az * bz < CREASE * lengths; // one without area is on every side
  }

  function rootOf(side, c) {
    while (side[c] !== c) {
      side[c] = side[side[c]];
      c = side[c];
    }
    return c;
  }

  return decodePart;
})();
