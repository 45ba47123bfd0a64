// A search while it goes on: what is being done, and the best duration so far as a curve.

import { element, number, section } from "./dom.js";

const PHASES = [["search", "Searching"], ["verify", "Verifying"], ["optimise", "Optimising"], ["draw", "Drawing"]];
const WIDE = 300, HIGH = 90, EDGE = 4; // of the curve's picture

/** Build the part of the panel that tells how a search goes; `phase(name)` and `best(points)` change it. */
export function buildBest() {
  const steps = PHASES.map(([name, label]) => [name, element("li", {}, label)]);
  const output = element("output"), curve = element("div", { class: "curve", role: "img", "aria-label": "Duration of the best motion so far over time" });
  const times = [element("span"), element("span")], axis = element("div", { class: "times", "aria-hidden": "true" }, ...times);
  const whole = section("Progress", true, element("ol", { class: "phases" }, ...steps.map(([, step]) => step)),
    element("div", { class: "best", hidden: "" }, element("p", {}, "Best motion so far: ", output), curve, axis));

  /** Mark what is being done, and return what it is called. */
  const phase = (name) => {
    steps.forEach(([own, step]) => {
      if (own === name) step.setAttribute("aria-current", "step"); else step.removeAttribute("aria-current");
      if (own === name) step.classList.add("begun");
    });
    return PHASES.find(([own]) => own === name)[1];
  };
  const best = (points) => {
    const last = points.at(-1);
    whole.querySelector(".best").hidden = false;
    output.textContent = `${number(last[1])} s, after ${number(Number(last[0].toFixed(1)))} s`;
    curve.replaceChildren(drawn(points));
    times[0].textContent = "0"; times[1].textContent = `${number(Number(last[0].toFixed(1)))} s`;
  };
  return { whole, phase, best };
}

/** A line that falls whenever a shorter motion was found. */
function drawn(points) {
  const end = points.at(-1)[0] || 1, high = Math.max(...points.map(([, cost]) => cost));
  const x = (t) => EDGE + ((WIDE - 2 * EDGE) * t) / end, y = (cost) => HIGH - EDGE - ((HIGH - 2 * EDGE) * cost) / high;
  const line = points.map(([t, cost], k) => `${k ? `H${x(t).toFixed(1)}V` : `M${x(t).toFixed(1)} `}${y(cost).toFixed(1)}`).join("");
  const picture = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  picture.setAttribute("viewBox", `0 0 ${WIDE} ${HIGH}`);
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", line);
  picture.append(path);
  return picture;
}
