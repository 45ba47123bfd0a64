// Which way x, y and z go, how long a metre is, and what the colours mean.

import { element, number } from "./dom.js";

const SIZE = 64, ARM = 22; // [pixel] of the picture of the axes
const LETTERS = ["x", "y", "z"];
const NS = "http://www.w3.org/2000/svg";

/** Build the corner of the scene that explains it; `show(camera)` turns its axes. */
export function buildCompass(data, moves, stage) {
  const picture = made("svg", { viewBox: `0 0 ${SIZE} ${SIZE}`, class: "axes", role: "img", "aria-label": "Directions of x, y and z" });
  const arms = LETTERS.map((letter) => {
    const line = made("line", { class: letter }), text = made("text", { class: letter });
    text.textContent = letter;
    picture.append(line, text);
    return { line, text };
  });
  const rows = [
    data.start && ["start", "start"], (data.goal || data.points.length) && ["goal", "goal"],
    moves && ["way", "path so far"], moves && ["ahead", "path ahead"],
    data.cones.some(({ forbidden }) => !forbidden) && ["target", "target"],
    data.cones.some(({ forbidden }) => forbidden) && ["keep-out", "keep out"],
    data.obstacles.some(({ veiled }) => veiled) && ["veiled", "walls seen through"],
  ].filter(Boolean).map(([kind, text]) => element("li", {}, element("i", { class: kind }), text));
  const grid = data.floor && data.floor.lines.count && data.setting.name !== "hall"
    ? [element("p", { class: "grid" }, `grid ${number(data.floor.step)} m`)] : [];
  const legend = element("div", { id: "legend" }, picture, element("div", {}, element("ul", { "aria-label": "Legend" }, ...rows), ...grid));
  stage.append(legend);
  const show = (camera) => {
    const turn = camera.matrixWorldInverse;
    const seen = LETTERS.map((_, k) => new THREE.Vector3(k === 0 ? 1 : 0, k === 1 ? 1 : 0, k === 2 ? 1 : 0).transformDirection(turn));
    seen.forEach(({ x, y }, k) => {
      const middle = SIZE / 2, { line, text } = arms[k];
      set(line, { x1: middle, y1: middle, x2: middle + ARM * x, y2: middle - ARM * y });
      set(text, { x: middle + (ARM + 7) * x, y: middle - (ARM + 7) * y + 3.5 });
    });
  };
  return { object: { get visible() { return !legend.hidden; }, set visible(on) { legend.hidden = !on; } }, show };
}

function made(name, attributes) {
  return set(document.createElementNS(NS, name), attributes);
}

function set(part, attributes) {
  for (const [key, value] of Object.entries(attributes)) part.setAttribute(key, value);
  return part;
}
