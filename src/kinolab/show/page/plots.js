// States and inputs over time, with a cursor; a click in a plot sets the time.

import { element, number, section, unitText } from "./dom.js";
import { gently } from "./gently.js";
import { named } from "./names.js";
import { rowAt } from "./motion.js";

const FIRST = [3, 2]; // plots that are shown at first, of states and of inputs
const CLOSEST = 0.02; // of the whole time: the least that plots show

/** Return the part of the panel with plots; they follow the clock; `repainted` lists what a new theme needs. */
export function buildPlots(data, array, clock, repainted) {
  const knots = array(data.knots), plots = element("div"), chips = element("div", { class: "chips" });
  const shown = [], span = buildSpan(knots, () => shown.forEach((plot) => { plot.draw(); plot.follow(clock.time); }));
  const states = data.series.filter(({ title }) => title !== "Angles" && title !== "Cost");
  data.series.forEach((series) => {
    const values = array(series.values), rows = values.length / Math.max(series.names.length, 1);
    const first = series.first ?? firstShown(series, FIRST[states.indexOf(series)] ?? 0);
    if (series.names.length) chips.append(element("h3", {}, series.title));
    series.names.forEach((name, k) => {
      const line = { name, unit: unitText(series.units[k]), held: series.held, limits: series.limits[k] ?? null,
                     values: values.subarray(k * rows, (k + 1) * rows) };
      const plot = buildPlot(line, knots, clock, span), chip = element("button", { type: "button" }, named(name));
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
  return section("Plots", true, chips, plots, element("p", { class: "hint" }, "Click to jump to a time, scroll to zoom, double-click to reset."));
}

/** The first columns that have a unit: an entry of a quaternion tells nobody much. */
function firstShown({ names, units }, most) {
  const all = [...names.keys()];
  return [...all.filter((k) => units[k]), ...all.filter((k) => !units[k])].slice(0, most);
}

/** The part of the time that all plots show; `zoom(t, factor)` changes it about a time. */
function buildSpan(knots, changed) {
  const first = knots[0], last = knots[knots.length - 1];
  const span = { from: first, to: last };
  span.share = (t) => (t - span.from) / Math.max(span.to - span.from, 1e-12);
  span.time = (share) => span.from + share * (span.to - span.from);
  span.zoom = (t, factor) => {
    const width = Math.min(Math.max((span.to - span.from) * factor, (last - first) * CLOSEST), last - first);
    span.from = Math.min(Math.max(t - span.share(t) * width, first), last - width);
    span.to = span.from + width;
    changed();
  };
  span.all = () => { span.from = first; span.to = last; changed(); };
  return span;
}

function buildPlot({ name, unit, held, limits, values }, knots, clock, span) {
  const [low, high] = rangeOf(values), within = limitsIn(limits, low, high);
  const canvas = element("canvas", { role: "img",
    "aria-label": `${name} over time, from ${number(low)} to ${number(high)} ${unit}` });
  const cursor = element("div", { class: "cursor" }), mark = element("div", { class: "hover", hidden: "" });
  const area = element("div", { class: "area" }, canvas, cursor, mark);
  const output = element("output");
  const label = element("span", {}, named(name, "b"), " ", element("span", { class: "unit" }, unit && `[${unit}]`));
  const ends = element("div", { class: "ends", "aria-hidden": "true" }, element("span", {}, number(high)), element("span", {}, number(low)));
  const times = [element("span"), element("span"), element("span")];
  const axis = element("div", { class: "times", "aria-hidden": "true" }, ...times);
  const frame = element("div", { class: "frame" }, ends, area, axis);
  const told = limitWords(within, unit);
  const figure = element("figure", { class: "plot", "data-name": name }, element("figcaption", {}, label, output), frame,
    ...(told ? [element("p", { class: "limit" }, told)] : []));
  const timeOf = (event) => {
    const box = area.getBoundingClientRect();
    return span.time((event.clientX - box.left) / box.width);
  };
  const tell = (t) => { output.textContent = number(at(knots, values, held, t)); };
  area.addEventListener("pointerdown", (event) => { area.setPointerCapture(event.pointerId); clock.pause(); clock.seek(timeOf(event)); });
  area.addEventListener("pointermove", (event) => {
    const t = timeOf(event);
    if (event.buttons) { clock.seek(t); return; }
    mark.hidden = false;
    mark.style.transform = `translateX(${100 * span.share(t)}%)`;
    output.textContent = `${number(at(knots, values, held, t))} at ${t.toFixed(2)} s`;
  });
  area.addEventListener("pointerleave", () => { mark.hidden = true; tell(clock.time); });
  area.addEventListener("wheel", (event) => { event.preventDefault(); span.zoom(timeOf(event), Math.exp(0.002 * event.deltaY)); }, { passive: false });
  area.addEventListener("dblclick", span.all);
  const draw = () => {
    drawLine(canvas, { low, high, held, values, knots, share: span.share, within });
    [span.from, (span.from + span.to) / 2, span.to].forEach((t, k) => { times[k].textContent = `${number(Number(t.toFixed(2)))}${k === 2 ? " s" : ""}`; });
  };
  new ResizeObserver(draw).observe(canvas);
  const follow = (t) => {
    const share = span.share(t);
    cursor.style.transform = `translateX(${100 * share}%)`;
    cursor.hidden = share < 0 || share > 1;
    if (mark.hidden) tell(t);
  };
  return { figure, follow, draw };
}

/** Say what limits a plot shows, and whose they are. */
function limitWords(within, unit) {
  if (!within.length) return "";
  const values = within.map(({ value }) => number(value)).join(" and "), word = within.length > 1 ? "limits" : "limit";
  return `${word} ${within[0].whose}: ${values} ${unit}`.trim();
}

/** The limits of a quantity that its plot reaches, or nearly: others would be outside of it. */
function limitsIn(limits, low, high) {
  if (!limits) return [];
  const [lower, upper, whose] = limits, margin = 0.15 * (high - low);
  return [lower, upper].filter((value) => value !== null && value > low - margin && value < high + margin).map((value) => ({ value, whose }));
}

/** Draw a line once; only the cursor, a layer of its own, moves over it. */
function drawLine(canvas, { low, high, held, values, knots, share, within }) {
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
  pen.strokeStyle = style.getPropertyValue("--bad");
  pen.setLineDash([4, 3]);
  for (const { value } of within) pen.strokeRect(0, y(value), width, 0);
  pen.setLineDash([]);
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
