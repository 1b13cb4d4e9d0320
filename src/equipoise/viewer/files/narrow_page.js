// On a page too narrow for both panels beside the picture, the plots begin folded; a click on their
// edge unfolds them. Folded once, they are left to whoever looks.
(() => {
  "use strict";
  const BOTH = 1100; // [px] from which on picture and both panels have room
  const GIVE_UP = 20000; // [ms] after which no panel is waited for
  if (window.innerWidth >= BOTH) return;
  const watch = new MutationObserver(() => {
    const fold = document.querySelector('[data-dock-region-collapse="left"][aria-expanded="true"]');
    if (!fold) return;
    watch.disconnect();
    fold.click();
  });
  watch.observe(document.documentElement, { childList: true, subtree: true });
  setTimeout(() => watch.disconnect(), GIVE_UP);
})();
