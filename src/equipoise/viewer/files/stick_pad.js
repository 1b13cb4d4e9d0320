// A stick to walk with: a pad and a strip that are dragged by mouse or touch, and keys while either has
// the focus. What it says is written into the text box that follows it, as numbers in m/s, m/s, rad/s;
// let go, lost or out of sight it says zero.
(() => {
  "use strict";
  const GAP = 70; // [ms] between two messages, more than viser wants
  const IDLE = 0.12; // of its way, within which the pad says nothing
  const KEYS = {
    KeyW: [1, 0, 0], ArrowUp: [1, 0, 0], KeyS: [-1, 0, 0], ArrowDown: [-1, 0, 0],
    KeyA: [0, 0, 1], ArrowLeft: [0, 0, 1], KeyD: [0, 0, -1], ArrowRight: [0, 0, -1],
    KeyQ: [0, 1, 0], KeyE: [0, -1, 0],
  };
  const setText = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const held = new Set(); // keys
  const dragged = new Map(); // what a pointer says, by its number
  let said = [0, 0, 0];
  let timer = 0;
  let free = 0; // when the next message may go [ms]

  const stick = () => document.getElementById("equipoise-stick");
  const within = (value) => Math.max(-1, Math.min(1, value));

  function box() {
    for (let above = stick(); above; above = above.parentElement) {
      const found = above.querySelector("input.mantine-TextInput-input");
      if (found) return found;
    }
    return null;
  }

  function tell() {
    timer = 0;
    const target = box();
    if (!target) return;
    const most = ["forward", "left", "turn"].map((name) => Number(stick().dataset[name]));
    free = performance.now() + GAP;
    setText.call(target, said.map((share, k) => (share * most[k]).toFixed(3)).join(" "));
    target.dispatchEvent(new Event("input", { bubbles: true }));
  }

  function update() {
    const sum = [0, 0, 0];
    const parts = [...dragged.values()].map((one) => one.says);
    held.forEach((code) => parts.push(KEYS[code]));
    parts.forEach((part) => part.forEach((value, k) => (sum[k] += value)));
    const now = sum.map(within);
    if (stick()) {
      show("pad", -now[2], -now[0]);
      show("strip", -now[1], 0);
    }
    if (now.every((value, k) => value === said[k])) return;
    said = now;
    if (!timer) timer = setTimeout(tell, Math.max(0, free - performance.now()));
  }

  function show(part, x, y) {
    const area = stick().querySelector(`[data-part="${part}"]`);
    const knob = area.firstElementChild;
    const [wide, high] = [area.clientWidth - knob.offsetWidth, area.clientHeight - knob.offsetHeight];
    knob.style.transform = `translate(${(x * wide) / 2}px, ${(y * high) / 2}px)`;
  }

  function says(area, event) {
    const frame = area.getBoundingClientRect();
    const far = (value) => (Math.abs(value) < IDLE ? 0 : within(value));
    const x = far((2 * (event.clientX - frame.left)) / frame.width - 1);
    const y = far((2 * (event.clientY - frame.top)) / frame.height - 1);
    return area.dataset.part === "pad" ? [-y, 0, -x] : [0, -x, 0];
  }

  const areaOf = (element) => element.closest?.("#equipoise-stick [data-part]") ?? null;

  function onDown(event) {
    const area = areaOf(event.target);
    if (!area) return;
    area.focus({ preventScroll: true });
    area.setPointerCapture(event.pointerId);
    dragged.set(event.pointerId, { area, says: says(area, event) });
    event.preventDefault();
    event.stopPropagation();
    update();
  }

  function onMove(event) {
    const one = dragged.get(event.pointerId);
    if (!one) return;
    one.says = says(one.area, event);
    event.stopPropagation();
    update();
  }

  function onUp(event) {
    if (dragged.delete(event.pointerId)) update();
  }

  // A key belongs to the stick while it has the focus: the camera goes by the same keys.
  function onKey(event) {
    if (!(event.code in KEYS) || event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.type === "keyup") {
      if (held.delete(event.code)) update();
      return;
    }
    if (!areaOf(document.activeElement)) return;
    event.preventDefault();
    event.stopPropagation();
    held.add(event.code);
    update();
  }

  // At once: a page that goes away may never come to what was put off.
  function letGo() {
    held.clear();
    dragged.clear();
    update();
    if (!timer) return;
    clearTimeout(timer);
    tell();
  }

  window.addEventListener("pointerdown", onDown, true);
  window.addEventListener("pointermove", onMove, true);
  ["pointerup", "pointercancel", "lostpointercapture"].forEach((name) =>
    window.addEventListener(name, onUp, true)
  );
  window.addEventListener("keydown", onKey, true);
  window.addEventListener("keyup", onKey, true);
  window.addEventListener("focusout", (event) => {
    if (areaOf(event.target) && held.size) {
      held.clear();
      update();
    }
  }, true);
  window.addEventListener("blur", letGo);
  window.addEventListener("pagehide", letGo);
  document.addEventListener("visibilitychange", () => document.hidden && letGo());
})();
