"use strict";
// The utilisation of a check drawn as a bar with its error bars, as reports/gauge.py draws it.
const gaugeOf = ({ use, per, tone, numerical, model, below }) => {
  const END = 130, UNIT = 100; // the limit stands at 100
  const within = (value) => Math.min(Math.max(value * UNIT, 0), END).toFixed(2);
  const make = (tag, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    return element;
  };
  const svg = make("svg", { class: `gauge ${tone}`, viewBox: `0 0 ${END} 16`, "aria-hidden": "true",
    preserveAspectRatio: "none" });
  const line = (name, from, to) =>
    svg.append(make("path", { class: name, d: `M${within(from)} 8H${within(to)}` }));
  line("track", 0, END);
  svg.append(make("rect", { class: "fill", y: 3, width: within(use), height: 10 }));
  const low = below === null || numerical === null ? 0 : use - (numerical + below) * per;
  const endless = numerical === null || model === null; // dotted, and its end is not drawn
  const high = endless ? use : use + (numerical + model) * per;
  if (endless) line("endless", low, END);
  else if ((high - low) * UNIT >= 0.05) { // else nothing to be seen
    line("model", low, high);
    if (numerical) line("numerical", use - numerical * per, use + numerical * per);
    const ends = [low, high].filter((end) => end > 0 && end * UNIT < END);
    const marks = ends.map((end) => `M${within(end)} 4V12`).join("");
    if (marks) svg.append(make("path", { class: "ends", d: marks }));
  }
  svg.append(make("path", { class: "limit", d: `M${UNIT} 0V16` }));
  if (Math.max(use, high) * UNIT > END)
    svg.append(make("path", { class: "beyond", d: `M${END - 6} 3l5 5l-5 5` }));
  return svg;
};
