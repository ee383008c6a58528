// What the reader does with the live view: tabs, tools, and pointer and keys on the picture.
// `on` holds a function for each wish; nothing here knows what comes of it.

const bindTabs = (list, choose) => {
  const tabs = [...list.querySelectorAll("[role=tab]")];
  const show = (tab) => {
    for (const each of tabs) {
      each.setAttribute("aria-selected", String(each === tab));
      each.tabIndex = each === tab ? 0 : -1;
    }
    document.getElementById(tab.getAttribute("aria-controls"))
      .setAttribute("aria-labelledby", tab.id);
    // In the row only: scrollIntoView would move the page, too.
    const { offsetLeft: left, offsetWidth: wide } = tab;
    if (left < list.scrollLeft) list.scrollLeft = left;
    else if (left + wide > list.scrollLeft + list.clientWidth)
      list.scrollLeft = left + wide - list.clientWidth;
  };
  const open = (tab) => {
    show(tab);
    choose(Number(tab.dataset.part));
  };
  list.addEventListener("click", (event) => {
    const tab = event.target.closest("[role=tab]");
    if (tab) open(tab);
  });
  list.addEventListener("keydown", (event) => {
    const at = tabs.indexOf(document.activeElement), count = tabs.length;
    const next = {
      ArrowRight: at + 1, ArrowDown: at + 1, ArrowLeft: at - 1, ArrowUp: at - 1,
      Home: 0, End: count - 1,
    }[event.key];
    if (next === undefined || at < 0) return;
    event.preventDefault();
    const tab = tabs[(next + count) % count];
    tab.focus();
    open(tab);
  });
  return (part) => {
    const tab = tabs.find((each) => Number(each.dataset.part) === part);
    if (tab) show(tab);
  };
};

const bindTools = (find, on) => {
  for (const name of ["field", "map"])
    find(name).addEventListener("change", (event) => on[name](event.target.value));
  for (const name of ["bands", "own", "shared", "deformed", "mode", "forces"])
    find(name)?.addEventListener("change", (event) => on[name](event.target.checked)); // one part: no "shared"
  find("factor").addEventListener("input", (event) => on.factor(Number(event.target.value)));
  find("factor-auto").addEventListener("click", () => on.factor(0));
};

// Show the map in use; those of fields with two signs, of utilisations and of the others are open
// for these alone.
const showMap = (select, used, field, utilised) => {
  const signed = SIGNED.includes(field);
  for (const { value } of select.options) {
    const other = value === "signed" ? !signed : value === "use" ? !utilised
      : signed && value !== "turbo";
    const option = select.querySelector(`option[value=${value}]`);
    option.hidden = option.disabled = other;
  }
  select.value = used;
};

// One finger or button turns; shift, the right button or two fingers move; two fingers also zoom.
const bindPicture = (canvas, on) => {
  const fingers = new Map();
  const CLICK = 4; // px that a click may move
  let travelled = 0;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  };
  const spread = () => {
    const [a, b] = [...fingers.values()];
    return { x: (a.x + b.x) / 2, y: (a.y + b.y) / 2, wide: Math.hypot(a.x - b.x, a.y - b.y) };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
    if (fingers.size === 0) travelled = 0;
    fingers.set(event.pointerId, place(event));
    on.hover(null);
  });
  canvas.addEventListener("pointermove", (event) => {
    const to = place(event), from = fingers.get(event.pointerId);
    if (!from) { on.hover(to); return; }
    const dx = to.x - from.x, dy = to.y - from.y;
    travelled += Math.hypot(dx, dy);
    if (fingers.size >= 2) {
      const before = spread();
      fingers.set(event.pointerId, to);
      const after = spread();
      on.pan(after.x - before.x, after.y - before.y);
      on.zoom(after.wide / Math.max(before.wide, 1), after.x, after.y);
      return;
    }
    fingers.set(event.pointerId, to);
    if (event.shiftKey || event.buttons & 6) on.pan(dx, dy); else on.orbit(dx, dy);
  });
  const release = (event) => {
    const at = fingers.get(event.pointerId);
    fingers.delete(event.pointerId);
    if (event.type === "pointerup" && at && fingers.size === 0 && travelled < CLICK) on.hold(at);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("pointerleave", () => on.hover(null));
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("wheel", (event) => {
    // Without focus the wheel scrolls the page, as everywhere else.
    if (document.activeElement !== canvas && !event.ctrlKey) return;
    event.preventDefault();
    const { x, y } = place(event);
    const lines = event.deltaMode === 1 ? 16 : 1;
    on.zoom(Math.exp(-0.0015 * lines * event.deltaY), x, y);
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const step = {
      ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1],
    }[event.key];
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (step) {
      if (event.shiftKey) on.pan(30 * step[0], 30 * step[1]);
      else on.orbit(24 * step[0], 24 * step[1]);
    } else if (event.key === "+" || event.key === "=") on.zoom(1.25);
    else if (event.key === "-") on.zoom(0.8);
    else if (event.key === " ") on.toggle();
    else if (event.key === "Escape") on.hold(null);
    else return;
    event.preventDefault();
  });
};

// A table row for each place: words, value, and a button that shows it.
const fillPlaces = (body, rows, see) => {
  const cell = (tag, text, kind) => Object.assign(
    document.createElement(tag), { textContent: text, className: kind });
  body.replaceChildren(...rows.map((row) => {
    const line = document.createElement("tr"), last = document.createElement("td");
    const head = cell("th", row.place, "k");
    head.scope = "row";
    const button = cell("button", "show", "");
    button.type = "button";
    button.setAttribute("aria-label", `show ${row.place}`);
    button.addEventListener("click", () => see(row));
    last.append(button);
    line.append(head, cell("td", row.value, "n"), last);
    return line;
  }));
};
