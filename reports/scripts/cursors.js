// The charts' cursors: they follow the position of the page, and a click on a chart sets it.
//
// A chart is an SVG with an attribute data-cursor, JSON of
//   line  {cycle, at, x}      where positions are across it; the cursor is a line, `from` to `to`
//   dots  [{cycle, at, x, y}] paths, one for each cycle that has one; their cursor is a dot
//   rows  [{cycle, row, at, value, scale, x}] what the readout below tells, row by row (`row`, else
//         their order); with `scale` [value, y, value, y] a dot goes along, at `x` or on the line;
//         `as` names an earlier entry of rows that has what is missing here
// `at` are positions of the cycle; between them everything is straight, null is a gap.
{
  const SVG = "http://www.w3.org/2000/svg";
  const page = globalThis.ballesta;

  const made = (name, parent) => parent.appendChild(document.createElementNS(SVG, name));

  // The row of an index in a rising list, as a fraction; null outside of it.
  const placeIn = (list, index) =>
    (index >= list[0] && index <= list[list.length - 1] ? rowIn(list, index) : null);
  const valueAt = (values, place) => {
    if (place === null) return null;
    if (!Array.isArray(values)) return values;
    if (values[Math.floor(place)] === null || values[Math.ceil(place)] === null) return null;
    return atRow(values, place);
  };

  const chartOf = (svg) => {
    const data = JSON.parse(svg.dataset.cursor);
    const rows = (data.rows ?? []).map((row, k, all) =>
      ({ row: k, ...(row.as === undefined ? {} : all[row.as]), ...row }));
    const items = [...(svg.closest("figure")?.querySelectorAll(".readout li") ?? [])];
    const group = made("g", svg);
    group.setAttribute("class", "cursor");
    const line = data.line ? made("line", group) : null;
    for (const [name, value] of line ? [["y1", data.from], ["y2", data.to]] : [])
      line.setAttribute(name, value);
    const circles = [];
    const dot = (k, x, y) => {
      circles[k] ??= made("circle", group);
      circles[k].setAttribute("r", 3.6);
      circles[k].setAttribute("cx", x);
      circles[k].setAttribute("cy", y);
      circles[k].style.display = "";
    };
    return { svg, group, data, rows, items, line, circles, dot, seen: true, shown: null };
  };

  const tell = (item, value) => {
    const output = item.querySelector("output");
    const { decimals, unit } = output.dataset;
    const text = value === null || value === undefined ? ""
      : `now ${(value.toFixed(Number(decimals)).replace("-", "−"))}${unit ? ` ${unit}` : ""}`;
    if (output.textContent !== text) output.textContent = text;
    if (!item.querySelector(".peak")) item.hidden = text === "";
  };

  const show = (chart, { cycle, index }) => {
    const { data, rows, items, line, circles, dot } = chart;
    let x = null, count = 0;
    for (const circle of circles) circle.style.display = "none";
    if (line && data.line.cycle === cycle) {
      x = valueAt(data.line.x, placeIn(data.line.at, index));
      line.setAttribute("x1", x ?? 0);
      line.setAttribute("x2", x ?? 0);
    }
    if (line) line.style.display = x === null ? "none" : "";
    const told = new Map();
    for (const row of rows) {
      if (row.cycle !== cycle) continue;
      const value = valueAt(row.value, placeIn(row.at, index));
      told.set(row.row, value);
      const across = row.x ?? x;
      if (row.scale && value !== null && across !== null) {
        const [low, bottom, high, top] = row.scale;
        const part = Math.min(1, Math.max(0, (value - low) / (high - low)));
        dot(count++, across, bottom + part * (top - bottom));
      }
    }
    for (const path of data.dots ?? []) {
      if (path.cycle !== cycle) continue;
      const place = placeIn(path.at, index);
      if (place !== null) dot(count++, valueAt(path.x, place), valueAt(path.y, place));
    }
    items.forEach((item, k) => tell(item, told.get(k) ?? null));
  };

  // The position nearest to a point of the picture: [cycle, index]; null where a chart has none.
  const nearest = ({ svg, data }, event) => {
    const matrix = svg.getScreenCTM();
    if (!matrix) return null;
    const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
    const own = page.current?.cycle;
    const paths = data.line ? [data.line] : data.dots ?? [];
    const here = paths.filter((path) => path.cycle === own);
    let best = null, least = Infinity;
    for (const path of here.length ? here : paths)
      for (let k = 0; k < path.at.length; k++) {
        const next = Math.min(k + 1, path.at.length - 1);
        const a = [path.x[k], data.line ? at.y : path.y[k]];
        const b = [path.x[next], data.line ? at.y : path.y[next]];
        const way = (b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2;
        const share = way > 0
          ? ((at.x - a[0]) * (b[0] - a[0]) + (at.y - a[1]) * (b[1] - a[1])) / way : 0;
        const part = Math.min(1, Math.max(0, share));
        const [right, down] = [0, 1].map((axis) => a[axis] + part * (b[axis] - a[axis]));
        const far = Math.hypot(right - at.x, down - at.y);
        if (far < least - 1e-9) {
          least = far;
          best = [path.cycle, Math.round(path.at[k] + part * (path.at[next] - path.at[k]))];
        }
      }
    return best;
  };

  if (page?.onPosition) {
    const charts = [...document.querySelectorAll("svg[data-cursor]")].map(chartOf);
    const follow = (chart, state) => {
      if (chart.seen && chart.shown !== state) show(chart, chart.shown = state);
    };
    const watcher = new IntersectionObserver((entries) => {
      for (const { target, isIntersecting } of entries) {
        const chart = charts.find(({ svg }) => svg === target);
        chart.seen = isIntersecting;
        if (page.current) follow(chart, page.current);
      }
    }, { rootMargin: "200px" });
    for (const chart of charts) {
      const { svg, data } = chart;
      watcher.observe(svg);
      if (!data.line && !data.dots) continue;
      svg.classList.add("settable");
      const set = (event) => {
        const found = nearest(chart, event);
        if (found) page.setPosition(...found);
      };
      svg.addEventListener("click", set);
      svg.addEventListener("pointermove", (event) => {
        if (event.pointerType !== "mouse") return;
        if (event.buttons === 1) return set(event);
        const found = nearest(chart, event);
        if (found) show(chart, chart.shown = { cycle: found[0], index: found[1] });
      });
      svg.addEventListener("pointerleave", () => page.current && follow(chart, page.current));
    }
    page.onPosition((state) => charts.forEach((chart) => follow(chart, state)));
  }
}
