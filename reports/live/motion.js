// The motion of the whole linkage: where parts are, and the forces at their pins.

// Motion out of its text, as reports/live/linkage.py writes it: for each cycle null or
// {index, parts: [null | {x, y, angle, z}], pins: [{on, minor, z, x, y, fx, fy}], most: N}, `most`
// being the largest force. Rejects with words.
const readMotion = async (text) => {
  const cycles = await unzippedJson(text, "the motion");
  const spell = (owner) => {
    for (const [key, value] of Object.entries(owner ?? {}))
      if (value?.d) owner[key] = series(value);
  };
  for (const motion of cycles) {
    if (!motion) continue;
    motion.parts.forEach(spell);
    motion.pins.forEach(spell);
    motion.most = 0;
    for (const { fx, fy } of motion.pins)
      for (let k = 0; k < fx.length; k++)
        motion.most = Math.max(motion.most, Math.hypot(fx[k], fy[k]));
  }
  return cycles;
};

// Where a part is at a fractional row of a motion's kept positions.
const poseAt = (part, row) => part && {
  x: atRow(part.x, row), y: atRow(part.y, row), angle: atRow(part.angle, row), z: part.z,
};

// The corners of the bodies' boxes wherever they are in the cycle, (3 * n) mm.
const cornersOver = (motion, bodies) => {
  const points = [], rows = motion.index.length, step = Math.max(1, Math.floor(rows / 36));
  for (const { index, bounds } of bodies) {
    const part = motion.parts[index];
    for (let row = 0; part && row < rows; row += step) {
      const c = Math.cos(part.angle[row]), s = Math.sin(part.angle[row]);
      for (let corner = 0; corner < 8; corner++) {
        const [x, y, z] = [0, 1, 2].map((axis) => bounds[(corner >> axis) & 1][axis]);
        points.push(part.x[row] + c * x - s * y, part.y[row] + s * x + c * y, part.z + z);
      }
    }
  }
  return Float64Array.from(points);
};
