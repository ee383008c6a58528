// Numbers, places and forces as they are told to people.

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

// A place (x, y, z) in mm, and a force in N.
const placeText = (place) => {
  const told = Array.from(place, (value, axis) =>
    `${"xyz"[axis]} ${(Math.abs(value) < 0.05 ? 0 : value).toFixed(1).replace("-", "−")}`);
  return `${told.join(", ")} mm`;
};
const forceText = (newton) =>
  (newton >= 1e4 ? `${figures(newton / 1000)} kN` : `${figures(newton)} N`);
