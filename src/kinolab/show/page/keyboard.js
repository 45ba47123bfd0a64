// The keys of the page, and the list of them.

import { element } from "./dom.js";

const OF_SLIDERS = ["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "Home", "End", "PageUp", "PageDown"];

/** Connect keys with what they do; `actions` has {keys, shown, help, run} each. */
export function buildKeyboard(actions, dialog, list, button) {
  const open = () => (dialog.open ? dialog.close() : dialog.showModal());
  const all = [...actions, { keys: ["?"], shown: ["?"], help: "Keyboard shortcuts", run: open }];
  button.addEventListener("click", open);
  for (const { shown, help } of all.filter((action) => action.help)) {
    const term = element("dt");
    shown.forEach((key) => term.append(element("kbd", {}, key), " "));
    list.append(term, element("dd", {}, help));
  }
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    if (dialog.open && event.key !== "?") return;
    if (event.target.matches?.("input[type=range]:not(#scrub)") && OF_SLIDERS.includes(event.key)) return;
    const pressed = event.target.closest("button, summary, [type=checkbox]");
    if (pressed && [" ", "Enter"].includes(event.key)) return; // it is what is pressed
    const action = all.find(({ keys }) => keys.includes(event.key));
    if (!action) return;
    event.preventDefault();
    action.run(event);
  });
}

function typing(target) {
  return target.closest("select, textarea, input:not([type=range]):not([type=checkbox])") !== null;
}
