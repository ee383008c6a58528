// Sliders of what a formula follows: the verdict under other settings, an estimate at once.
{
  const section = document.getElementById("what-if");
  const start = ({ levers, checks, command, doubted, load, loaded }) => {
    const [near, other] = section.querySelectorAll(".levers");
    const [told, list, line] = ["p[role=status]", "ul", "pre"].map((c) => section.querySelector(c));
    const places = levers.map((lever) => lever.now);
    const moved = (k) => places[k] !== levers[k].now;
    const grave = ["FAIL", "UNDECIDED", "pass"];

    const judged = (check) => { // safety, required, status, and utilisation at the bars' upper end
      const place = check.levers.reduce((at, k) => at * levers[k].texts.length + places[k], 0);
      const open = check.shared && levers.some((lever, k) => lever.material && moved(k));
      const pressed = check.pins.filter(({ lever }) => moved(lever));
      const row = pressed.length === 1 ? pressed[0].rows[places[pressed[0].lever]] : null;
      const known = open || (pressed.length && !row) ? null : check.safety[place];
      const [ratio, upper, lower] = row ?? [1, check.upper, check.lower];
      const factor = Number(levers[load].texts[places[load]]) / loaded;
      const safety = known === null ? null : known / ratio / factor ** check.load;
      const required = check.fixed ? check.required
        : Number(levers[check.required].texts[places[check.required]]);
      if (safety === null) return { check, status: "not followed" };
      const use = required / safety, top = use * (upper / ratio || Infinity);
      const least = lower === null ? 0 : use * (lower / ratio);
      const status = top <= 1 ? "pass" : least > 1 ? "FAIL" : "UNDECIDED";
      return { check, safety, required, status, top: upper === null ? use : top };
    };
    const down = (value) => { // rounded down to four digits
      const step = 10 ** (3 - Math.floor(Math.log10(value)));
      return String(Math.floor(value * step * (1 + 1e-12)) / step);
    };

    const show = () => {
      const all = checks.map(judged), known = all.filter((each) => each.status !== "not followed");
      const [worst] = known.sort((a, b) =>
        grave.indexOf(a.status) - grave.indexOf(b.status) || b.top - a.top);
      const left = all.length - known.length; // what is not followed may fail
      const verdict = worst && (worst.status !== "pass" || !(doubted || left)) ? worst.status : "UNDECIDED";
      const changed = places.some((_, k) => moved(k));
      const [badge, text] = told.children;
      told.className = `what-if-told ${verdict}`;
      badge.textContent = verdict.toUpperCase();
      text.textContent = [
        worst ? `${changed ? "Estimate" : "As checked"}: ${worst.check.name}, safety ` +
          `${down(worst.safety)} (${worst.required} required)` : "",
        left ? `${left} ${left > 1 ? "checks are" : "check is"} not followed` : "",
        worst?.status === "pass" && doubted ? "a validity check of the loads does not hold" : "",
      ].filter(Boolean).join("; ");
      list.replaceChildren(...all.filter((each) => each.status !== each.check.status).map((each) => {
        const item = document.createElement("li");
        item.textContent = `${each.check.name}: ${each.check.status} → ${each.status}` +
          (each.safety ? `, safety ${down(each.safety)} (${each.required})` : "");
        return item;
      }));
      line.textContent = [command, ...levers.flatMap((lever, k) =>
        moved(k) ? [`--set ${lever.sets[places[k]]}`] : [])].join(" ");
    };

    const first = new Set(checks.filter((check) => check.governs)
      .flatMap((check) => [load, ...check.levers, ...check.pins.map(({ lever }) => lever), ...(check.fixed ? [] : [check.required])]));
    levers.forEach((lever, k) => {
      const label = document.createElement("label"), slider = document.createElement("input");
      const value = document.createElement("output");
      Object.assign(slider, { type: "range", min: 0, max: lever.texts.length - 1, value: lever.now });
      const set = () => {
        places[k] = Number(slider.value);
        value.textContent = lever.texts[places[k]];
        slider.setAttribute("aria-valuetext", value.textContent);
        label.classList.toggle("moved", moved(k));
      };
      slider.addEventListener("input", () => { set(); show(); });
      label.append(lever.title, value, slider);
      (first.has(k) ? near : other).append(label);
      set();
    });
    other.parentElement.hidden = !other.children.length;
    show();
    section.hidden = false;
  };
  if (section) start(JSON.parse(document.getElementById("what-if-data").textContent));
}
