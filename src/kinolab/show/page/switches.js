// What is shown in the scene, by switches.

import { element, section } from "./dom.js";

/** Return the part of the panel that shows and hides; `layers` has {label, object, on} each. */
export function buildSwitches(layers, changed) {
  const list = element("div", { class: "switches" });
  for (const { label, object, on } of layers.filter((layer) => layer.object)) {
    const box = element("input", { type: "checkbox" });
    box.checked = object.visible = on;
    box.addEventListener("change", () => { object.visible = box.checked; changed(); });
    object.toggle = () => box.click();
    list.append(element("label", {}, box, label));
  }
  return section("Show in the scene", false, list);
}
