// Moves the pictures of mechanisms. Everything it shows comes from the page's own data blocks.
for (const figure of document.querySelectorAll("figure.motion")) {
  const data = JSON.parse(figure.querySelector("script").textContent);
  const [button, slider] = [figure.querySelector("button"), figure.querySelector("input")];
  const reading = figure.querySelector("output");
  const part = (kind, i) => document.getElementById(`${data.prefix}-${kind}-${i}`);
  const still = window.matchMedia("(prefers-reduced-motion: reduce)");
  const last = data.times.length - 1;
  const period = 1000 * Math.min(12, Math.max(4, data.duration)); // ms of playing, for all cycles
  let frame = 0, playing = false, began = 0;

  const line = (element, x0, y0, x1, y1) => {
    for (const [name, value] of Object.entries({ x1: x0, y1: y0, x2: x1, y2: y1 }))
      element.setAttribute(name, value);
  };

  const show = (k) => {
    frame = k;
    const [bodies, points, spans] = [data.bodies[k], data.points[k], data.spans[k]];
    for (let i = 0; 3 * i < bodies.length; i++)
      part("body", i).setAttribute("transform",
        `translate(${bodies[3 * i]} ${bodies[3 * i + 1]}) rotate(${bodies[3 * i + 2]})`);
    for (let i = 0; 2 * i < points.length; i++) {
      const [x, y] = [points[2 * i], points[2 * i + 1]];
      part("point", i).setAttribute("transform", `translate(${x} ${y})`);
      const label = part("label", i);
      if (label) {
        label.setAttribute("x", x + data.lifts[i]);
        label.setAttribute("y", y - data.lifts[i]);
      }
    }
    for (let i = 0; 4 * i < spans.length; i++) {
      const [x0, y0, x1, y1] = spans.slice(4 * i, 4 * i + 4);
      const share = data.barrels[i] / Math.hypot(x1 - x0, y1 - y0);
      line(part("span", i), x0, y0, x1, y1);
      line(part("barrel", i), x0, y0, x0 + share * (x1 - x0), y0 + share * (y1 - y0));
    }
    for (let i = 0; 4 * i < data.arrows[k].length; i++) {
      const ends = data.arrows[k].slice(4 * i, 4 * i + 4);
      part("arrow", i).setAttribute("d", arrowPath(...ends, data.tip));
    }
    for (let i = 0; i < data.torques[k].length; i++) {
      const [x, y] = data.centres[k].slice(2 * i, 2 * i + 2);
      part("torque", i).setAttribute("transform", `translate(${x} ${y})`);
      part("torque", i).setAttribute("d", torquePath(data.torques[k][i], data.tip));
    }
    slider.value = k;
    slider.setAttribute("aria-valuetext", data.readings[k]);
    reading.textContent = data.readings[k];
  };

  const tick = (now) => {
    if (!playing) return;
    let share = ((now - began) / period) % 1;
    if (still.matches) share = Math.floor(16 * share) / 16; // a row of stills instead of a motion
    const time = share * data.times[last];
    let [low, high] = [0, last];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (data.times[middle] <= time) low = middle; else high = middle - 1;
    }
    if (low !== frame) show(low);
    requestAnimationFrame(tick);
  };
  const play = (on) => {
    playing = on;
    button.textContent = on ? "Pause" : "Play";
    if (!on) return;
    const gone = frame === last ? 0 : data.times[frame] / data.times[last];
    began = performance.now() - period * gone;
    requestAnimationFrame(tick);
  };

  button.addEventListener("click", () => play(!playing));
  slider.addEventListener("input", () => { play(false); show(Number(slider.value)); });
  slider.max = last;
  figure.querySelector(".controls").hidden = false;
  show(0);
}
