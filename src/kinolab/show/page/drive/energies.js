// Kinetic and potential energy as bars, and their sum.

import { element, number } from "../dom.js";

const KINDS = [["kinetic", "Kinetic"], ["potential", "Potential"], ["total", "Total"]];

/** Build the bars; `show({kinetic, potential})` moves them, null empties them, `reset` forgets the largest energy. */
export function buildEnergies() {
  const whole = element("div", { class: "energies" }), bars = {};
  for (const [kind, label] of KINDS) {
    const bar = element("i", { class: kind }), value = element("output");
    whole.append(element("span", {}, label), element("div", { class: "bar" }, bar), value);
    bars[kind] = { bar, value };
  }
  let largest = 1e-9, level = null; // [J]; potential energy counts from where the motion began

  const show = (energy) => {
    if (energy === null) { // beyond all numbers, after a motion that exploded
      for (const { bar, value } of Object.values(bars)) { bar.style.width = "0"; value.textContent = "–"; }
      return;
    }
    const { kinetic, potential } = energy;
    level ??= potential;
    const values = { kinetic, potential: potential - level, total: kinetic + potential - level };
    largest = Math.max(largest, ...Object.values(values).map(Math.abs));
    for (const [kind] of KINDS) {
      const share = values[kind] / largest, { bar, value } = bars[kind];
      bar.style.left = `${50 + 50 * Math.min(share, 0)}%`;
      bar.style.width = `${50 * Math.abs(share)}%`;
      value.textContent = `${number(values[kind])} J`;
    }
  };
  return { whole, show, reset: () => { largest = 1e-9; level = null; } };
}
