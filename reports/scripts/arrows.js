// Arrows as paths of SVG, y down; `tip` is half the length and half the width of an arrow's tip.
// What is too short for its tip is left out.

// At (x, y), pointing along the unit vector (ux, uy).
const tipPath = (x, y, ux, uy, tip) =>
  `M${x} ${y}L${x - tip * (2 * ux + uy)} ${y - tip * (2 * uy - ux)}` +
  `M${x} ${y}L${x - tip * (2 * ux - uy)} ${y - tip * (2 * uy + ux)}`;

const arrowPath = (x0, y0, x1, y1, tip) => {
  const length = Math.hypot(x1 - x0, y1 - y0);
  if (length < 0.4 * tip) return "";
  return `M${x0} ${y0}L${x1} ${y1}` +
    tipPath(x1, y1, (x1 - x0) / length, (y1 - y0) / length, tip);
};

// An arc about the origin, the longer the larger the torque's share of the largest; ccw above 0.
const torquePath = (share, tip) => {
  if (Math.abs(share) < 0.02) return "";
  const r = 5 * tip, turn = 1.6 * Math.PI * Math.abs(share), way = share > 0 ? -1 : 1;
  const c = Math.cos(way * turn), s = Math.sin(way * turn);
  return `M${r} 0A${r} ${r} 0 ${turn > Math.PI ? 1 : 0} ${way > 0 ? 1 : 0} ${r * c} ${r * s}` +
    tipPath(r * c, r * s, -way * s, way * c, tip);
};
