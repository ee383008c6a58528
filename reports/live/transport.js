// The transport below the picture: play, slider, cycle, pace. Null where the page has none.
const transport = (() => {
  const bar = document.getElementById("live-transport");
  const still = matchMedia("(prefers-reduced-motion: reduce)");
  const STEPS = 24; // of a cycle, when it is gone through step by step
  const { cycles } = positions;
  if (!bar || cycles.length === 0) return null;

  const find = (name) => bar.querySelector(`[data-role=${name}]`);
  const [play, slider, cycle, pace, reading, back, on] =
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
    played = rowIn(momentsOf(k), share);
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
  back.addEventListener("click", () => by(-1));
  on.addEventListener("click", () => by(1));
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
  return { toggle };
})();
