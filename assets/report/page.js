// Starts the live views where there are any, and draws them anew when the page changes its size or colours.
function start() {
  document.documentElement.classList.add("js");
  const views = { scene: sceneView, traces: tracesView };
  for (const root of document.querySelectorAll(".live")) {
    try {
      if (views[root.dataset.view](root) === false) root.classList.remove("live");
    } catch (error) {
      // Better the still picture than none.
      root.remove();
      console.error(error);
    }
  }
  let width = window.innerWidth;
  const again = () => redraws.forEach(redraw => redraw());
  window.addEventListener("resize", () => { if (window.innerWidth !== width) { width = window.innerWidth; again(); } });
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  // Folded parts are printed as well.
  let folded = [];
  window.addEventListener("beforeprint", () => {
    folded = [...document.querySelectorAll("details:not([open])")];
    folded.forEach(details => { details.open = true; });
  });
  window.addEventListener("afterprint", () => folded.forEach(details => { details.open = false; }));
}
start();
