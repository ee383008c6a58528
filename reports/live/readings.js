// What the live view says in words: peaks, the point under the pointer, a held point, limits.

const element = (tag, text, more = {}) =>
  Object.assign(document.createElement(tag), { textContent: text, ...more });

const sentence = (words) =>
  `${words[0].toUpperCase()}${words.slice(1)}${/[.!?]$/.test(words) ? "" : "."}`;

const readingsOf = (view) => {
  const { find, section } = view;

  const ownerOf = (body) => (view.isLinkage() ? `${section.names[body.index]}: ` : "");
  const placeOf = (body, node) => {
    const place = body.part.positions.subarray(3 * node, 3 * node + 3);
    return ownerOf(body) + placeText(place);
  };
  const write = (role, strong, small) => {
    const parts = [];
    if (strong) parts.push(element("b", strong));
    if (small) parts.push(element("small", small));
    find(role).replaceChildren(...parts);
  };

  const titleOf = (field) => (field ? `Colours: ${section.long_titles[field].replace(/^\w(?=[a-z])/, (a) => a.toLowerCase())}` +
    `${hasLimit(view) ? " (limit: 1)" : ""}` +
    `${view.isEstimate() ? ", an estimate from section forces" : ""}.` : "");

  // All of it, at every change of position, field or part.
  const tell = () => {
    const { worst, field, range, drawn } = view, over = field && isConstant(field);
    find("peak-name").textContent = over || !positions.current
      ? "Peak over the duty" : `Peak at ${positions.text(view.cycle(), positions.current.index)}`;
    const unknown = drawn.some((body) => body.plain) ? "; grey parts are not counted" : "";
    if (worst)
      write("peak", view.text(worst.found.peak, 4, worst),
        placeOf(worst, worst.found.node) + unknown);
    else write("peak", "–", view.empty ||
      (field ? "this cycle does not load it" : "no field of stress is known"));
    const most = field === "mises" || !field ? view.mostOfCycle() : null;
    const decides = field && drawn.every((body) => body.part.head.decides);
    find("worst-name").textContent = !most ? "Colour scale" : decides
      ? "Peak of the cycle, by the solver" : "Largest stress of the cycle, by what decides";
    find("worst-go").hidden = !most;
    if (most)
      write("worst", `${figures(most.most, 4)} MPa`, `at ${positions.text(view.cycle(), most.at)}`);
    else if (range) write("worst", `${figures(range.from)} to ${view.text(range.to, 3)}`, "");
    else write("worst", "–", "");
    const head = drawn[0]?.part.head;
    const told = view.isLinkage()
      ? [section.layers, view.motionNow() ? "Arrows: forces on the parts at their pins."
        : section.gaps[positions.current?.cycleName] ?? ""]
      : [field === "mises" && head?.accuracy?.words, ...(head?.notes ?? []), view.unmoved];
    find("told").textContent = told.filter(Boolean).map(sentence).join(" ");
    find("caption").textContent = view.told ? `${view.told}. ${titleOf(field)}` : titleOf(field);
    find("factor-box").hidden = !view.isDeformed();
    if (view.isDeformed())
      find("factor-told").textContent = `× ${figures(view.factorOf(drawn[0]), 2)}`;
    const title = view.isLinkage() ? "Whole linkage" : section.names[view.shown.tab];
    const spoken = worst && `, ${section.titles[field]}: ` +
      `peak ${view.text(worst.found.peak, 3, worst)} at ${placeOf(worst, worst.found.node)}`;
    view.canvas.setAttribute("aria-label", `${title}${spoken ?? ""}`);
    held();
    hottest();
  };

  // The fields that cannot be chosen, and why.
  const missing = () => {
    const why = new Map(); // words -> names of the fields
    for (const { part } of view.isLinkage() ? [] : view.drawn)
      for (const name of FIELDS) {
        const words = hasField(part, name) ? "" : whyNot(part, name);
        if (words && !part.head.notes?.includes(words))
          why.set(words, [...(why.get(words) ?? []), section.titles[name]]);
      }
    find("missing").replaceChildren(...[...why].map(([words, names]) =>
      element("li", `Not shown (${names.join("; ")}): ${words}`)));
    find("missing").hidden = why.size === 0;
  };

  // The point under the pointer; returns its value, null where there is none.
  const probe = (hit) => {
    view.probe = null;
    if (!hit) {
      write("probe", "", view.pointer ? "beside the part" : "move over the part");
      return null;
    }
    const { body, corner, weights } = hit, { triangles, positions: at } = body.part;
    const blend = (list, size, k) => weights.reduce(
      (sum, weight, c) => sum + weight * list[size * triangles[corner + c] + k], 0);
    const value = body.found ? blend(body.values, 1, 0) : null;
    const place = [0, 1, 2].map((k) => blend(at, 3, k));
    write("probe", value === null ? "–" : view.text(value, 4, body),
      ownerOf(body) + placeText(place));
    view.probe = { part: body.index, value, place };
    return value;
  };

  // The held point: value, place, and the six components with what follows from them.
  const held = () => {
    find("pinned-box").hidden = !view.held;
    if (!view.held) return;
    const { body, node } = view.held, { part } = body;
    write("pinned", body.found ? view.text(body.nodal[node], 4, body) : "–", placeOf(body, node));
    const stress = part.head.fields
      ? stressAt(part, view.cycle(), positions.current?.index ?? 0, node) : null;
    if (!stress) return;
    const told = (value, field) => within(value, view.offOf(body, field), 4);
    const rows = ["xx", "yy", "zz", "xy", "yz", "zx"].map((name, k) =>
      [`σ ${name}`, told(stress[k], "principal")]); // no component is off by more than a principal
    rows.push(...principalsOf(stress).map((value, k) => [`σ ${k + 1}`, told(value, "principal")]));
    rows.push(["von Mises", told(misesOf(stress), "mises")]);
    const table = element("table", ""), half = rows.length / 2;
    table.append(element("caption", "Stress there [MPa]"));
    for (let k = 0; k < half; k++) {
      const line = table.insertRow();
      for (const [name, value] of [rows[k], rows[k + half]])
        line.append(element("th", name, { scope: "row" }),
          element("td", value, { className: "n" }));
    }
    find("pinned").append(table);
  };

  // The table of the largest values that lie apart from each other.
  const hottest = () => {
    const box = find("hottest"), MOST = 8;
    if (!box.open || positions.current?.playing) return;
    const [low, high] = view.camera.bounds;
    const apart = (0.03 * Math.hypot(...low.map((v, axis) => high[axis] - v))) ** 2;
    const rows = [];
    const far = (body, node) => rows.every((row) => {
      const at = body.part.positions;
      const square = (k) => (at[3 * node + k] - at[3 * row.node + k]) ** 2;
      return row.body !== body || square(0) + square(1) + square(2) > apart;
    });
    while (rows.length < MOST) {
      let best = null, size = 0;
      for (const body of view.drawn)
        for (let node = 0; body.found && node < body.part.n; node++) {
          const value = Math.abs(body.nodal[node]);
          if (value > size && far(body, node)) [size, best] = [value, { body, node }];
        }
      if (!best) break;
      const { body, node } = best;
      const value = view.text(body.nodal[node], 4, body);
      rows.push({ body, node, place: placeOf(body, node), value });
    }
    find("hottest-told").textContent = view.field
      ? `${section.titles[view.field]}: the largest values that lie apart` : "No field is shown";
    fillPlaces(box.querySelector("tbody"), rows, ({ body, node }) => view.hold(body, node, true));
  };
  find("hottest").addEventListener("toggle", hottest);

  return { tell, missing, probe, held };
};
