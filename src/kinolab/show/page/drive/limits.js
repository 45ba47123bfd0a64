// The state in numbers, with what has left its limits in words.

import { element, number, unitText } from "../dom.js";
import { named } from "../names.js";

/** Build the table; `show(state)` fills it and returns the names of what is outside. */
export function buildLimits(names, units, bounds) {
  const cells = names.map(() => element("output"));
  const rows = names.map((name, k) => element("div", {}, named(name), cells[k]));
  const whole = element("div", { class: "state" }, ...rows);
  const show = (state) => {
    const outside = names.filter((_, k) => leaves(state[k], bounds[k]));
    names.forEach((name, k) => {
      cells[k].textContent = `${number(state[k])} ${unitText(units[k])}`.trim();
      const [lower, upper] = bounds[k];
      rows[k].classList.toggle("outside", outside.includes(name));
      rows[k].title = lower === null && upper === null ? "" : `from ${number(lower)} to ${number(upper)} ${unitText(units[k])}`;
    });
    return outside;
  };
  return { whole, show };
}

function leaves(value, [lower, upper]) {
  return (lower !== null && value < lower) || (upper !== null && value > upper);
}
