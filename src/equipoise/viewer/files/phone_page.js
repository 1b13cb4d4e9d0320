// On a phone the controls are a sheet over the whole width, half as high as the page at most, and the
// picture is what is above it: nothing lies over the robot.
(() => {
  "use strict";
  const STYLE = `@media (max-width: 700px) {
    [data-equipoise="sheet"] { width: 100% !important; max-height: 50% !important; }
    [data-equipoise="sheet"] [style*="width: 20em"] { width: 100% !important; }
    [data-equipoise="picture"] { flex: none !important; width: 100% !important;
      height: calc(100% - var(--equipoise-sheet, 0px)) !important; }
  }`;
  const GIVE_UP = 20000; // [ms] after which no sheet is waited for
  const isSheet = (element) =>
    element.style.position === "fixed" && element.style.bottom === "0px";
  const measured = new ResizeObserver(([entry]) => {
    const high = `${Math.round(entry.target.offsetHeight)}px`;
    document.documentElement.style.setProperty("--equipoise-sheet", high);
  });

  function mark() {
    const sheet = [...document.querySelectorAll(".mantine-Paper-root")].find(isSheet);
    if (!sheet || sheet.dataset.equipoise) return;
    const picture = [...sheet.parentElement.children].find((one) => one.querySelector("canvas"));
    if (!picture) return;
    sheet.dataset.equipoise = "sheet";
    picture.dataset.equipoise = "picture";
    measured.observe(sheet);
  }

  const style = document.createElement("style");
  style.textContent = STYLE;
  document.head.append(style);
  if (window.innerWidth > 700) return;
  const watch = new MutationObserver(mark);
  watch.observe(document.documentElement, { childList: true, subtree: true });
  setTimeout(() => watch.disconnect(), GIVE_UP);
})();
