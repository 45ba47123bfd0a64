// Sliders for the machine's parameters: mass, length and gravity first.

import { element, number, unitText } from "../dom.js";
import { named } from "../names.js";

const FIRST = ["kg", "m", "m/s^2"]; // units of what one wants to change
const MOST = 6; // sliders that are shown at first
const STEPS = 200;

/** Build the sliders of parameters {name, unit, value, lower, upper}; `change(index, value)`. */
export function buildSliders(parameters, change) {
  const order = [...parameters.keys()].sort((a, b) => rank(parameters[a]) - rank(parameters[b]) || a - b);
  const made = order.map((index) => buildSlider(parameters[index], (value) => change(index, value)));
  const button = element("button", { type: "button", class: "wide" }, "Reset parameters");
  button.addEventListener("click", () => made.forEach(({ reset }) => reset()));
  const rows = made.map(({ row }) => row), whole = element("div", { class: "sliders" }, ...rows.slice(0, MOST));
  if (rows.length > MOST) {
    const summary = element("summary", {}, `${rows.length - MOST} more`);
    whole.append(element("details", { class: "more" }, summary, ...rows.slice(MOST)));
  }
  if (rows.length) whole.append(button);
  return { whole, reset: () => made.forEach(({ reset }) => reset()) };
}

function rank({ unit }) {
  const place = FIRST.indexOf(unit);
  return place < 0 ? FIRST.length : place;
}

function buildSlider({ name, unit, value, lower, upper }, change) {
  const { toShare, toValue } = scaleOf(value, lower, upper);
  const slider = element("input", { type: "range", min: 0, max: STEPS, step: 1, "aria-label": `${name} in ${unit || "1"}` });
  const output = element("output");
  const tell = (present) => {
    output.textContent = `${number(present)} ${unitText(unit)}`;
    row.classList.toggle("changed", present !== value);
  };
  const row = element("label", { class: "slider" }, named(name, "b"), slider, output);
  slider.addEventListener("input", () => {
    const middle = Number(slider.value) === Math.round(STEPS * toShare(value));
    const chosen = middle ? value : toValue(Number(slider.value) / STEPS);
    tell(chosen);
    change(chosen);
  });
  const reset = () => {
    slider.value = Math.round(STEPS * toShare(value));
    tell(value);
    change(value);
  };
  slider.value = Math.round(STEPS * toShare(value));
  tell(value);
  return { row, reset };
}

/** Ratios where both ends have one sign: a quarter is as far from the middle as four times. */
function scaleOf(value, lower, upper) {
  if (lower * upper > 0) {
    const span = Math.log(upper / lower);
    return { toShare: (x) => Math.log(x / lower) / span, toValue: (s) => lower * Math.exp(s * span) };
  }
  return { toShare: (x) => (x - lower) / (upper - lower), toValue: (s) => lower + s * (upper - lower) };
}
