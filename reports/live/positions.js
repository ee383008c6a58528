// The position of the page: which cycle, and where in it. All that moves follows it: the live view,
// the mechanism, the charts' cursors. It needs neither WebGL nor a part that can be drawn.
// Public as globalThis.ballesta: current, setPosition(cycle, index), onPosition(callback), cycles.

const positions = (() => {
  const cycles = jsonOf("live-cycles") ?? [];
  const { start = null } = jsonOf("live-section") ?? {};
  const listeners = new Set();
  const at = { cycle: 0, index: 0, part: null, playing: false };
  let current = null;
  const last = (cycle) => cycles[cycle].position.length - 1;

  const tell = () => {
    if (cycles.length === 0) return;
    const cycle = cycles[at.cycle];
    const near = Math.round(at.index);
    current = Object.freeze({
      cycle: at.cycle, cycleName: cycle.name, index: at.index,
      position: atRow(cycle.position, at.index), name: cycle.shown_name, unit: cycle.unit,
      phase: cycle.phase[cycle.phase_of[near]] ?? "",
      time: cycle.time?.length ? atRow(cycle.time, at.index) : null,
      part: at.part, playing: at.playing,
    });
    for (const callback of [...listeners])
      try { callback(current); } catch (error) { reportError(error); } // one must not stop the rest
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
    cycles, last, setPosition, onPosition,
    get current() { return current; },
    setPart: (part) => change({ part }),
    setPlaying: (playing) => change({ playing }),
    text(cycle, index) { // as it is told to people
      const { shown_name: name, unit, position, phase, phase_of: of } = cycles[cycle];
      const value = shortest(atRow(position, index), 5);
      const where = phase[of[Math.round(index)]];
      return `${name} = ${value}${unit ? ` ${unit}` : ""}${where ? `, ${where}` : ""}`;
    },
  };
})();
globalThis.ballesta = {
  cycles: positions.cycles, setPosition: positions.setPosition, onPosition: positions.onPosition,
  get current() { return positions.current; },
};
