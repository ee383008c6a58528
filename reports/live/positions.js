// The position of the page: which cycle, and where in it. All that moves follows it: the live view,
// the mechanism, the charts' cursors. It needs neither WebGL nor a part that can be drawn.
// Public as globalThis.ballesta: current, setPosition(cycle, index), onPosition(callback), cycles.

const jsonOf = (id) => {
  const block = document.getElementById(id);
  return block ? JSON.parse(block.textContent) : null;
};

// So many significant digits, without an exponent where it stays readable.
const figures = (value, digits = 3) => {
  if (!Number.isFinite(value)) return "–";
  if (value === 0 || Math.abs(value) < 1e-12) return "0";
  const size = Math.floor(Math.log10(Math.abs(Number(value.toPrecision(digits)))));
  if (size < -4 || size > 6) return value.toExponential(digits - 1).replace("e+", "e");
  return value.toFixed(Math.max(0, Math.min(12, digits - 1 - size))).replace("-", "−");
};

// The same without digits that say less than what the value may be off by.
const within = (value, off, digits = 3) => {
  if (!(off > 0) || !Number.isFinite(value) || value === 0) return figures(value, digits);
  const known = Math.floor(Math.log10(Math.abs(value))) - Math.floor(Math.log10(off)) + 1;
  return known < 1 ? "0" : figures(value, Math.min(digits, known));
};

// As `figures`, without zeros at its end.
const shortest = (value, digits) => {
  const text = figures(value, digits);
  return text.includes(".") && !text.includes("e") ? text.replace(/\.?0+$/, "") : text;
};

const positions = (() => {
  const cycles = jsonOf("live-cycles") ?? [];
  const { start = null } = jsonOf("live-section") ?? {};
  const listeners = new Set();
  const at = { cycle: 0, index: 0, part: null, playing: false };
  let current = null;

  const between = (list, index) => { // linear between the positions of a cycle
    if (!list || list.length === 0) return null;
    const low = Math.min(Math.floor(index), list.length - 1);
    const high = Math.min(low + 1, list.length - 1);
    return list[low] + (index - low) * (list[high] - list[low]);
  };
  const last = (cycle) => cycles[cycle].position.length - 1;

  const tell = () => {
    if (cycles.length === 0) return;
    const cycle = cycles[at.cycle];
    const near = Math.round(at.index);
    current = Object.freeze({
      cycle: at.cycle, cycleName: cycle.name, index: at.index,
      position: between(cycle.position, at.index), name: cycle.shown_name, unit: cycle.unit,
      phase: cycle.phase[cycle.phase_of[near]] ?? "", time: between(cycle.time, at.index),
      part: at.part, playing: at.playing,
    });
    for (const callback of [...listeners])
      try { callback(current); } catch (error) { reportError(error); } // one must not stop the rest
    document.dispatchEvent(new CustomEvent("ballesta:position", { detail: current }));
  };
  const change = (values) => {
    if (Object.entries(values).every(([key, value]) => at[key] === value)) return;
    Object.assign(at, values);
    tell();
  };

  const setPosition = (cycle, index) => {
    if (!Number.isInteger(cycle) || !cycles[cycle])
      throw new RangeError(`there is no cycle ${cycle}, the page has ${cycles.length}`);
    if (!Number.isFinite(index)) throw new RangeError(`position ${index} is no number`);
    change({ cycle, index: Math.min(Math.max(index, 0), last(cycle)) });
  };
  const onPosition = (callback) => {
    listeners.add(callback);
    if (current) callback(current);
    return () => listeners.delete(callback);
  };

  if (start && cycles[start[0]]) [at.cycle, at.index] = start;
  tell();
  return {
    cycles, last, between, setPosition, onPosition,
    get current() { return current; },
    setPart: (part) => change({ part }),
    setPlaying: (playing) => change({ playing }),
    text(cycle, index) { // as it is told to people
      const { shown_name: name, unit, position, phase, phase_of: of } = cycles[cycle];
      const value = shortest(between(position, index), 5);
      const where = phase[of[Math.round(index)]];
      return `${name} = ${value}${unit ? ` ${unit}` : ""}${where ? `, ${where}` : ""}`;
    },
  };
})();
globalThis.ballesta = {
  cycles: positions.cycles, setPosition: positions.setPosition, onPosition: positions.onPosition,
  get current() { return positions.current; },
};

// The transport below the picture: play, slider, cycle, pace, and the curve of the peak behind it.
{
  const bar = document.getElementById("live-transport");
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const STEPS = 24; // of a cycle, when it is gone through step by step
  const { cycles } = positions;

  const transport = () => {
    const find = (name) => bar.querySelector(`[data-role=${name}]`);
    const [play, slider, cycle, pace, reading, ...others] =
      ["play", "slider", "cycle", "pace", "reading", "back", "on"].map(find);
    let frame = 0, before = 0, share = 0, played = -1;

    const times = (k) => { // moments of the positions as shares of the cycle
      const { time, position } = cycles[k];
      const rising = time && time.length > 1 && time.every((t, i) => i === 0 || t >= time[i - 1]);
      const list = rising ? time : position.map((_, i) => i);
      const whole = list[list.length - 1] - list[0] || 1;
      return list.map((t) => (t - list[0]) / whole);
    };
    const moments = new Map();
    const momentsOf = (k) => {
      if (!moments.has(k)) moments.set(k, times(k));
      return moments.get(k);
    };
    const indexAt = (list, wanted) => {
      let low = 0, high = list.length - 1;
      while (high - low > 1) {
        const middle = (low + high) >> 1;
        if (list[middle] <= wanted) low = middle; else high = middle;
      }
      const step = list[high] - list[low];
      return step > 0 ? low + Math.min(1, (wanted - list[low]) / step) : low;
    };
    const seconds = () => (pace.value === "real" ? realTime(positions.current.cycle)
      : Number(pace.value));
    const realTime = (k) => {
      const { time } = cycles[k];
      return time && time.length > 1 ? time[time.length - 1] - time[0] : 0;
    };

    const run = (now) => {
      const { cycle: k, index } = positions.current;
      if (index !== played) share = momentsOf(k)[Math.round(index)]; // another hand moved it
      share = (share + Math.max(0, now - before) / (1000 * Math.max(seconds(), 0.05))) % 1;
      before = now;
      played = indexAt(momentsOf(k), share);
      positions.setPosition(k, played);
      frame = requestAnimationFrame(run);
    };
    const stop = () => {
      if (!positions.current.playing) return;
      cancelAnimationFrame(frame);
      positions.setPlaying(false);
      const { cycle: k, index } = positions.current;
      positions.setPosition(k, Math.round(index));
    };
    const toggle = () => {
      const { cycle: k, index, playing } = positions.current;
      if (playing) { stop(); return; }
      if (still.matches) { // nothing moves by itself: a step at each press
        const step = Math.max(1, Math.round(positions.last(k) / STEPS));
        positions.setPosition(k, index >= positions.last(k) ? 0 : index + step);
        return;
      }
      share = momentsOf(k)[Math.round(index)] ?? 0;
      if (share >= 1) share = 0;
      before = performance.now();
      played = index;
      positions.setPlaying(true);
      frame = requestAnimationFrame(run);
    };
    const by = (step) => {
      stop();
      positions.setPosition(positions.current.cycle, Math.round(positions.current.index) + step);
    };

    cycles.forEach((each, k) => {
      const option = document.createElement("option");
      option.value = String(k);
      option.textContent = each.shown;
      cycle.append(option);
    });
    cycle.closest("label").hidden = cycles.length < 2;
    play.addEventListener("click", toggle);
    others[0].addEventListener("click", () => by(-1));
    others[1].addEventListener("click", () => by(1));
    slider.addEventListener("input", () => {
      const { value } = slider;
      stop();
      positions.setPosition(positions.current.cycle, Number(value));
    });
    cycle.addEventListener("change", () => {
      const { cycle: old, index } = positions.current;
      const k = Number(cycle.value);
      stop();
      const gone = index / Math.max(1, positions.last(old));
      positions.setPosition(k, Math.round(gone * positions.last(k)));
    });
    bar.addEventListener("keydown", (event) => {
      if (event.key === " " && event.target === slider) {
        event.preventDefault();
        toggle();
      } else if (event.shiftKey && ["ArrowLeft", "ArrowRight"].includes(event.key)) {
        event.preventDefault();
        by(event.key === "ArrowRight" ? 10 : -10);
      }
    });
    const named = () => {
      const verb = still.matches ? "Step" : positions.current?.playing ? "Pause" : "Play";
      play.querySelector("span").textContent = verb;
      play.dataset.state = verb.toLowerCase();
      pace.closest("label").hidden = still.matches;
    };
    still.addEventListener("change", () => { stop(); named(); });
    document.addEventListener("visibilitychange", () => { if (document.hidden) stop(); });

    let shownCycle = -1;
    positions.onPosition((state) => {
      const { cycle: k, index, time, phase } = state;
      if (shownCycle !== k) {
        shownCycle = k;
        slider.max = String(positions.last(k));
        cycle.value = String(k);
        const real = pace.querySelector("option[value=real]");
        const whole = realTime(k);
        real.disabled = !(whole >= 0.2 && whole <= 120);
        real.textContent = `as in life, ${figures(whole, 2)} s`;
        if (real.disabled && pace.value === "real") pace.value = "8";
      }
      slider.value = String(Math.round(index));
      const where = positions.text(k, index);
      slider.setAttribute("aria-valuetext", where);
      const [name, unit] = [state.name, state.unit];
      reading.replaceChildren(
        Object.assign(document.createElement("b"), {
          textContent: `${shortest(state.position, 5)}${unit ? ` ${unit}` : ""}`,
        }),
        Object.assign(document.createElement("small"), {
          textContent: [name, phase, time === null ? "" : `${figures(time, 4)} s`]
            .filter(Boolean).join(" · "),
        }),
      );
      named();
    });
    bar.hidden = false;
    return { toggle, by };
  };
  positions.transport = bar && cycles.length > 0 ? transport() : null;
}
