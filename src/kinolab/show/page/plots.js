// States and inputs over time, with a cursor; a click in a plot sets the time.

import { element, number, section } from "./dom.js";
import { gently } from "./gently.js";
import { rowAt } from "./motion.js";

const FIRST = [3, 2]; // plots that are shown at first, of states and of inputs

/** Return the part of the panel with plots; they follow the clock; `repainted` lists what a new theme needs. */
export function buildPlots(data, array, clock, repainted) {
  const knots = array(data.knots), plots = element("div"), chips = element("div", { class: "chips" });
  const shown = [];
  data.series.forEach((series, group) => {
    const values = array(series.values), rows = values.length / Math.max(series.names.length, 1);
    const first = first_shown(series, FIRST[group] ?? 0);
    if (series.names.length) chips.append(element("h3", {}, series.title));
    series.names.forEach((name, k) => {
      const line = { name, unit: series.units[k], held: series.held, values: values.subarray(k * rows, (k + 1) * rows) };
      const plot = buildPlot(line, knots, clock), chip = element("button", { type: "button" }, name);
      const toggle = (on) => {
        chip.setAttribute("aria-pressed", on);
        plot.figure.hidden = !on;
      };
      chip.addEventListener("click", () => { toggle(plot.figure.hidden); plot.follow(clock.time); });
      toggle(first.includes(k));
      chips.append(chip);
      plots.append(plot.figure);
      shown.push(plot);
    });
  });
  gently(clock, () => shown.forEach((plot) => { if (!plot.figure.hidden) plot.follow(clock.time); }));
  repainted.push(() => shown.forEach((plot) => plot.draw()));
  return section("Plots", true, chips, plots);
}

/** The first columns that have a unit: an entry of a quaternion tells nobody much. */
function first_shown({ names, units }, most) {
  const all = [...names.keys()];
  return [...all.filter((k) => units[k]), ...all.filter((k) => !units[k])].slice(0, most);
}

function buildPlot({ name, unit, held, values }, knots, clock) {
  const [low, high] = rangeOf(values), first = knots[0], last = knots[knots.length - 1];
  const share = (t) => (t - first) / Math.max(last - first, 1e-12);
  const canvas = element("canvas", { role: "img",
    "aria-label": `${name} over time, from ${number(low)} to ${number(high)} ${unit}` });
  const cursor = element("div", { class: "cursor" }), area = element("div", { class: "area" }, canvas, cursor);
  const output = element("output");
  const label = element("span", {}, element("b", {}, name), " ", element("span", { class: "unit" }, unit && `[${unit}]`));
  const ends = element("div", { class: "ends", "aria-hidden": "true" }, element("span", {}, number(high)), element("span", {}, number(low)));
  const frame = element("div", { class: "frame" }, ends, area);
  const figure = element("figure", { class: "plot" }, element("figcaption", {}, label, output), frame);
  const scrub = (event) => {
    const box = area.getBoundingClientRect();
    clock.seek(first + ((event.clientX - box.left) / box.width) * (last - first));
  };
  area.addEventListener("pointerdown", (event) => { area.setPointerCapture(event.pointerId); clock.pause(); scrub(event); });
  area.addEventListener("pointermove", (event) => { if (event.buttons) scrub(event); });
  const draw = () => drawLine(canvas, { low, high, held, values, knots, share });
  new ResizeObserver(draw).observe(canvas);
  const follow = (t) => {
    cursor.style.transform = `translateX(${100 * share(t)}%)`;
    output.textContent = number(at(knots, values, held, t));
  };
  return { figure, follow, draw };
}

/** Draw a line once; only the cursor, a layer of its own, moves over it. */
function drawLine(canvas, { low, high, held, values, knots, share }) {
  const style = getComputedStyle(canvas), ratio = devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight, pen = canvas.getContext("2d");
  if (!width) return;
  canvas.width = width * ratio; canvas.height = height * ratio;
  pen.scale(ratio, ratio);
  const x = (t) => share(t) * width, y = (value) => height * (0.93 - (0.86 * (value - low)) / (high - low));
  if (low < 0 && high > 0) {
    pen.strokeStyle = style.getPropertyValue("--line");
    pen.strokeRect(0, Math.round(y(0)) + 0.5, width, 0);
  }
  pen.strokeStyle = style.getPropertyValue("--accent");
  pen.lineWidth = 1.6; pen.lineJoin = "round";
  pen.beginPath();
  values.forEach((value, k) => {
    pen.lineTo(x(knots[k]), y(value));
    if (held) pen.lineTo(x(knots[k + 1]), y(value));
  });
  pen.stroke();
}

/** The value at a time: the one that is held, or on the line between two knots. */
function at(knots, values, held, t) {
  if (knots.length < 2) return values[0];
  const row = rowAt(knots, t), s = Math.min(Math.max((t - knots[row]) / (knots[row + 1] - knots[row]), 0), 1);
  return held ? values[Math.min(row, values.length - 1)] : values[row] + s * (values[row + 1] - values[row]);
}

function rangeOf(values) {
  let low = Infinity, high = -Infinity;
  for (const value of values) { low = Math.min(low, value); high = Math.max(high, value); }
  if (!(high >= low)) return [-1, 1];
  const least = Math.max(1e-9, 1e-6 * Math.max(Math.abs(low), Math.abs(high))); // rounding is no curve
  return high - low > least ? [low, high] : [low - 0.5, high + 0.5];
}
