// The orthographic camera, and what lies under a point of its picture.
// Camera axes: x to the right, y up, z towards the reader. Lengths are mm; `scale` makes CSS pixels
// of them. A body stands in the scene by its pose {x, y, z, angle}: turned about z, then moved.

const NO_POSE = Object.freeze({ x: 0, y: 0, z: 0, angle: 0 });

// Quaternions as [w, x, y, z]; views look along -z of the axes that they turn to.
const timesQuaternion = ([a, b, c, d], [e, f, g, h]) => [
  a * e - b * f - c * g - d * h, a * f + b * e + c * h - d * g,
  a * g - b * h + c * e + d * f, a * h + b * g - c * f + d * e,
];
const aboutAxis = (x, y, z, angle) => {
  const length = Math.hypot(x, y, z) || 1, s = Math.sin(angle / 2) / length;
  return [Math.cos(angle / 2), x * s, y * s, z * s];
};
const rowsOf = ([w, x, y, z]) => [ // rotation matrix, row by row
  1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
  2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
  2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
];
const slanted = (yaw, pitch = 0.55) =>
  timesQuaternion(aboutAxis(1, 0, 0, pitch), aboutAxis(0, 1, 0, yaw));
const VIEWS = {
  front: [1, 0, 0, 0],
  top: aboutAxis(1, 0, 0, Math.PI / 2),
  side: aboutAxis(0, 1, 0, -Math.PI / 2),
  iso: slanted(-0.6),
};
// From which a part is seen first: the first of them that shows its peak.
const FIRST_VIEWS = [0.55, -0.55].flatMap((pitch) =>
  [-0.6, 0.6, Math.PI - 0.6, Math.PI + 0.6].map((yaw) => slanted(yaw, pitch)));

// Directions evenly spread over the sphere: points of a spiral.
const spiral = (count) => Array.from({ length: count }, (_, k) => {
  const height = 1 - (2 * k + 1) / count, angle = Math.PI * (1 + Math.sqrt(5)) * (k + 0.5);
  const ring = Math.sqrt(1 - height * height);
  return [ring * Math.cos(angle), height, ring * Math.sin(angle)];
});

// The turn that brings a direction of the scene to point at the reader, y as upright as can be.
const facing = (x, y, z) => {
  const flat = Math.hypot(x, z);
  const yaw = flat > 1e-9 ? Math.atan2(-x, z) : 0;
  return timesQuaternion(
    aboutAxis(1, 0, 0, Math.atan2(y, flat)), aboutAxis(0, 1, 0, yaw),
  );
};

// The smallest box that holds points (3 * n), along the axes that `rows` turns them to.
const boxOf = (points, rows = rowsOf(VIEWS.front)) => {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 3)
    for (let axis = 0; axis < 3; axis++) {
      const at = rows[3 * axis] * points[i] + rows[3 * axis + 1] * points[i + 1] +
        rows[3 * axis + 2] * points[i + 2];
      if (at < low[axis]) low[axis] = at;
      if (at > high[axis]) high[axis] = at;
    }
  return [low, high];
};

class Camera {
  constructor() {
    this.turn = VIEWS.iso;
    this.target = [0, 0, 0]; // stands in the middle of the picture
    this.scale = 1; // px per mm
    this.width = this.height = 1; // px
    this.margin = { left: 24, right: 24, top: 24, bottom: 24 }; // px that a fitted scene keeps free
    this.points = new Float32Array([-1, -1, -1, 1, 1, 1]); // that a fitted picture holds, mm
    this.bounds = boxOf(this.points);
  }

  get rows() { return rowsOf(this.turn); }

  // Show all of these points (3 * n, mm) of the scene, as it is turned now.
  fit(points = this.points) {
    if (points !== this.points) {
      this.points = points;
      this.bounds = boxOf(points);
    }
    const [low, high] = boxOf(points, this.rows), rows = this.rows;
    const { left, right, top, bottom } = this.margin;
    const wide = Math.max(40, this.width - left - right);
    const tall = Math.max(40, this.height - top - bottom);
    this.scale = Math.min(
      wide / Math.max(high[0] - low[0], 1e-9), tall / Math.max(high[1] - low[1], 1e-9), 1e6,
    );
    const middle = low.map((v, axis) => (v + high[axis]) / 2);
    middle[0] += (right - left) / 2 / this.scale;
    middle[1] += (top - bottom) / 2 / this.scale;
    this.target = [0, 1, 2].map((axis) =>
      rows[axis] * middle[0] + rows[3 + axis] * middle[1] + rows[6 + axis] * middle[2]);
  }

  resize(width, height) {
    const before = Math.min(this.width, this.height);
    if (before > 1) this.scale *= Math.min(width, height) / before;
    this.width = width;
    this.height = height;
  }

  // Turn about the picture's own axes by px of a drag: half the picture's height is a radian.
  orbit(dx, dy) {
    const angle = Math.hypot(dx, dy) / (0.5 * Math.min(this.width, this.height));
    if (angle) this.turn = timesQuaternion(aboutAxis(dy, dx, 0, angle), this.turn);
    const length = Math.hypot(...this.turn);
    this.turn = this.turn.map((v) => v / length);
  }

  pan(dx, dy) {
    const rows = this.rows;
    this.target = this.target.map(
      (v, axis) => v - (rows[axis] * dx - rows[3 + axis] * dy) / this.scale);
  }

  zoom(factor, x = this.width / 2, y = this.height / 2) { // what is under (x, y) stays there
    const size = Math.hypot(...this.bounds[0].map((v, axis) => this.bounds[1][axis] - v)) || 1;
    const least = 0.1 * Math.min(this.width, this.height) / size;
    const scale = Math.min(Math.max(this.scale * factor, least), 5000 * least);
    const share = 1 - this.scale / scale;
    this.pan(-(x - this.width / 2) * share, -(y - this.height / 2) * share);
    this.scale = scale;
  }

  // Rows that take a point of a body to [px right, px down, mm towards the reader], 4 numbers each.
  pixels(pose = NO_POSE) {
    const r = this.rows, c = Math.cos(pose.angle), s = Math.sin(pose.angle);
    const offset = [pose.x - this.target[0], pose.y - this.target[1], pose.z - this.target[2]];
    const out = new Float64Array(12);
    for (let i = 0; i < 3; i++) {
      const [a, b, e] = [r[3 * i], r[3 * i + 1], r[3 * i + 2]];
      const size = i === 2 ? 1 : i === 1 ? -this.scale : this.scale;
      out[4 * i] = size * (a * c + b * s);
      out[4 * i + 1] = size * (b * c - a * s);
      out[4 * i + 2] = size * e;
      out[4 * i + 3] = size * (a * offset[0] + b * offset[1] + e * offset[2]) +
        (i === 0 ? this.width / 2 : i === 1 ? this.height / 2 : 0);
    }
    return out;
  }

  // The same for WebGL: clip coordinates, column by column; and the turn of normals (3 x 3).
  clip(pose = NO_POSE) {
    const p = this.pixels(pose), out = new Float32Array(16), reach = this.reach();
    for (let k = 0; k < 4; k++) {
      out[4 * k] = 2 * p[k] / this.width;
      out[4 * k + 1] = -2 * p[4 + k] / this.height;
      out[4 * k + 2] = -p[8 + k] / reach;
    }
    out[12] -= 1;
    out[13] += 1;
    out[15] = 1;
    return out;
  }

  normals(pose = NO_POSE) {
    const p = this.pixels(pose), out = new Float32Array(9);
    for (let k = 0; k < 3; k++) {
      out[3 * k] = p[k] / this.scale;
      out[3 * k + 1] = -p[4 + k] / this.scale;
      out[3 * k + 2] = p[8 + k];
    }
    return out;
  }

  // How far the scene reaches from the target, mm, with room for what is drawn deformed.
  reach() {
    const [low, high] = this.bounds;
    return 1.5 * Math.hypot(...[0, 1, 2].map((axis) =>
      Math.max(Math.abs(low[axis] - this.target[axis]), Math.abs(high[axis] - this.target[axis]))));
  }
}

// [px right, px down, mm towards the reader] of a point, by the rows of Camera.pixels.
const placed = (rows, x, y, z) => [0, 4, 8].map(
  (i) => rows[i] * x + rows[i + 1] * y + rows[i + 2] * z + rows[i + 3]);

// The same of all vertices: out (3 * vertices).
const project = (rows, points, out) => {
  for (let i = 0; i < points.length; i += 3) {
    const x = points[i], y = points[i + 1], z = points[i + 2];
    out[i] = rows[0] * x + rows[1] * y + rows[2] * z + rows[3];
    out[i + 1] = rows[4] * x + rows[5] * y + rows[6] * z + rows[7];
    out[i + 2] = rows[8] * x + rows[9] * y + rows[10] * z + rows[11];
  }
  return out;
};

// The triangle under (x, y) that is nearest to the reader and lies above `floor`, or null:
// {corner: index of its first corner in `triangles`, weights: of its corners, depth: mm}.
// Triangles with a corner at node `spared` are passed over: those around a point do not hide it.
const pick = (screen, triangles, x, y, { floor = -Infinity, spared = -1, nodes = null } = {}) => {
  let best = null, depth = floor;
  for (let t = 0; t < triangles.length; t += 3) {
    const i = 3 * triangles[t], j = 3 * triangles[t + 1], k = 3 * triangles[t + 2];
    const xi = screen[i] - x, xj = screen[j] - x, xk = screen[k] - x;
    if ((xi > 0 && xj > 0 && xk > 0) || (xi < 0 && xj < 0 && xk < 0)) continue;
    const yi = screen[i + 1] - y, yj = screen[j + 1] - y, yk = screen[k + 1] - y;
    if ((yi > 0 && yj > 0 && yk > 0) || (yi < 0 && yj < 0 && yk < 0)) continue;
    const a = xj * yk - xk * yj, b = xk * yi - xi * yk, c = xi * yj - xj * yi;
    if (!((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0))) continue;
    const area = a + b + c;
    if (area === 0) continue; // seen from its edge
    const z = (a * screen[i + 2] + b * screen[j + 2] + c * screen[k + 2]) / area;
    if (z <= depth) continue;
    if (spared >= 0 && (nodes[triangles[t]] === spared || nodes[triangles[t + 1]] === spared ||
      nodes[triangles[t + 2]] === spared)) continue;
    depth = z;
    best = { corner: t, weights: [a / area, b / area, c / area], depth: z };
  }
  return best;
};
