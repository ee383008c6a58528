// The picture of the live view: what is drawn where, what is written on it, what the pointer meets.
// `view` is the state that app.js keeps: drawn bodies, camera, range of colours, and so on.

const SIGNED = ["principal", "mean"]; // fields whose zero stands in the middle of the colours
const BANDS = 10;

// The colour map in use: a field of two signs has its own unless turbo is chosen, a utilisation
// with a limit its own until another is chosen.
const mapOf = (view) => {
  const { field, shown } = view;
  if (SIGNED.includes(field)) return shown.map === "turbo" ? "turbo" : "signed";
  return shown.map || (hasLimit(view) ? "use" : "viridis");
};
// Whether 1 is the limit of the field that is shown: a finite life is counted otherwise.
const hasLimit = ({ field, drawn }) => field in SHARES || (field === "utilisation" &&
  drawn.every(({ part }) => !hasField(part, field) || part.head.limits.fatigue));

// Light grey where little is used, blue towards 1, and one hard change there, to red. The picture
// rounds a share of the range to one of 256 colours: `to` is such that the change is at 1.
const useTable = (most, { low: LOW, high: HIGH, least }) => {
  let last = least; // colour of the largest utilisation that is allowed
  while (last > 8 && 255 / (last + 0.5) < most) last -= 1;
  const table = new Uint8Array(768);
  for (let k = 0; k < 256; k++) {
    const stops = k <= last ? LOW : HIGH;
    const share = k <= last ? k / last : (k - last - 1) / (254 - last || 1);
    const at = share * (stops.length - 1), low = Math.min(Math.floor(at), stops.length - 2);
    for (let c = 0; c < 3; c++)
      table[3 * k + c] = Math.round(stops[low][c] + (at - low) * (stops[low + 1][c] - stops[low][c]));
  }
  return { table, to: 255 / (last + 0.5) };
};

// Which values the colours stand for: {from, to, table, bands, title}, or null without a field.
const rangeOf = ({ drawn, field, shown, section, tables, heads }, unit) => {
  const found = drawn.map((body) => body.found).filter(Boolean);
  if (!found.length) return null;
  const scales = shown.shared ? heads.map((head) => head.scale?.[field]).filter(Boolean) : found;
  const ends = shown.own && !shown.shared ? found.map((f) => [f.min, f.max])
    : scales.map((scale) => [scale.from, scale.to]);
  let from = Math.min(...ends.map((pair) => pair[0]));
  let to = Math.max(...ends.map((pair) => pair[1]));
  const signed = SIGNED.includes(field);
  if (signed) {
    to = Math.max(Math.abs(from), Math.abs(to));
    from = -to;
  } else from = Math.min(0, from);
  if (!(to > from)) to = from + 1;
  const name = mapOf({ drawn, field, shown });
  const title = `${section.titles[field]}${unit ? ` [${unit}]` : ""}`;
  const bands = shown.bands && name !== "use" ? BANDS : 0; // no band goes across the limit
  if (name === "use") return { from: 0, ...useTable(to, section.use), bands, title };
  return { from, to, table: tables[name], bands, title };
};

const pictureOf = (view) => {
  const { camera, canvas } = view;
  const context = canvas.getContext("2d");
  const overlay = new Overlay(context, getComputedStyle(view.root).fontFamily);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let fitted = true; // the camera stands where it was put, not where the reader turned it

  const measure = () => {
    const wide = canvas.clientWidth, tall = canvas.clientHeight;
    if (!wide || !tall || (wide === camera.width && tall === camera.height)) return;
    camera.resize(wide, tall);
    if (fitted) camera.fit();
  };

  // Show all of what is drawn, wherever it moves, as one of the views turns it; without a turn as
  // it stands, with "first" so that the place is seen: the peak, or what is held.
  const frame = (turn) => {
    measure();
    const motion = view.motionNow(), [body] = view.drawn;
    if (!body) return;
    camera.margin = { left: 32, right: camera.width < 480 ? 64 : 100, top: 56, bottom: 64 };
    const points = view.isLinkage() && motion
      ? cornersOver(motion, view.drawn) : body.part.positions;
    if (turn === "first") {
      const place = view.held ??
        (view.worst && { body: view.worst, node: view.worst.found.node });
      const shows = (each) => {
        camera.turn = each;
        return !spotOf(place.body, place.node).hidden;
      };
      camera.turn = (place && FIRST_VIEWS.find(shows)) ?? VIEWS.iso;
    } else if (turn) camera.turn = turn;
    camera.fit(points);
    fitted = true;
    view.ask();
  };
  const moved = (change) => {
    change(camera);
    fitted = false;
    view.ask();
  };

  const screenOf = (body) => { // vertices on the screen, projected once for each change
    const rows = camera.pixels(body.pose), key = `${body.stamp} ${rows.join()}`;
    if (body.screenKey !== key) {
      body.screenKey = key;
      project(rows, body.shape, body.screen);
    }
    return body.screen;
  };
  // A node on the screen, and whether any triangle of any body covers it.
  const spotOf = (body, node) => {
    const [x, y, depth] = screenOf(body).subarray(3 * node, 3 * node + 3);
    const floor = depth + 1e-5 * camera.reach();
    const hidden = view.drawn.some((each) => pick(screenOf(each), each.part.triangles, x, y,
      { floor, spared: each === body ? node : -1, nodes: each.part.node }));
    return { x, y, hidden };
  };
  // What lies under a point of the picture: {body, corner, weights}, or null.
  const under = ({ x, y }) => {
    let best = null;
    for (const body of view.drawn) {
      const floor = best?.depth ?? -Infinity;
      const hit = pick(screenOf(body), body.part.triangles, x, y, { floor });
      if (hit) best = { ...hit, body };
    }
    return best;
  };

  const paint = (printed = false) => {
    const { scene, range } = view;
    if (!scene || scene.isLost || !view.isReady()) return;
    measure();
    const ratio = Math.min(devicePixelRatio || 1, 2), { width, height } = camera;
    const pixels = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== pixels[0] || canvas.height !== pixels[1])
      [canvas.width, canvas.height] = pixels;
    const night = dark.matches && !printed;
    scene.draw(view.drawn, camera, {
      ...(range ?? { table: view.tables.viridis, from: 0, to: 1, bands: 0 }),
      plain: night ? [0.46, 0.49, 0.54] : [0.74, 0.77, 0.8],
      ink: night ? [0.02, 0.02, 0.03, 0.65] : [0.05, 0.06, 0.08, 0.55],
    }, ratio);
    overlay.begin(width, height, ratio, printed ? PRINTED : screenColours(view.root));
    context.clearRect(0, 0, width, height);
    if (printed) context.drawImage(scene.canvas, 0, 0, width, height); // both in one picture
    annotate();
    view.find("empty").textContent = view.empty;
    view.find("empty").hidden = !view.empty;
  };

  const annotate = () => {
    const { drawn, range, shown, worst, held, pointer, section } = view;
    if (view.isLinkage() && drawn.length) surroundings();
    if (shown.forces && drawn.length) forces();
    if (range) overlay.colourBar(range, limits());
    if (drawn.length) overlay.axes(camera);
    if (view.isBuckled()) {
      const by = view.isEstimate() ? "buckling mode, an estimate" : "buckling mode";
      overlay.text(`${by}, its size is free`, 14, 58, { tone: "soft", halo: true });
    }
    if (view.isDeformed())
      overlay.text(`deformation × ${figures(view.factorOf(drawn[0]), 2)}`, 14, 58,
        { tone: "soft", halo: true });
    view.marker = null;
    if (worst) {
      const spot = spotOf(worst, worst.found.node);
      const of = view.isLinkage() ? `${section.names[worst.index]}: ` : "";
      const value = view.text(worst.found.peak, 3, worst);
      const named = worst.part.head.estimated ? "estimate" : "peak";
      const words = `${of}${named} ${value}${spot.hidden ? ", hidden" : ""}`;
      overlay.marker(spot.x, spot.y, words, spot);
      view.marker = { ...spot, words };
    }
    if (held) {
      const spot = spotOf(held.body, held.node);
      const words = held.words || (held.body.found
        ? view.text(held.body.nodal[held.node], 3, held.body) : "held point");
      const near = view.marker && Math.abs(view.marker.y - spot.y) < 24 &&
        Math.abs(view.marker.x - spot.x) < 160;
      overlay.marker(spot.x, spot.y, words, { ...spot, square: true, below: near });
    }
    const hit = pointer && under(pointer), value = view.readings.probe(hit);
    if (pointer && value !== null)
      overlay.label(pointer.x, pointer.y - 22, view.text(value, 3, hit.body));
  };

  const limits = () => { // lines across the colour bar
    const least = (name, label) => {
      const known = view.drawn.map((body) => body.part.head.limits?.[name]).filter(Boolean);
      return known.length ? [{ value: Math.min(...known), label }] : [];
    };
    if (view.field === "utilisation") return least("fatigue", "limit");
    if (view.field in SHARES) return [{ value: 1, label: "limit" }];
    return view.field === "mises"
      ? [...least("allowed", "allowed"), ...least("yield", "yield")] : [];
  };

  // Ground, guides, what slides in them and cylinders of the mechanism's picture, which has the
  // machine's mm with y down, as the camera sees the plane z = 0.
  const surroundings = () => {
    const svg = document.querySelector("#mechanism svg"), back = svg?.getScreenCTM()?.inverse();
    if (!back || svg.classList.contains("still")) return;
    const rows = camera.pixels();
    const [o, x, y] = [[0, 0], [1, 0], [0, -1]].map(([a, b]) => placed(rows, a, b, 0));
    const seen = new DOMMatrix([x[0] - o[0], x[1] - o[1], y[0] - o[0], y[1] - o[1], o[0], o[1]]);
    const thin = new Path2D(), thick = new Path2D();
    for (const each of svg.querySelectorAll(".pivot, .hatch, .rail, .block, .rod, .barrel")) {
      const own = new Path2D(each.getAttribute("d") ?? "");
      const of = (name) => Number(each.getAttribute(name));
      if (each.tagName === "line") {
        own.moveTo(of("x1"), of("y1"));
        own.lineTo(of("x2"), of("y2"));
      } else if (each.tagName === "rect") own.rect(of("x"), of("y"), of("width"), of("height"));
      const at = seen.multiply(back.multiply(each.getScreenCTM()));
      (each.classList.contains("barrel") ? thick : thin).addPath(own, at);
    }
    overlay.outline(thin, 1.5);
    overlay.outline(thick, 7);
  };

  // Forces on the parts at their pins: all in the linkage, those on the part in its own frame.
  const forces = () => {
    const motion = view.motionNow();
    if (!motion || !(motion.most > 0)) return;
    const row = rowIn(motion.index, positions.current.index), rows = camera.pixels();
    const own = view.isLinkage() ? null : poseAt(motion.parts[view.shown.tab], row);
    if (!view.isLinkage() && !own) return;
    const pins = motion.pins.filter((pin) => (own ? pin.on === view.shown.tab : !pin.minor));
    if (!pins.length) return;
    const long = Math.min(own ? 110 : 80, 0.2 * camera.width); // px of the cycle's largest force
    const mm = long / camera.scale / motion.most;
    const c = own ? Math.cos(own.angle) : 1, s = own ? Math.sin(own.angle) : 0;
    const { x: x0, y: y0, z: z0 } = own ?? NO_POSE;
    for (const pin of pins) {
      const [dx, dy] = [atRow(pin.x, row) - x0, atRow(pin.y, row) - y0];
      const [fx, fy] = [mm * atRow(pin.fx, row), mm * atRow(pin.fy, row)];
      const [x, y, z] = [c * dx + s * dy, c * dy - s * dx, pin.z - z0];
      const tail = placed(rows, x, y, z);
      const head = placed(rows, x + c * fx + s * fy, y + c * fy - s * fx, z);
      overlay.arrow(tail[0], tail[1], head[0], head[1]);
    }
    const told = roundStep(0.3 * motion.most, 1);
    overlay.forceScale(told / motion.most * long, forceText(told));
  };

  // Turn to where a node is seen, as squarely as can be, and go near it.
  const goTo = (body, node) => {
    const { normals } = body.part, { angle } = body.pose, c = Math.cos(angle), s = Math.sin(angle);
    const [nx, ny, nz] = normals.subarray(3 * node, 3 * node + 3);
    const n = [c * nx - s * ny, s * nx + c * ny, nz], iso = rowsOf(VIEWS.iso).slice(6);
    const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    const towards = (way) => dot(way, n) + 0.5 * dot(way, iso); // a little from above and aside
    const ways = spiral(200).sort((a, b) => towards(b) - towards(a));
    const seen = ways.find((way) => {
      if (!(dot(way, n) > 0.1)) return false;
      camera.turn = facing(...way);
      return !spotOf(body, node).hidden;
    });
    camera.turn = facing(...(seen ?? n));
    camera.fit();
    const { x, y } = spotOf(body, node);
    moved(() => {
      camera.pan(camera.width / 2 - x, camera.height / 2 - y);
      camera.zoom(2.5);
    });
  };

  dark.addEventListener("change", view.ask);
  new ResizeObserver(view.ask).observe(canvas);
  return { paint, frame, moved, under, goTo, isFitted: () => fitted };
};
