// Moves the mechanism with the page's position, and tells the forces at its pins. Everything comes
// from the data block that reports/mechanism_panel.py explains. Lengths are mm with y up, as the
// machine has them; the picture's y points down.
{
  const figure = document.getElementById("mechanism");
  const block = document.getElementById("mechanism-data");
  const svg = figure?.querySelector("svg");
  const find = (role) => figure.querySelector(`[data-role=${role}]`);
  const drawn = (kind, k) => document.getElementById(`mechanism-${kind}-${k}`);
  const SERIES = ["poses", "reactions", "pushes", "efforts", "torques", "pins", "places"];

  const start = (data) => {
    const cycles = data.cycles.map((cycle) => cycle && { ...cycle, ready: false });
    const arrowsOfPins = data.pins.map(() => {
      const made = document.createElementNS("http://www.w3.org/2000/svg", "path");
      made.setAttribute("class", "arrow on-part");
      svg.append(made);
      return made;
    });
    for (const cell of figure.querySelectorAll("[data-now]")) cell.hidden = false;

    const prepared = (k) => {
      const cycle = cycles[k];
      if (cycle && !cycle.ready) {
        for (const name of SERIES) cycle[name] = cycle[name].map(series);
        cycle.ready = true;
      }
      return cycle;
    };

    const show = (state) => {
      const open = openPart(state.part);
      mark(open);
      const cycle = prepared(state.cycle);
      svg.classList.toggle("still", !cycle);
      if (!cycle) { rest(state); return; }
      const row = rowIn(cycle.index, state.index);
      const at = (list, k) => atRow(list[k], row);
      const pose = (body) => body === 0 ? [0, 0, 0]
        : [0, 1, 2].map((axis) => at(cycle.poses, 3 * (body - 1) + axis));
      const bodies = Array.from({ length: cycle.poses.length / 3 + 1 }, (_, body) => pose(body));
      const place = ([body, x, y]) => {
        const [x0, y0, angle] = bodies[body];
        const [c, s] = [Math.cos(angle), Math.sin(angle)];
        return [x0 + c * x - s * y, -(y0 + s * x + c * y)];
      };
      const vector = (list, k) => [at(list, 2 * k), -at(list, 2 * k + 1)];

      bodies.slice(1).forEach(([x, y, angle], k) => drawn("body", k).setAttribute("transform",
        `translate(${x} ${-y}) rotate(${-angle * 180 / Math.PI})`));
      const marks = data.marks.map(place);
      marks.forEach(([x, y], k) => {
        drawn("point", k).setAttribute("transform", `translate(${x} ${y})`);
        const label = drawn("label", k), lift = data.marks[k][3];
        label?.setAttribute("x", x + lift);
        label?.setAttribute("y", y - lift);
      });
      data.spans.forEach((span, k) => {
        const [[x0, y0], [x1, y1]] = [place(span.slice(0, 3)), place(span.slice(3, 6))];
        const reach = span[6] / Math.hypot(x1 - x0, y1 - y0);
        line(drawn("span", k), x0, y0, x1, y1);
        line(drawn("barrel", k), x0, y0, x0 + reach * (x1 - x0), y0 + reach * (y1 - y0));
      });
      const { scale } = cycle, { tip } = data, whole = open === null;
      for (let k = 0; k < data.joints; k++) {
        const [[x, y], [fx, fy]] = [marks[k], vector(cycle.reactions, k)];
        draw(drawn("arrow", k), whole ? arrowPath(x, y, x + scale * fx, y + scale * fy, tip) : "");
      }
      data.pushes.forEach((push, k) => { // a pushing force is drawn up to where it acts
        const [[x, y], [fx, fy]] = [place(push), vector(cycle.pushes, k)];
        draw(drawn("arrow", data.joints + k),
          whole ? arrowPath(x - scale * fx, y - scale * fy, x, y, tip) : "");
      });
      data.turning.forEach((turning, k) => {
        const [x, y] = place(turning);
        drawn("torque", k).setAttribute("transform", `translate(${x} ${y})`);
        draw(drawn("torque", k), torquePath(at(cycle.torques, k) / cycle.turned, tip));
      });
      let sliding = 0;
      const forces = data.pins.map((pin, k) => {
        const [fx, fy] = vector(cycle.pins, k);
        const [x, y] = pin.at ? place([pin.body, ...pin.at]) : vector(cycle.places, sliding++);
        draw(arrowsOfPins[k],
          pin.part === open ? arrowPath(x, y, x + scale * fx, y + scale * fy, tip) : "");
        return Math.hypot(fx, fy);
      });
      tell(state, open, forces, data.efforts.map((_, k) => at(cycle.efforts, k)));
      find("scale").textContent = cycle.longest;
    };

    const openPart = (part) => { // a name, a number, or nothing where the whole linkage is open
      const k = typeof part === "string" ? data.names.indexOf(part) : part;
      return Number.isInteger(k) && k >= 0 && data.parts[k] ? k : null;
    };
    const mark = (open) => {
      const shown = open === null ? null : data.parts[open];
      const body = shown && shown.mark === null ? shown.body - 1 : null;
      svg.classList.toggle("has-open", body !== null);
      for (const each of svg.querySelectorAll(".open")) each.classList.remove("open");
      if (body !== null) drawn("body", body)?.classList.add("open");
      if (shown && shown.mark !== null) drawn("point", shown.mark)?.classList.add("open");
    };
    const where = ({ name, position, unit, phase }) =>
      [`${name} = ${figures(position, 4)}${unit ? ` ${unit}` : ""}`, phase];
    const tell = (state, open, forces, efforts) => {
      const said = [...where(state), ...data.efforts.map(({ name, unit, factor }, k) =>
        `${name} ${figures(factor * efforts[k])} ${unit}`)];
      find("reading").textContent = said.filter(Boolean).join(" · ");
      const key = find("on");
      key.hidden = open === null;
      if (open !== null) {
        const own = data.pins.map(({ name, part }, k) =>
          part === open ? `${name} ${forceText(forces[k])}` : "").filter(Boolean);
        key.textContent = `forces on ${data.names[open]}, which is drawn thick: ${own.join(", ")}.`;
      }
      svg.setAttribute("aria-label",
        `The mechanism at ${where(state).filter(Boolean).join(", ")}, with the forces at its pins`);
      now(state.cycle, forces);
    };
    const now = (cycle, forces) => {
      for (const table of figure.querySelectorAll("table[data-cycle]"))
        for (const cell of table.querySelectorAll("td[data-now]"))
          cell.textContent = Number(table.dataset.cycle) === cycle
            ? figures(cell.dataset.factor * forces[cell.dataset.pin]) : "–";
    };
    const rest = (state) => { // a measured run: nobody knows where the bodies are
      find("reading").textContent =
        [...where(state), "no motion is known of this run"].filter(Boolean).join(" · ");
      find("on").hidden = true;
      for (const arrow of svg.querySelectorAll(".arrow")) draw(arrow, "");
      now(state.cycle, []);
    };
    const draw = (element, d) => element.setAttribute("d", d);
    const line = (element, x1, y1, x2, y2) => {
      for (const [name, value] of Object.entries({ x1, y1, x2, y2 }))
        element.setAttribute(name, value);
    };

    ballesta.onPosition(show);
    figure.dataset.state = "ready";
  };

  if (figure && block)
    unzippedJson(block.textContent, "the motion").then(start).catch((error) => {
      figure.dataset.state = "failed"; // the picture stays as it was drawn
      find("reading").textContent += ` · it cannot move here: ${error.message}`;
    });
}
