// Words in the scene: what start, goal and cones are, as small signs that keep their size.

import { element } from "./dom.js";

/** Build the signs of `entries` [{text, place}]; `show(camera, stage)` puts them where their things are. */
export function buildCaptions(entries, stage) {
  const layer = element("div", { id: "captions", "aria-hidden": "true" });
  const signs = entries.map(({ text, place }) => {
    const sign = element("span", { class: `sign ${text.replaceAll(" ", "-")}` }, text);
    layer.append(sign);
    return { sign, place: new THREE.Vector3(...place) };
  });
  stage.append(layer);
  const show = (camera) => {
    const width = stage.clientWidth, height = stage.clientHeight, taken = [];
    for (const { sign, place } of signs) {
      const seen = place.clone().project(camera);
      const x = (0.5 + seen.x / 2) * width, y = (0.5 - seen.y / 2) * height;
      const free = !taken.some(([a, b]) => Math.abs(a - x) < 56 && Math.abs(b - y) < 20);
      sign.hidden = !free || Math.abs(seen.z) > 1 || x < 0 || x > width || y < 14 || y > height;
      if (sign.hidden) continue;
      taken.push([x, y]);
      sign.style.transform = `translate(${x.toFixed(1)}px, ${(y - 6).toFixed(1)}px) translate(-50%, -100%)`;
    }
  };
  return { object: { get visible() { return !layer.hidden; }, set visible(on) { layer.hidden = !on; } }, show };
}
