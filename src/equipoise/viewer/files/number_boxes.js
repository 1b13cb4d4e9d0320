// What is typed into a number box is told when Enter is pressed or the box is left, and arrives.
//
// viser tells each key, so that typing 7.5 asks for 7 first; and of messages that follow each other
// within 50 ms it sends only the last, so that a button pressed at once swallows the 5. Here the
// keys are held back, and what is told is told one by one.
(() => {
  "use strict";
  const GAP = 60; // [ms] between two messages, more than viser wants
  const held = new Set(); // boxes with text that was not told yet
  const setText = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  let free = 0; // when the next message may go [ms]
  let passing = false; // what happens now comes from here

  const isBox = (element) =>
    element instanceof HTMLInputElement && ["decimal", "numeric"].includes(element.inputMode);

  // Later, even without a wait: a box that is left first puts its old number back.
  function inTurn(act) {
    const wait = Math.max(0, free - performance.now());
    free = performance.now() + wait + GAP;
    setTimeout(() => {
      passing = true;
      try {
        act();
      } finally {
        passing = false;
      }
    }, wait);
  }

  function tell(box) {
    if (!held.delete(box)) return;
    const text = box.value;
    box.style.fontStyle = "";
    inTurn(() => replaceAll(box, text));
  }

  // The page takes a new text only where it saw the old one selected when a key went down.
  function replaceAll(box, text) {
    const before = box.getAttribute("value");
    setText.call(box, before);
    box.setSelectionRange(0, before.length);
    box.dispatchEvent(new KeyboardEvent("keydown", { key: text[0] ?? "", bubbles: true }));
    setText.call(box, text);
    box.setSelectionRange(text.length, text.length);
    box.dispatchEvent(new Event("input", { bubbles: true }));
  }

  function onText(event) {
    if (passing || !isBox(event.target)) return;
    event.stopImmediatePropagation();
    if (event.type === "change") return tell(event.target);
    event.target.style.fontStyle = "italic";
    held.add(event.target);
  }

  function onKey(event) {
    if (!passing && ["Enter", "ArrowUp", "ArrowDown"].includes(event.key)) {
      tell(event.target);
    }
  }

  function onClick(event) {
    const button = passing ? null : event.target.closest("button");
    if (!button) return;
    held.forEach(tell);
    if (performance.now() < free) {
      event.stopImmediatePropagation();
      event.preventDefault();
      inTurn(() => button.click());
    } else free = performance.now() + GAP;
  }

  window.addEventListener("input", onText, true);
  window.addEventListener("change", onText, true);
  window.addEventListener("keydown", onKey, true);
  window.addEventListener("focusout", (event) => tell(event.target), true);
  window.addEventListener("click", onClick, true);
})();
