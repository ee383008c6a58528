// Values under the pointer in every chart: an SVG with data-frames, for each of its frames "left top
// width height x0 x1 y0 y1 log", where log names the axes that are logarithmic.
{
  const SVG = "http://www.w3.org/2000/svg";
  const short = (value) => String(Number(value.toPrecision(4))).replace("-", "−");
  const between = (low, high, share, logarithmic) =>
    (logarithmic ? low * (high / low) ** share : low + share * (high - low));

  for (const svg of document.querySelectorAll("svg[data-frames]")) {
    const frames = svg.dataset.frames.split(";").map((text) => text.split(" "));
    let told = null;
    const clear = () => { told?.remove(); told = null; };
    svg.addEventListener("pointerleave", clear);
    svg.addEventListener("pointermove", (event) => {
      const matrix = svg.getScreenCTM();
      if (!matrix) return;
      const at = new DOMPoint(event.clientX, event.clientY).matrixTransform(matrix.inverse());
      for (const frame of frames) {
        const [left, top, width, height, x0, x1, y0, y1] = frame.map(Number);
        const across = (at.x - left) / width, up = 1 - (at.y - top) / height;
        if (Math.min(across, up) < 0 || Math.max(across, up) > 1) continue;
        told ??= svg.appendChild(document.createElementNS(SVG, "text"));
        told.setAttribute("class", "under-pointer");
        told.setAttribute("x", at.x + (across > 0.5 ? -6 : 6));
        told.setAttribute("y", at.y + (up > 0.9 ? 14 : -6));
        told.setAttribute("text-anchor", across > 0.5 ? "end" : "start");
        told.textContent = `${short(between(x0, x1, across, frame[8].includes("x")))}; ` +
          short(between(y0, y1, up, frame[8].includes("y")));
        return;
      }
      clear();
    });
  }
}
