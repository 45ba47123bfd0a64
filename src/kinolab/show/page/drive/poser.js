// A pose by hand: a slider for each coordinate, and what the constraints say.
//
// Loops stay closed: the other coordinates follow, by the least change. What is on velocities says
// nothing of a pose, but what it would miss if the coordinate moved alone.

import { element, number, section, unitText } from "../dom.js";
import { driven_machine } from "../driven_machine.js";
import { named } from "../names.js";
import { poseBetween } from "./between.js";
import { closed, normalised } from "./closure.js";

const CLOSED = 1e-9; // [m] or [rad], of a loop's gap
const KEPT = 1e-9; // of a rate's row: what is less has nothing to do with it
const FOLLOW = "The other coordinates follow, so that loops stay closed";

/** Let the reader pose the machine, where the page has its equations and no motion; else null. */
export function joinPoser(data, scene, byId) {
  const machine = driven_machine, figure = scene.machine;
  if (!machine || !data.posing || !figure) return null;
  const { sliders } = data.posing, start = Float64Array.from(data.driving.start);
  const x = closed(machine, start, sliders.length) ?? start;
  const poser = { active: true, groups: [], pass: () => false, paint: () => {} };
  let last = 0, follow = true; // the slider that was moved; whether loops are kept closed

  const rows = sliders.map((slider, k) => buildRow(slider, (value) => {
    last = k;
    const wanted = normalised(machine, x, k, value);
    const found = follow && machine.loops.length ? closed(machine, wanted, sliders.length, k) : wanted;
    x.set(found ?? wanted);
    data.driving.start = Array.from(x); // whoever drives begins here
    tell();
    scene.changed();
  }));
  const loops = machine.loops.map((loop) => buildResidual(loop));
  const slips = machine.slips.map((slip) => buildResidual(slip));
  const alone = element("h3");
  const tell = () => {
    rows.forEach((row, k) => row.show(x[k]));
    const gaps = machine.gaps(x), slipped = machine.slipRows(x);
    loops.forEach(({ show }, k) => show(gaps[k], Math.abs(gaps[k]) > CLOSED));
    const { rate, name, unit } = sliders[last], wide = slips.length ? slipped.length / slips.length : 0;
    alone.textContent = rate === null ? "" : `If ${name} alone moved at 1 ${unitText(unit ? `${unit}/s` : "1/s")}`;
    slips.forEach(({ show }, k) => {
      const missed = rate === null ? NaN : slipped[k * wide + rate];
      show(missed, Math.abs(missed) > KEPT);
    });
  };

  const box = element("input", { type: "checkbox", checked: "" });
  box.addEventListener("change", () => { follow = box.checked; });
  const part = section("Pose", true, element("div", { class: "cockpit" },
    element("div", { class: "sliders" }, ...rows.map(({ row }) => row)),
    ...(loops.length ? [element("div", { class: "switches" }, element("label", {}, box, FOLLOW)),
                        element("h3", {}, "Gaps of loops"), ...loops.map(({ row }) => row)] : []),
    ...(slips.length ? [alone, ...slips.map(({ row }) => row)] : [])));
  part.id = "pose";
  byId("panel").append(part);

  poser.joints = () => machine.jointFrames(x);
  poser.show = () => {
    const poses = machine.frames(x);
    figure.bodies.forEach((_, k) => {
      const { place, turn } = poseBetween(poses, poses, k, 0);
      figure.put(k, place, turn, 0);
    });
    if (machine.cables) figure.pull(machine.cableEnds(x));
  };
  poser.middle = () => {
    const poses = machine.frames(x), count = Math.max(figure.bodies.length, 1);
    return new THREE.Vector3(...[3, 7, 11].map((i) => figure.bodies.reduce((sum, _, k) => sum + poses[12 * k + i], 0) / count));
  };
  Object.defineProperty(poser, "state", { get: () => Array.from(x) });
  poser.set = (name, value) => rows[sliders.findIndex((slider) => slider.name === name)].set(value);
  scene.join(poser);
  tell();
  return poser;
}

function buildRow({ name, unit, lower, upper }, change) {
  const slider = element("input", { type: "range", min: lower, max: upper, step: "any", "aria-label": `${name} in ${unit || "1"}` });
  const output = element("output"), row = element("label", { class: "slider" }, named(name, "b"), slider, output);
  slider.addEventListener("input", () => change(Number(slider.value)));
  const show = (value) => {
    slider.value = value;
    output.textContent = `${number(value)} ${unitText(unit)}`;
  };
  return { row, show, set: change };
}

/** A constraint's row: its name, and what it misses; nothing to remark where it is kept. */
function buildResidual({ name, unit }) {
  const output = element("output"), row = element("div", { class: "residual" }, element("span", {}, name), output);
  const show = (value, missed) => {
    output.textContent = Number.isNaN(value) ? "" : missed ? `off by ${number(value)} ${unitText(unit)}` : "kept";
    row.classList.toggle("missed", missed);
  };
  return { row, show };
}
