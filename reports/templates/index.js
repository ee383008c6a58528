// The table and the plot of a batch. Everything it shows comes from the page's own data block.
{
  const byId = (id) => document.getElementById(id);
  const data = JSON.parse(byId("data").textContent);
  const { designs, varied, checks, texts, order } = data;
  const PAGE = 100, DECADES = 30;

  const make = (tag, text, kind) => {
    const element = document.createElement(tag);
    if (text !== undefined) element.textContent = text;
    if (kind) element.className = kind;
    return element;
  };
  // Safety is rounded down and utilisation up: neither looks better than it is.
  const rounded = (value, digits, way) => {
    if (value === null || value === undefined) return "";
    if (!Number.isFinite(value)) return value > 0 ? "∞" : "–";
    if (value === 0) return "0";
    const decimals = digits - 1 - Math.floor(Math.log10(Math.abs(value)));
    const near = Number(value.toPrecision(digits));
    if (way === undefined || near === value) return text(near, decimals);
    const step = 10 ** -decimals;
    const away = way < 0 ? near > value : near < value;
    return text(away ? Number((near + way * step).toPrecision(digits)) : near, decimals);
  };
  const text = (value, decimals) =>
    Math.abs(value) >= 1e-4 && Math.abs(value) < 1e6
      ? value.toFixed(Math.max(0, Math.min(decimals, 12))) : String(value);
  const short = (value) => (typeof value === "number" ? String(Number(value.toPrecision(6))) : value);
  const bar = (value) => (value === null ? "∞" : rounded(value, 2, 1));

  // A row is a check, or a design that has none: [design, check or -1].
  const rows = [], governing = [], has = new Uint8Array(designs.length);
  checks.design.forEach((design, check) => {
    has[design] = 1;
    rows.push([design, check]);
    if (checks.governing[check]) governing.push([design, check]);
  });
  designs.forEach((_, design) => {
    if (!has[design]) { rows.push([design, -1]); governing.push([design, -1]); }
  });
  const inOrder = (list) => list.sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  inOrder(rows); inOrder(governing);
  const word = (name, check) => (check < 0 ? "" : texts[checks[name][check]]);
  const safety = (check) => checks.limit[check] / checks.value[check]; // infinite without load
  const utilisation = (check) =>
    checks.value[check] * checks.required[check] / checks.limit[check];
  const rank = new Map(order.map((status, index) => [status, index]));

  const column = (name, value, cell, numeric) => ({ name, value, cell, numeric });
  const number = (name, value, shown) =>
    column(name, (d, c) => (c < 0 ? null : value(c)), (d, c) => (c < 0 ? "" : shown(c)), true);
  const chosen = new Set(), MOST = 4;
  const pictures = designs.some((design) => design.picture);
  const columns = [
    column("design", (d) => d, (d) => {
      const cell = make("th", undefined, "k name");
      cell.scope = "row";
      const name = designs[d].link ? make("a", designs[d].name) : make("span", designs[d].name);
      if (designs[d].link) name.href = designs[d].link;
      cell.append(name);
      return cell;
    }),
    column("compare", null, (d) => {
      const cell = make("td"), box = make("input");
      Object.assign(box, { type: "checkbox", checked: chosen.has(d), ariaLabel: `Compare ${designs[d].name}` });
      box.dataset.choose = d;
      box.addEventListener("change", () => choose(d, box.checked));
      cell.append(box);
      return cell;
    }),
    ...(!pictures ? [] : [column("picture", null, (d) => {
      const cell = make("td");
      if (designs[d].picture) {
        const image = make("img");
        image.alt = `Picture of ${designs[d].name}`;
        image.src = `data:image/png;base64,${designs[d].picture}`;
        cell.append(image);
      }
      return cell;
    })]),
    column("design's verdict", (d) => rank.get(designs[d].status), (d) => {
      const cell = make("td");
      cell.append(make("span", designs[d].status, `word ${designs[d].tone}`));
      return cell;
    }),
    column("mass [kg]", (d) => designs[d].mass, (d) => rounded(designs[d].mass, 4), true),
    column("part", (d, c) => word("part", c) || null, (d, c) => word("part", c)),
    column("check", (d, c) => word("check", c) || null, (d, c) => word("check", c)),
    column("utilisation", (d, c) => (c < 0 ? null : utilisation(c)), (d, c) => {
      const cell = make("td", c < 0 ? "" : rounded(utilisation(c), 3, 1), "use");
      if (c >= 0) cell.append(gaugeOf({
        use: utilisation(c), per: checks.required[c] / checks.limit[c], tone: word("status", c),
        numerical: checks.numerical[c], model: checks.model[c], below: checks.model_below[c],
      }));
      return cell;
    }),
    number("safety (required)", safety, (c) =>
      (checks.value[c] ? rounded(safety(c), 3, -1) : "not loaded") + ` (${checks.required[c]})`),
    ...data.columns.map((k) => varied[k]).map((input) =>
      column(input.name, (d) => input.values[d], (d) => short(input.values[d]) ?? "", true)),
    column("its verdict", (d, c) => (c < 0 ? null : rank.get(word("status", c))), (d, c) => {
      const cell = make("td");
      cell.append(make("span", word("status", c), `word ${word("status", c)}`));
      return cell;
    }),
    number("value", (c) => checks.value[c], (c) => `${rounded(checks.value[c], 4)} ${word("unit", c)}`),
    number("± numerical", (c) => checks.numerical[c] ?? Infinity, (c) => bar(checks.numerical[c])),
    number("model", (c) => checks.model[c] ?? Infinity,
      (c) => `+${bar(checks.model[c])} −${bar(checks.model_below[c])}`),
    number("limit", (c) => checks.limit[c], (c) => rounded(checks.limit[c], 4)),
    column("where, how, what else", null, (d, c) => {
      const cell = make("td", undefined, "w");
      const where = [word("place", c), word("cycle", c), word("position", c), word("method", c)];
      cell.append(where.filter(Boolean).join("; "));
      for (const told of [word("note", c), c < 0 || checks.governing[c] ? designs[d].told : ""])
        if (told) {
          const note = make("small", told, "clip");
          note.title = told;
          cell.append(note);
        }
      return cell;
    }),
  ];

  const ask = { view: "governing", words: [], status: "", part: "", check: "", sorted: -1, way: 1, page: 0 };
  let shown = [];
  const told = designs.map((design, d) =>
    [design.name, design.title, design.file, design.status, design.told,
      ...varied.map((input) => input.values[d] ?? "")].join(" ").toLowerCase());
  const folded = texts.map((each) => each.toLowerCase());
  const matches = (d, c, wanted) => told[d].includes(wanted) ||
    (c >= 0 && ["part", "check", "quantity", "status", "cycle", "place", "method", "note"].some(
      (name) => folded[checks[name][c]].includes(wanted)));

  const select = () => {
    const list = ask.view === "all" ? rows : governing;
    shown = list.filter(([d, c]) =>
      (!ask.status || (c < 0 ? designs[d].status : word("status", c)) === ask.status) &&
      (!ask.part || word("part", c) === ask.part) &&
      (!ask.check || word("check", c) === ask.check) &&
      ask.words.every((wanted) => matches(d, c, wanted)));
    if (ask.sorted >= 0) {
      const { value } = columns[ask.sorted];
      const keyed = shown.map((row, index) => [value(...row), index, row]);
      const missing = (key) => key === null || key === undefined;
      keyed.sort(([a, i], [b, j]) => {
        if (missing(a) || missing(b)) return (missing(a) - missing(b)) || i - j; // last, either way
        const order = typeof a === "number" && typeof b === "number"
          ? (a === b ? 0 : a - b) : String(a).localeCompare(String(b));
        return ask.way * order || i - j;
      });
      shown = keyed.map((each) => each[2]);
    }
    ask.page = 0;
    draw();
  };

  const table = byId("table"), body = make("tbody"), head = make("tr");
  const draw = () => {
    const first = ask.page * PAGE, last = Math.min(first + PAGE, shown.length);
    body.replaceChildren(...shown.slice(first, last).map(([d, c]) => {
      const line = make("tr");
      line.append(...columns.map((each) => {
        const cell = each.cell(d, c);
        return typeof cell === "string" ? make("td", cell, each.numeric ? "n" : "k") : cell;
      }));
      return line;
    }));
    byId("place").textContent =
      shown.length ? `${first + 1} to ${last} of ${shown.length}` : "no row is like that";
    byId("back").disabled = ask.page === 0;
    byId("next").disabled = last >= shown.length;
    heads.forEach((cell, index) => {
      if (ask.sorted === index) cell.setAttribute("aria-sort", ask.way > 0 ? "ascending" : "descending");
      else cell.removeAttribute("aria-sort");
    });
  };
  const heads = columns.map((each, index) => {
    const cell = make("th", each.value ? undefined : each.name, each.numeric ? "n" : "");
    cell.scope = "col";
    if (each.value) {
      const button = make("button", each.name);
      button.type = "button";
      button.addEventListener("click", () => {
        ask.way = ask.sorted === index ? -ask.way : 1;
        ask.sorted = index;
        select();
      });
      cell.append(button);
    }
    return cell;
  });
  head.append(...heads);

  const fill = (id, values) => byId(id).append(...[...new Set(values)].map((value) => {
    const option = make("option", value);
    option.value = value;
    return option;
  }));
  const used = (name) => [...new Set(checks[name])].map((index) => texts[index]);
  fill("status", order.filter((status) =>
    used("status").includes(status) || designs.some((design) => design.status === status)));
  fill("part", used("part"));
  fill("check", used("check"));
  for (const name of ["view", "status", "part", "check"])
    byId(name).addEventListener("change", (event) => { ask[name] = event.target.value; select(); });
  let waiting = 0;
  byId("words").addEventListener("input", (event) => {
    clearTimeout(waiting);
    waiting = setTimeout(() => {
      ask.words = event.target.value.toLowerCase().split(/\s+/).filter(Boolean);
      select();
    }, 120);
  });
  byId("back").addEventListener("click", () => { ask.page -= 1; draw(); });
  byId("next").addEventListener("click", () => { ask.page += 1; draw(); });
  table.replaceChildren(make("caption", "Checks; a press on a heading sorts"), make("thead"), body);
  table.tHead.append(head);
  byId("controls").hidden = false;
  select();

  // Checks by name: of each design the first of that name.
  const decisive = new Map(governing), own = new Map();
  checks.design.forEach((d, c) => {
    const name = `${word("part", c)}: ${word("check", c)}`;
    if (!own.has(name)) own.set(name, new Map());
    if (!own.get(name).has(d)) own.get(name).set(d, c);
  });

  // Two to four designs side by side; a fifth takes the place of the first.
  const choose = (d, on) => {
    chosen.delete(d);
    if (on) chosen.add(d);
    if (chosen.size > MOST) chosen.delete(chosen.values().next().value);
    for (const box of body.querySelectorAll("[data-choose]"))
      box.checked = chosen.has(Number(box.dataset.choose));
    const list = [...chosen], line = (name, cell) => {
      const row = make("tr"), cells = list.map(cell);
      if (new Set(cells).size > 1) row.className = "differs";
      row.append(make("th", name, "k"), ...cells.map((text) => make("td", text)));
      return row;
    };
    const ofCheck = (c) => (c === undefined || c < 0 ? "–"
      : `${checks.value[c] ? rounded(safety(c), 3, -1) : "not loaded"} (${checks.required[c]}) ${word("status", c)}`);
    byId("beside").hidden = list.length < 2;
    byId("beside").querySelector("tbody").replaceChildren(
      line("design", (k) => designs[k].name), line("verdict", (k) => designs[k].status),
      line("mass [kg]", (k) => rounded(designs[k].mass, 4) || "–"),
      ...varied.map((input) => line(input.name, (k) => short(input.values[k]) ?? "–")),
      ...[...own].filter(([, at]) => list.some((k) => at.has(k)))
        .map(([name, at]) => line(`${name}: safety`, (k) => ofCheck(at.get(k)))));
  };

  // The plot: a dot per design, coloured by its verdict.
  const plot = () => {
    const mass = (d) => designs[d].mass;
    const inputs = [["mass [kg]", mass], ...varied.map((input) => [input.name, (d) => input.values[d]]),
      ["place in the batch", (d) => d + 1]];
    const finite = (value) => (Number.isFinite(value) ? value : null);
    const of = (at, value) => (d) => {
      const c = at.get(d);
      return c === undefined || c < 0 ? null : finite(value(c));
    };
    const reserve = of(decisive, (c) => 1 / utilisation(c));
    const results = [
      ["reserve: safety over required", reserve],
      ["governing check: utilisation", of(decisive, utilisation)],
      ["governing check: safety", of(decisive, safety)],
      ["mass [kg]", (d) => designs[d].mass],
    ];
    for (const [name, at] of own) {
      const unit = word("unit", at.values().next().value);
      results.push([`${name}: utilisation`, of(at, utilisation)], [`${name}: safety`, of(at, safety)],
        [`${name}: value${unit ? ` [${unit}]` : ""}`, of(at, (c) => checks.value[c])]);
    }
    const options = (id, list) => byId(id).append(...list.map(([name], index) => {
      const option = make("option", name);
      option.value = index;
      return option;
    }));
    options("x", inputs);
    options("y", results);
    byId("x").value = designs.some((design) => design.mass !== null) ? 0 : 1;
    const svg = byId("chart");
    const add = (tag, attributes, content) => {
      const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
      for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
      if (content !== undefined) element.textContent = content;
      svg.append(element);
      return element;
    };
    const steps = (low, high) => {
      const raw = (high - low) / 6 || Math.abs(high) || 1, size = 10 ** Math.floor(Math.log10(raw));
      const step = size * [1, 2, 5, 10].find((each) => each * size >= raw * 0.999);
      const ticks = [];
      for (let k = Math.ceil(low / step); k * step <= high + step * 1e-9; k++)
        ticks.push(Number((k * step).toPrecision(8)));
      return ticks;
    };
    const [left, right, top, bottom] = [70, 880, 16, 360];
    const scale = (values, from, to) => {
      const kinds = values.filter((value) => value !== null && value !== undefined);
      if (kinds.some((value) => typeof value === "string")) {
        const names = [...new Set(kinds.map(String))].sort((a, b) => a.localeCompare(b, undefined, { numeric: true }));
        const at = new Map(names.map((name, index) => [name, from + (to - from) * (index + 0.5) / names.length]));
        const longest = Math.max(...names.map((name) => name.length)); // of 7 px a letter
        const every = Math.ceil(names.length * Math.max(longest * 7, 60) / (right - left));
        return { at: (value) => at.get(String(value)),
          ticks: names.filter((_, index) => index % every === 0).map((name) => [name, at.get(name)]) };
      }
      let low = Infinity, high = -Infinity;
      for (const value of kinds) { low = Math.min(low, value); high = Math.max(high, value); }
      if (low > 0 && high > DECADES * low) { // one machine of tonnes hides all of kilograms
        const [first, last] = [Math.log10(low) - 0.05, Math.log10(high) + 0.05];
        const at = (value) => from + (to - from) * (Math.log10(value) - first) / (last - first);
        const fine = last - first < 2.5 ? [1, 2, 5] : [1], ticks = [];
        for (let k = Math.floor(first); k <= last; k++)
          for (const value of fine.map((each) => Number((each * 10 ** k).toPrecision(3))))
            if (Math.log10(value) >= first && Math.log10(value) <= last) ticks.push([String(value), at(value)]);
        return { at, ticks };
      }
      const room = (high - low) * 0.04 || Math.abs(high) * 0.05 || 1;
      [low, high] = [low - room, high + room];
      const at = (value) => from + (to - from) * (value - low) / (high - low);
      return { at, ticks: steps(low, high).map((value) => [String(value), at(value)]) };
    };
    // No design on the front is both heavier and nearer to its limit than another one.
    const front = (points, x, y) => {
      let best = -Infinity;
      const sorted = [...points].sort((p, q) => p[1] - q[1] || q[2] - p[2]);
      const kept = sorted.filter((point) => point[2] > best && ((best = point[2]), true));
      add("path", { class: "front", d: kept.map(([, a, b], k) =>
        `${k ? `H${x.at(a)}V` : `M${x.at(a)} `}${y.at(b)}`).join("") });
      const lightest = sorted.find(([d]) => designs[d].status === "pass");
      if (!lightest) return;
      const [d, a, b] = lightest, far = x.at(a) > (left + right) / 2;
      add("circle", { class: "lightest", cx: x.at(a), cy: y.at(b), r: 8 });
      add("text", { class: "lightest", x: x.at(a) + (far ? -12 : 12), y: y.at(b) + 18, "text-anchor": far ? "end" : "start" },
        `lightest pass: ${designs[d].name}, ${rounded(a, 4)} kg`);
    };
    const show = () => {
      const [xName, xOf] = inputs[byId("x").value], [yName, yOf] = results[byId("y").value];
      const points = designs.map((_, d) => [d, xOf(d), yOf(d)]).filter(
        ([, x, y]) => x !== null && x !== undefined && y !== null && y !== undefined);
      svg.replaceChildren();
      byId("told").textContent = `${points.length} of ${designs.length} designs` +
        (points.length < designs.length ? "; the others have no such result or input" : "");
      if (!points.length) return;
      const x = scale(points.map((point) => point[1]), left, right);
      const y = scale(points.map((point) => point[2]), bottom, top);
      for (const [label, at] of x.ticks) {
        add("line", { x1: at, x2: at, y1: top, y2: bottom });
        add("text", { x: at, y: bottom + 18, "text-anchor": "middle" }, label);
      }
      for (const [label, at] of y.ticks) {
        add("line", { x1: left, x2: right, y1: at, y2: at });
        add("text", { x: left - 6, y: at + 4, "text-anchor": "end" }, label);
      }
      add("text", { x: (left + right) / 2, y: bottom + 42, "text-anchor": "middle" }, xName);
      add("text", { x: left, y: top - 4 }, yName);
      const [limit, inside] = [y.at(1), y.at(1) > top && y.at(1) < bottom];
      if (yOf === reserve && inside)
        add("line", { x1: left, x2: right, y1: limit, y2: limit, class: "required" });
      for (const [d, a, b] of points) {
        const dot = add("circle", { cx: x.at(a), cy: y.at(b), r: points.length > 500 ? 3 : 4.5,
          class: designs[d].tone, "data-design": d });
        const name = document.createElementNS("http://www.w3.org/2000/svg", "title");
        name.textContent = `${designs[d].name}: ${designs[d].status}\n${xName}: ${a}\n${yName}: ${b}`;
        dot.append(name);
      }
      byId("front").hidden = yOf !== reserve || xOf !== mass;
      if (!byId("front").hidden) front(points, x, y);
    };
    svg.addEventListener("click", (event) => {
      const d = event.target.dataset?.design;
      if (d === undefined) return;
      byId("words").value = designs[d].name;
      ask.words = [designs[d].name.toLowerCase()];
      select();
      byId("checks").scrollIntoView();
    });
    for (const id of ["x", "y"]) byId(id).addEventListener("change", show);
    byId("axes").hidden = false;
    svg.removeAttribute("hidden");
    show();
  };
  if (byId("chart")) plot();
}
