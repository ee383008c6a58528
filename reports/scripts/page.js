// What the page does beside its live view: links into it, folds that open for their links and for
// printing, the copy button, and which section is being read. Without it only ease is missing.
{
  const all = (choice) => [...document.querySelectorAll(choice)];

  // "show": what a check means in the live view, or a part's tab alone.
  for (const link of all("a[data-show]"))
    link.addEventListener("click", () => {
      const wanted = JSON.parse(link.dataset.show);
      if (globalThis.ballesta?.live?.show(wanted)) return;
      if (wanted.position) globalThis.ballesta?.setPosition(...wanted.position);
    });
  for (const link of all("a[data-part]"))
    link.addEventListener("click", () =>
      document.getElementById(`live-tab-${link.dataset.part}`)?.click());

  const openTo = (id) => { // a link into a fold opens it
    let place = id ? document.getElementById(id) : null;
    place?.querySelector(":scope > details")?.setAttribute("open", "");
    for (; place; place = place.parentElement) if (place.tagName === "DETAILS") place.open = true;
  };
  const openToHash = () => {
    try {
      openTo(decodeURIComponent(location.hash.slice(1)));
    } catch { /* not a place of this page */ }
  };
  addEventListener("hashchange", openToHash);
  openToHash();

  let opened = [];
  addEventListener("beforeprint", () => {
    opened = all("details.printed:not([open]), details.governing:not([open])");
    for (const fold of opened) fold.open = true;
  });
  addEventListener("afterprint", () => {
    for (const fold of opened) fold.open = false;
    opened = [];
  });

  // A wide table is a stop of the keyboard only while it must be scrolled.
  const widths = new ResizeObserver((changes) => {
    const wide = changes.map(({ target }) => [target, target.scrollWidth > target.clientWidth]);
    for (const [target, stops] of wide) target.tabIndex = stops ? 0 : -1;
  });
  for (const region of all(".scroll[tabindex]")) widths.observe(region);

  const paper = document.getElementById("print");
  paper.hidden = false;
  paper.addEventListener("click", () => print());

  for (const button of all(".command button")) {
    const command = button.parentElement.querySelector("pre");
    button.hidden = false;
    button.addEventListener("click", async () => {
      getSelection().selectAllChildren(command);
      try {
        await navigator.clipboard.writeText(command.textContent);
        button.textContent = "Copied";
      } catch {
        button.textContent = "Selected: press Ctrl+C";
      }
      setTimeout(() => { button.textContent = "Copy"; }, 2500);
    });
  }

  // The last section whose top has passed under the bar is the one that is read.
  const links = all(".contents a[href^='#']");
  const places = links.map((link) => document.getElementById(link.hash.slice(1)));
  const strip = document.querySelector(".contents > div");
  let frame = 0, shown = null;
  const mark = () => {
    frame = 0;
    const line = innerHeight * 0.3;
    let now = 0;
    places.forEach((place, index) => {
      if (place && place.getBoundingClientRect().top < line) now = index;
    });
    if (scrollY + innerHeight >= document.documentElement.scrollHeight - 2) now = links.length - 1;
    if (links[now] === shown) return;
    shown?.removeAttribute("aria-current");
    shown = links[now];
    shown.setAttribute("aria-current", "true");
    strip.scrollTo({ left: shown.offsetLeft - strip.clientWidth / 2 + shown.offsetWidth / 2 });
  };
  const ask = () => { frame ||= requestAnimationFrame(mark); };
  addEventListener("scroll", ask, { passive: true });
  addEventListener("resize", ask);
  mark();
}
