// The part of the panel from which one drives: keys, controller, energies, state, parameters.

import { element, number, unitText } from "../dom.js";
import { named } from "../names.js";
import { buildEnergies } from "./energies.js";
import { buildLimits } from "./limits.js";
import { buildSliders } from "./sliders.js";

const NOTE = "Only the equations of motion act here: obstacles, the ground and limits do not stop the machine. Whatever it touches lights up.";

/**
 * Build the panel; `actions` has reset, rejoin, pause, close(on), strength(share), parameter(index,
 * value), hold(key, on) and layers [{label, on, set}].
 */
export function buildCockpit(machine, bounds, actions) {
  const status = element("p", { class: "status", role: "status" });
  const keys = element("div", { class: "keys" }), energies = machine.hasEnergy ? buildEnergies() : null;
  const limits = buildLimits(machine.stateNames, machine.stateUnits, bounds);
  const sliders = buildSliders(machine.parameters, actions.parameter);
  const force = element("p", { class: "force" });
  const whole = element("div", { class: "cockpit" }, status, keys, ...switches(machine, actions),
    buttons(actions), element("p", { class: "note" }, NOTE), force,
    ...(energies ? [element("h3", {}, "Energy since the start"), energies.whole] : []),
    ...(machine.parameters.length ? [element("h3", {}, "Parameters"), sliders.whole] : []),
    element("h3", {}, "State"), limits.whole);

  whole.addEventListener("click", ({ detail }) => { if (detail && !document.activeElement?.matches("[type=range]")) document.activeElement?.blur(); }); // keys drive again
  let meters = [];
  const arrange = (channels, inputs) => {
    meters = inputs.map((input) => buildMeter(input));
    keys.replaceChildren(...channels.map((channel) => keyRow(channel, actions.hold)), ...meters.map(({ row }) => row));
  };
  const show = ({ simulator, energy, longest, paused, touching }) => {
    const outside = limits.show(simulator.state);
    status.textContent = wordsOf(simulator, outside, paused, touching);
    status.classList.toggle("bad", simulator.failure !== null || outside.length > 0 || touching.length > 0);
    meters.forEach((meter, k) => meter.show(simulator.inputs?.[k] ?? null));
    if (energies) energies.show(energy);
    force.hidden = longest === null;
    if (longest !== null) force.textContent = `Longest arrow: ${number(longest)} N`;
  };
  return { whole, arrange, show, reset: () => energies?.reset(), resetParameters: sliders.reset };
}

function wordsOf({ time, failure }, outside, paused, touching) {
  const at = `${time.toFixed(2)} s`;
  if (failure) return `${at}: the machine stopped, ${failure}.`;
  if (touching.length) return `${at}: ${touching.map(([body, obstacle]) => `${body} touches ${obstacle}`).join(", ")}`;
  if (outside.length) return `${at}: outside its limits: ${outside.join(", ")}`;
  return paused ? `${at}, paused` : at;
}

function switches(machine, { layers, close, strength }) {
  const share = element("input", { type: "range", min: 0.05, max: 1, step: 0.05, value: 0.5, "aria-label": "How hard the keys push" });
  share.addEventListener("input", () => strength(Number(share.value)));
  const all = [...(machine.plant !== machine ? [{ label: "Controller", on: true, set: close }] : []), ...layers];
  const boxes = all.map(({ label, on, set }) => {
    const box = element("input", { type: "checkbox", ...(on ? { checked: "" } : {}) });
    box.addEventListener("change", () => set(box.checked));
    return element("label", {}, box, label);
  });
  return [element("label", { class: "slider" }, element("b", {}, "Push"), share, element("span", {}, "")),
          element("div", { class: "switches" }, ...boxes)];
}

function buttons({ pause, reset, rejoin }) {
  const made = [["Pause", "space", pause], ["Back to the start", "Home", reset], ["Join the plan", "End", rejoin]];
  return element("div", { class: "buttons" }, ...made.filter(([, , run]) => run).map(([label, key, run]) => {
    const button = element("button", { type: "button", title: `${label} (${key})` }, label);
    button.addEventListener("click", run);
    return button;
  }));
}

/** One pair of keys, which are buttons too: a phone has no arrow keys. */
function keyRow({ keys, shown, label, unit, sticky }, hold) {
  const order = keys[0] === "ArrowRight" ? [1, 0] : [0, 1]; // left is on the left
  const made = order.map((k) => {
    const key = keys[k];
    const button = element("button", { type: "button", class: "key", "aria-label": `${label} ${k ? "down" : "up"}` }, shown[k]);
    button.addEventListener("pointerdown", (event) => { button.setPointerCapture(event.pointerId); hold(key, true); });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
      button.addEventListener(end, () => hold(key, false));
    return button;
  });
  const text = `${label}${unit ? ` [${unitText(unit)}]` : ""}${sticky ? ", stays" : ""}`;
  return element("div", { class: "keyrow" }, ...made, element("span", {}, text));
}

function buildMeter({ name, unit, lower, upper }) {
  const bar = element("i"), output = element("output");
  const row = element("div", { class: "meter" }, named(name), element("div", { class: "bar" }, bar), output);
  const share = (value) => (100 * (value - lower)) / (upper - lower);
  const zero = Math.min(Math.max(share(0), 0), 100);
  const show = (value) => {
    const at = value === null ? zero : share(value);
    bar.style.left = `${Math.min(zero, at)}%`;
    bar.style.width = `${Math.abs(at - zero)}%`;
    output.textContent = value === null ? "" : `${number(value)} ${unitText(unit)}`;
  };
  return { row, show };
}
