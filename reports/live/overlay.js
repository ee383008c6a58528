// What is written over the picture: colour bar, markers, force arrows, axes, a length to compare.
// Everything is drawn in CSS pixels on the 2-D canvas that shows the scene.

const PRINTED = { // colours on paper, whatever the screen has
  ink: "#000000", soft: "#444444", line: "#999999", ground: "#ffffff", panel: "#ffffff",
  force: "#b23318",
};
const screenColours = (element) => {
  const style = getComputedStyle(element);
  const variable = (name, or) => style.getPropertyValue(name).trim() || or;
  return {
    ink: variable("--ink", "#1d2126"), soft: variable("--soft", "#5a626d"),
    line: variable("--line", "#d6dbe1"), ground: variable("--ground", "#ffffff"),
    panel: variable("--panel", "#f5f7f9"), force: variable("--fail", "#b23318"),
  };
};

// Numbers of 1, 2 or 5 times a power of ten that divide a range into about so many steps.
const roundStep = (range, count) => {
  const rough = range / count, power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5].find((m) => m * power >= rough * 0.999) ?? 10);
};
const ticksOf = (from, to, count) => {
  if (!(to > from)) return [from];
  const step = roundStep(to - from, count), ticks = [];
  for (let k = Math.ceil(from / step - 1e-9); k * step <= to + 1e-9 * step; k++)
    ticks.push(k * step);
  return ticks;
};

class Overlay {
  constructor(context, font) {
    this.context = context;
    this.font = font;
    this.colours = PRINTED;
  }

  begin(width, height, ratio, colours) {
    Object.assign(this, { width, height, colours });
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.textBaseline = "middle";
    this.context.lineJoin = this.context.lineCap = "round";
  }

  text(words, x, y, { align = "left", size = 12, weight = 400, tone = "ink", halo = false } = {}) {
    const c = this.context;
    c.font = `${weight} ${size}px ${this.font}`;
    c.textAlign = align;
    if (halo) {
      c.strokeStyle = this.colours.ground;
      c.lineWidth = 3;
      c.strokeText(words, x, y);
    }
    c.fillStyle = this.colours[tone];
    c.fillText(words, x, y);
  }

  outline(path, thick) {
    const c = this.context;
    c.globalAlpha = 0.6;
    c.strokeStyle = this.colours.soft;
    c.lineWidth = thick;
    c.stroke(path);
    c.globalAlpha = 1;
  }

  // scale: {title, from, to, table, bands}; marks: [{value, label}] lines across the bar.
  colourBar(scale, marks) {
    const c = this.context, narrow = this.width < 480;
    const thick = narrow ? 8 : 10, top = narrow ? 84 : 76;
    const tall = Math.max(60, Math.min(300, this.height - top - 52)), x = this.width - 18 - thick;
    if (!narrow) { // a part may reach behind it
      c.globalAlpha = 0.6;
      c.fillStyle = this.colours.ground;
      c.beginPath();
      c.roundRect(x - 46, top - 10, thick + 56, tall + 20, 6);
      c.fill();
      c.globalAlpha = 1;
    }
    const blocks = scale.bands || 256;
    const colourAt = (share) => {
      const at = 3 * Math.min(255, Math.round(share * 255));
      return `rgb(${scale.table[at]} ${scale.table[at + 1]} ${scale.table[at + 2]})`;
    };
    for (let k = 0; k < blocks; k++) {
      c.fillStyle = colourAt((k + 0.5) / blocks);
      const low = top + tall * (1 - k / blocks), high = top + tall * (1 - (k + 1) / blocks);
      c.fillRect(x, high, thick, low - high + (scale.bands || k === 0 ? 0 : 0.6));
    }
    c.strokeStyle = this.colours.line;
    c.lineWidth = 1;
    c.strokeRect(x - 0.5, top - 0.5, thick + 1, tall + 1);
    const span = scale.to - scale.from || 1;
    const heightOf = (value) => top + tall * (1 - (value - scale.from) / span);
    for (const value of ticksOf(scale.from, scale.to, tall < 160 ? 3 : 6)) {
      const y = heightOf(value);
      c.beginPath();
      c.moveTo(x - 5, y);
      c.lineTo(x - 1, y);
      c.stroke();
      this.text(shortest(value, 3), x - 8, y,
        { align: "right", size: narrow ? 10 : 11.5, halo: true });
    }
    const marked = [];
    for (const { value, label } of marks) {
      if (!(value > scale.from && value <= scale.to * 1.0001)) continue;
      const y = heightOf(value);
      if (marked.some((other) => Math.abs(other - y) < 12)) continue; // no room for its label
      marked.push(y);
      c.strokeStyle = this.colours.ink;
      c.lineWidth = 2;
      c.beginPath();
      c.moveTo(x - 4, y);
      c.lineTo(x + thick + 4, y);
      c.stroke();
      this.text(label, x - 34, y, { align: "right", size: 11, tone: "soft", halo: true });
    }
    this.text(scale.title, this.width - 16, top - 20,
      { align: "right", size: narrow ? 11 : 12, weight: 600, halo: true });
  }

  // A ring at (x, y) with words beside it; dashed where the place is hidden behind material.
  marker(x, y, words, { hidden = false, square = false, below = false } = {}) {
    const c = this.context;
    const outline = () => {
      c.beginPath();
      if (square) c.rect(x - 5, y - 5, 10, 10); else c.arc(x, y, 7, 0, 2 * Math.PI);
      c.stroke();
    };
    c.setLineDash(hidden ? [3.6, 3.7] : []);
    c.lineWidth = 4.5;
    c.strokeStyle = "rgb(0 0 0 / 0.75)";
    outline();
    c.lineWidth = 2;
    c.strokeStyle = "#ffffff";
    outline();
    c.setLineDash([]);
    if (!hidden) {
      c.fillStyle = "#ffffff";
      c.beginPath();
      c.arc(x, y, 1.6, 0, 2 * Math.PI);
      c.fill();
    }
    this.label(x, below ? y + 26 : y, words);
  }

  label(x, y, words) {
    const c = this.context;
    c.font = `600 12px ${this.font}`;
    const wide = c.measureText(words).width + 14;
    let left = x + 14;
    if (left + wide > this.width - 6) left = x - 14 - wide;
    left = Math.max(4, Math.min(left, this.width - wide - 4));
    const top = Math.max(4, Math.min(y - 11, this.height - 26));
    c.fillStyle = "rgb(20 23 27 / 0.88)";
    c.beginPath();
    c.roundRect(left, top, wide, 22, 4);
    c.fill();
    c.textAlign = "left";
    c.fillStyle = "#ffffff";
    c.fillText(words, left + 7, top + 11.5);
  }

  arrow(x0, y0, x1, y1) {
    const c = this.context, length = Math.hypot(x1 - x0, y1 - y0);
    if (length < 3) return;
    const ux = (x1 - x0) / length, uy = (y1 - y0) / length, head = Math.min(10, 0.6 * length);
    const line = () => {
      c.beginPath();
      c.moveTo(x0, y0);
      c.lineTo(x1 - ux * head * 0.7, y1 - uy * head * 0.7);
      c.stroke();
    };
    const tip = () => {
      c.beginPath();
      c.moveTo(x1, y1);
      c.lineTo(x1 - head * ux + 0.42 * head * uy, y1 - head * uy - 0.42 * head * ux);
      c.lineTo(x1 - head * ux - 0.42 * head * uy, y1 - head * uy + 0.42 * head * ux);
      c.closePath();
    };
    c.strokeStyle = this.colours.ground;
    c.lineWidth = 5;
    line();
    tip();
    c.stroke();
    c.strokeStyle = c.fillStyle = this.colours.force;
    c.lineWidth = 2.4;
    line();
    tip();
    c.fill();
    c.beginPath();
    c.arc(x0, y0, 2.6, 0, 2 * Math.PI);
    c.fill();
  }

  // The directions of the axes and, beside them, a round length in the picture's scale.
  axes(camera) {
    const c = this.context, rows = camera.rows, x0 = 36, y0 = this.height - 36;
    const ends = ["x", "y", "z"].map((name, k) => ({
      name, x: x0 + 22 * rows[k], y: y0 - 22 * rows[3 + k], depth: rows[6 + k],
    })).sort((a, b) => a.depth - b.depth);
    for (const { name, x, y, depth } of ends) {
      c.strokeStyle = depth < -0.05 ? this.colours.line : this.colours.soft;
      c.lineWidth = 1.6;
      c.beginPath();
      c.moveTo(x0, y0);
      c.lineTo(x, y);
      c.stroke();
      if (depth < 0.985)
        this.text(name, x0 + (x - x0) * 1.42, y0 + (y - y0) * 1.42,
          { align: "center", size: 11, weight: 600, tone: "soft" });
    }
    const length = roundStep(0.16 * this.width / camera.scale, 1);
    const wide = length * camera.scale;
    const left = 76, y = this.height - 24;
    c.strokeStyle = this.colours.soft;
    c.lineWidth = 1.4;
    c.beginPath();
    c.moveTo(left, y - 4);
    c.lineTo(left, y);
    c.lineTo(left + wide, y);
    c.lineTo(left + wide, y - 4);
    c.stroke();
    this.text(`${figures(length, 1)} mm`, left + wide / 2, y - 9,
      { align: "center", size: 11, tone: "soft" });
  }

  // What an arrow of a length stands for, at the bottom right.
  forceScale(pixels, words) {
    const y = this.height - 14, right = this.width - 18;
    this.text(words, right, y, { align: "right", size: 11.5, tone: "ink", halo: true });
    this.context.font = `400 11.5px ${this.font}`;
    const left = right - this.context.measureText(words).width - 10 - pixels;
    this.arrow(left, y, left + pixels, y);
  }
}

// The peak over the cycle behind the slider, with the phases; `inset` px are half a thumb.
const drawCurve = (canvas, { heights, phases, last, share, colours, series, inset = 8 }) => {
  const ratio = Math.min(devicePixelRatio, 2);
  const { clientWidth: wide, clientHeight: tall } = canvas;
  if (!wide || !tall) return;
  Object.assign(canvas, { width: Math.round(wide * ratio), height: Math.round(tall * ratio) });
  const c = canvas.getContext("2d"), reach = wide - 2 * inset;
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  const font = getComputedStyle(canvas).fontFamily;
  phases.forEach(({ name, from, to }, k) => {
    const x0 = inset + reach * from / (last || 1), x1 = inset + reach * to / (last || 1);
    if (k % 2 === 0) {
      c.fillStyle = colours.panel;
      c.fillRect(x0, 0, x1 - x0, tall);
    }
    c.font = `400 10.5px ${font}`;
    c.fillStyle = colours.soft;
    c.textBaseline = "top";
    if (phases.length > 1 && c.measureText(name).width < x1 - x0 - 8) c.fillText(name, x0 + 4, 2);
  });
  if (heights.length > 1) {
    const top = 14;
    const at = (k) => [
      inset + reach * k / (heights.length - 1), tall - 1 - (tall - top - 2) * heights[k] / 255];
    c.beginPath();
    c.moveTo(inset, tall);
    for (let k = 0; k < heights.length; k++) c.lineTo(...at(k));
    c.lineTo(inset + reach, tall);
    c.globalAlpha = 0.16;
    c.fillStyle = series;
    c.fill();
    c.globalAlpha = 1;
    c.beginPath();
    for (let k = 0; k < heights.length; k++) c.lineTo(...at(k));
    c.strokeStyle = series;
    c.lineWidth = 1.4;
    c.stroke();
  }
  c.strokeStyle = colours.ink;
  c.lineWidth = 1;
  c.beginPath();
  c.moveTo(inset + reach * share, 0);
  c.lineTo(inset + reach * share, tall);
  c.stroke();
};
