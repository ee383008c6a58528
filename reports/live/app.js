// The live view: opens parts, keeps what is shown, and draws when something changed.

const LINKAGE = -1; // the tab of all parts together
const SWINGS = 4000; // ms that a buckling mode moves once it is shown; two swings

// The curve of the peak behind the slider; it follows the part, needs no WebGL.
const trackOf = (root, section, partShown) => {
  const canvas = root.querySelector("[data-role=curve]");
  const curves = section.curves.map((each) =>
    each.map((curve) => curve && { ...curve, heights: bytesOf(curve.heights) }));
  const mostOf = (cycle) => { // the curve of the part, of the most stressed one in the linkage
    const part = partShown();
    const some = (part < 0 ? curves : [curves[part] ?? []]).map((each) => each[cycle]);
    return some.filter(Boolean).sort((a, b) => b.most - a.most)[0] ?? null;
  };
  const runs = positions.cycles.map(({ phase, phase_of: of }) => {
    const found = [];
    of.forEach((k, index) => {
      if (index && of[index - 1] === k) found[found.length - 1].to = index;
      else {
        if (index) found[found.length - 1].to = index;
        found.push({ name: phase[k], from: index, to: index });
      }
    });
    return found;
  });
  let frame = 0;
  const draw = () => {
    frame = 0;
    const { cycle, index } = positions.current ?? {};
    if (cycle === undefined) return;
    const last = positions.last(cycle), curve = mostOf(cycle);
    drawCurve(canvas, {
      heights: curve?.heights ?? [], phases: runs[cycle], last, share: last ? index / last : 0,
      colours: screenColours(root),
      series: getComputedStyle(root).getPropertyValue("--chart-series0").trim(),
    });
  };
  const ask = () => { frame ||= requestAnimationFrame(draw); };
  positions.onPosition(ask);
  new ResizeObserver(ask).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", ask);
  return { mostOf, ask };
};

const sizeOf = ([low, high]) => Math.hypot(...[0, 1, 2].map((k) => high[k] - low[k]));

const liveView = (root) => {
  const find = (role) => root.querySelector(`[data-role=${role}]`);
  const page = document.documentElement;
  const { parts: heads } = jsonOf("live-header"), section = jsonOf("live-section");
  const motionText = document.getElementById("live-motion")?.textContent;
  const bodies = new Map(); // index of a part -> promise of its body
  let frame = 0, motion = null, opened = Promise.resolve(), pickTab = () => {};
  const view = {
    root, find, section, canvas: find("canvas"), camera: new Camera(), scene: null,
    tables: Object.fromEntries(
      Object.entries(section.maps).map(([name, text]) => [name, bytesOf(text)])),
    shown: { // what the reader chose; map "": the field's own
      tab: section.first, field: section.shown?.field ?? "mises", map: "", bands: false, own: false,
      shared: false, deformed: false, mode: false, forces: true, factor: 0,
    },
    heads, drawn: [], field: null, range: null, worst: null, held: null, pointer: null, empty: "",
    marker: null, probe: null, told: "", unmoved: "", // why there is no motion though the page has one
    isReady: () => page.dataset.live === "ready",
    isLinkage: () => view.shown.tab === LINKAGE,
    cycle: () => positions.current?.cycle ?? 0,
    motionNow: () => motion?.[view.cycle()] ?? null,
    mostOfCycle: () => track.mostOf(view.cycle()),
    ask: () => { frame ||= requestAnimationFrame(() => { frame = 0; picture.paint(); }); },
    unit: () =>
      view.drawn.map((body) => body.part.head.scale[view.field]?.unit).find(Boolean) ?? "",
    offOf: (body, field) => { // in the field's unit; one over the duty is in whole steps
      const head = body?.part.head;
      return isConstant(field) ? (head?.coding.fatigue[field] ?? 0) / 2
        : head?.accuracy?.[field === "displacement" ? "moved" : field]?.[view.cycle()] ?? 0;
    },
    text: (value, digits = 4, body = null) => {
      const off = view.field ? view.offOf(body, view.field) : 0;
      return `${within(value, off, digits)} ${view.unit()}`.trim();
    },
    isBuckled: () => view.shown.mode && view.drawn.some(({ part }) => part.mode),
    isDeformed: () => view.shown.deformed && !view.isBuckled() && !view.isLinkage() && view.drawn.length > 0 &&
      hasField(view.drawn[0].part, "displacement"),
    factorOf: (body) => { // displacements are drawn as 5 % of the part, times the choice
      const most = body.part.head.scale.displacement?.to ?? 0;
      const fit = most > 0 ? roundStep(0.05 * sizeOf(body.bounds) / most, 1) : 0;
      return Number((fit * 10 ** (view.shown.factor / 100)).toPrecision(2));
    },
    isEstimate: () => view.drawn.some(({ part }) => part.head.estimated),
    hold: (body, node, go = false, words = "") => {
      view.held = body && { body, node, words };
      if (body && go) picture.goTo(body, node);
      view.readings.held();
      view.ask();
    },
  };
  const track = trackOf(root, section, () => view.shown.tab);
  const picture = pictureOf(view);
  view.readings = readingsOf(view);

  const note = (words) => {
    find("note").textContent = words;
    find("note").hidden = !words;
  };
  const motionRead = (motionText ? readMotion(motionText) : Promise.resolve(null)).then(
    (read) => { motion = read; },
    ({ message }) => { view.unmoved = `No motion and no forces are shown: ${message}.`; });

  const bodyOf = (index) => {
    const head = heads[index], block = head.block && document.getElementById(head.block);
    if (!block) return null;
    if (!bodies.has(index))
      bodies.set(index, decodePart(block.textContent, head).then((part) => {
        const body = Object.assign(new Body(part), { index, bounds: head.bounds });
        view.scene.add(body);
        return body;
      }));
    return bodies.get(index);
  };
  const collect = async (tab) => { // null when the reader went on meanwhile
    if (tab === LINKAGE) await motionRead;
    const drawn = [];
    const wanted = tab !== LINKAGE ? [tab] : view.unmoved ? [] : heads.keys();
    for (const index of wanted) {
      const body = await bodyOf(index);
      if (view.shown.tab !== tab) return null;
      if (body) drawn.push(body);
    }
    return drawn;
  };
  const open = (tab) => (opened = openTab(tab));
  const openTab = async (tab) => {
    const first = page.dataset.live === undefined;
    Object.assign(view, { held: null, pointer: null, drawn: [], empty: "Reading…", told: "" });
    view.shown.tab = tab;
    positions.setPart(tab === LINKAGE ? null : section.full_names[tab]);
    track.ask();
    update();
    try {
      const drawn = await collect(tab);
      if (drawn === null) return;
      view.drawn = drawn;
      const why = tab === LINKAGE ? view.unmoved : heads[tab].notes.join(" ");
      view.empty = drawn.length ? "" : why || "There is nothing to draw.";
    } catch (error) {
      if (first) throw error;
      if (view.shown.tab !== tab) return;
      view.empty = `This part cannot be shown: ${error.message}`;
    }
    for (const body of view.drawn) body.key = "";
    if (first) page.dataset.live = "ready"; // only now the canvas has a size
    chooseField();
    update();
    if (first && tab === section.shown?.part) {
      point(section.shown);
      buckle(section.shown.mode);
    }
    picture.frame(look());
    picture.paint();
  };

  // A linkage is seen along its pins, as long as it does not buckle out of its plane.
  const look = () =>
    view.isLinkage() ? VIEWS[view.isBuckled() ? "iso" : "front"] : "first";

  // Tell of a check, and hold its place where that is not the peak of what is shown.
  const point = ({ at, told, short }) => {
    view.told = told;
    const [body] = view.drawn;
    if (at && body && !view.isLinkage()) {
      const places = body.part.positions, size = sizeOf(body.bounds);
      const far = (node) => Math.hypot(...at.map((v, k) => v - places[3 * node + k]));
      let near = 0;
      for (let node = 1; node < body.part.n; node++) if (far(node) < far(near)) near = node;
      const peak = Math.abs(body.found?.peak ?? NaN);
      if (view.isEstimate() || !body.found) view.hold(body, near, false, short);
      else if (Math.abs(body.nodal[near]) > 0.998 * peak)
        body.found.node = near; // one of two equal ones
      else if (!(far(body.found.node) < 0.01 * size)) view.hold(body, near);
    }
    view.readings.tell();
  };
  // Show what a check means: its part, position, field and place.
  const show = async (wanted) => {
    const { part, position, field, mode } = wanted;
    view.shown.field = field;
    if (position) positions.setPosition(...position);
    if (part !== view.shown.tab) {
      pickTab(part);
      await open(part);
    } else {
      view.hold(null);
      chooseField();
      update();
    }
    if (view.shown.tab !== part) return; // the reader went on
    buckle(mode);
    point(wanted);
    picture.frame(look());
  };

  // The field that was asked for where the parts have it, else the first that they have.
  const chooseField = () => {
    const has = (name) => view.drawn.some((body) => hasField(body.part, name));
    view.field = [view.shown.field, ...FIELDS].find(has) ?? null;
    for (const option of find("field").options) option.disabled = !has(option.value);
    find("field").disabled = !view.field;
    if (view.field) find("field").value = view.field;
    find("mode-box").hidden = !view.drawn.some(({ part }) => part.mode);
    find("deformed").disabled = view.isLinkage() || !has("displacement");
    find("forces-box").hidden = !motion?.some((each) => each?.pins.length);
    view.readings.missing();
  };

  // Superpose the fields of all that is drawn at the page's position.
  const update = () => {
    const cycle = view.cycle(), index = positions.current?.index ?? 0;
    const moving = view.isLinkage() ? view.motionNow() : null;
    view.worst = null;
    const row = moving && rowIn(moving.index, index);
    for (const body of view.drawn) {
      fill(body, cycle, index);
      shape(body, cycle, index);
      body.pose = (moving && poseAt(moving.parts[body.index], row)) ?? NO_POSE;
      if (body.found && !(Math.abs(view.worst?.found.peak) >= Math.abs(body.found.peak)))
        view.worst = body;
    }
    view.range = rangeOf(view, view.unit());
    showMap(find("map"), mapOf(view), view.field, hasLimit(view));
    view.readings.tell();
    view.ask();
  };
  const fill = (body, cycle, index) => {
    const { field } = view;
    const key = field && isConstant(field) ? field : `${cycle} ${index} ${field}`;
    if (body.key === key) return;
    body.key = key;
    body.found = field && hasField(body.part, field)
      ? fieldValues(body.part, cycle, index, field, body.nodal) : null;
    body.plain = body.found === null;
    if (body.plain) return;
    body.spread();
    view.scene.renew(body);
  };
  const shape = (body, cycle, index) => {
    const { mode } = body.part, buckled = view.isBuckled();
    const factor = buckled ? (mode ? swung() * modeSize() : 0)
      : view.isDeformed() ? view.factorOf(body) : 0;
    if (!factor && !body.factor) return;
    if (factor) {
      body.moved ??= new Float32Array(3 * body.part.n);
      if (buckled) mode.forEach((row, axis) => {
        for (let i = 0; i < row.length; i++) body.moved[3 * i + axis] = row[i];
      });
      else if (displacementAt(body.part, cycle, index, body.moved) === null) body.moved.fill(0);
    }
    body.deform(factor);
    body.factor = factor;
    body.stamp++;
    view.scene.renew(body, { shape: true });
  };

  // A buckling mode, drawn as 8 % of what is shown. It swings for a while once it is shown, and as
  // long as the cycle plays; it has a shape and no size.
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  let began = 0, swinging = 0, printing = false; // on paper it is at its largest
  const modeSize = () => 0.08 * Math.max(...view.drawn.map(({ bounds }) => sizeOf(bounds)));
  const swung = () => {
    const gone = performance.now() - began;
    return printing || still.matches || !(gone < SWINGS || positions.current?.playing)
      ? 1 : Math.cos((4 * Math.PI * gone) / SWINGS);
  };
  const swing = () => {
    swinging = 0;
    update();
    if (view.isBuckled() && !still.matches && performance.now() - began < SWINGS)
      swinging = requestAnimationFrame(swing);
  };
  const buckle = (wanted) => {
    view.shown.mode = Boolean(wanted);
    find("mode").checked = view.shown.mode;
    began = performance.now();
    if (!swinging) swing();
  };

  const choose = (name) => (value) => {
    view.shown[name] = value;
    if (name === "field") {
      view.told = "";
      chooseField();
    }
    if (name === "factor") find("factor").value = String(value);
    update();
  };
  const on = {
    ...Object.fromEntries(["field", "bands", "own", "shared", "deformed", "forces", "factor"]
      .map((name) => [name, choose(name)])),
    mode: buckle,
    map: (value) => choose("map")(["signed", "use"].includes(value) ? "" : value),
    orbit: (dx, dy) => picture.moved((camera) => camera.orbit(dx, dy)),
    pan: (dx, dy) => picture.moved((camera) => camera.pan(dx, dy)),
    zoom: (factor, x, y) => picture.moved((camera) => camera.zoom(factor, x, y)),
    hover: (at) => { view.pointer = at; view.ask(); },
    hold: (at) => {
      const hit = at && picture.under(at);
      if (!hit) { view.hold(null); return; }
      const corner = hit.weights.indexOf(Math.max(...hit.weights)), { part } = hit.body;
      view.hold(hit.body, part.node[part.triangles[hit.corner + corner]]);
    },
    toggle: () => transport?.toggle(),
  };
  const print = () => { // what paper shows: scene and writing in one, in the colours of paper
    if (!view.isReady()) return;
    printing = true;
    update();
    picture.paint(true);
    const printed = find("printed");
    printed.src = view.canvas.toDataURL();
    printed.alt = view.canvas.getAttribute("aria-label");
    printing = false;
    update();
    picture.paint();
  };
  const bind = () => {
    bindTools(find, on);
    bindPicture(view.canvas, on);
    for (const button of root.querySelectorAll("[data-view]"))
      button.addEventListener("click", () => {
        if (button.dataset.view !== "peak") picture.frame(VIEWS[button.dataset.view]);
        else if (view.worst) picture.goTo(view.worst, view.worst.found.node);
      });
    for (const button of root.querySelectorAll("[data-zoom]"))
      button.addEventListener("click", () => on.zoom(Number(button.dataset.zoom)));
    find("worst-go").addEventListener("click", () => {
      const most = view.mostOfCycle();
      if (most) positions.setPosition(view.cycle(), most.at);
    });
    find("unpin").addEventListener("click", () => view.hold(null));
    addEventListener("beforeprint", print);
    matchMedia("print").addEventListener("change", (event) => { if (event.matches) print(); });
    let cycle = view.cycle();
    positions.onPosition((state) => {
      update();
      if (cycle !== state.cycle && view.isLinkage() && picture.isFitted()) picture.frame();
      cycle = state.cycle;
    });
  };

  const graphics = {
    lost: () => {
      page.dataset.live = "lost";
      note("The browser took the 3-D graphics away; the picture returns when it gives them back.");
    },
    restored: () => {
      page.dataset.live = "ready";
      note("");
      for (const body of view.drawn) body.key = "";
      update();
    },
  };
  const start = async () => {
    if (view.shown.tab < 0 && !motionText) {
      note("Nothing can be drawn here: no part has a surface. The numbers stand in the tables.");
      root.classList.add("live-bare");
      page.dataset.live = "ready";
      return;
    }
    try {
      view.scene = new Scene(find("scene"), graphics);
      pickTab = bindTabs(root.querySelector("[role=tablist]"), open);
      pickTab(view.shown.tab);
      await open(view.shown.tab);
    } catch (error) {
      page.dataset.live = "failed";
      const moving = document.getElementById("mechanism")
        ? "slider, mechanism and charts" : "slider and charts";
      note(`The 3-D picture is missing: ${error.message}. Without it the ${moving} work; ` +
        "a still picture stands with each part, and every number in the tables.");
      return;
    }
    bind();
    await motionRead;
    chooseField();
    update();
  };
  const shows = (wanted) => (opened = show(wanted));
  return { view, picture, start, shows, opened: () => opened };
};

{
  const root = document.getElementById("live");
  if (root) {
    const { view, picture, start, shows, opened } = liveView(root);
    globalThis.ballesta.live = { // for the page's links, tests and benches
      show: (wanted) => (view.isReady() ? shows(wanted) : undefined),
      get tab() { return view.shown.tab; },
      get field() { return view.field; },
      get buckled() { return view.isBuckled(); },
      get peak() {
        const { worst } = view;
        return worst && { part: worst.index, value: worst.found.peak, node: worst.found.node };
      },
      get range() { return view.range && { from: view.range.from, to: view.range.to }; },
      get marker() { return view.marker; },
      get probe() { return view.probe; },
      camera: view.camera,
      draw: () => picture.paint(), // now, as when a step is timed
      context: () => view.scene.gl,
      get opened() { return started.then(opened); }, // when the chosen tab is shown, or its error
    };
    const started = start();
  }
}
