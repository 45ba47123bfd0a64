// Drive it yourself: the page simulates the machine, and keys push its inputs.

import { rowAt } from "../motion.js";
import { buildCockpit } from "./cockpit.js";
import { buildCompanion } from "./companion.js";
import { buildDriven } from "./driven.js";
import { buildFlash } from "./flash.js";
import { buildHands } from "./hands.js";
import { buildSimulator } from "./simulator.js";

/**
 * Build the drive mode of a page.
 *
 * `machine` is simulated as `data` says: {start, step, method, substeps, bounds, plant, closed}. `plan` has
 * {clock, motion, knots, states}, `figure` is the page's picture of the machine; `changed` asks for
 * a new picture; `around` has {names, surfaces, contacts, switched} of the obstacles. The plan goes on beside the driven machine, as a ghost at the clock's time.
 */
export function buildDrive(data, machine, plan, figure, changed, around) {
  const { clock } = plan, planned = clock.last > clock.first;
  const drive = { active: false, paused: false, listeners: [] };
  const keys = { " ": () => drive.pause(), Home: () => drive.reset(), End: () => drive.rejoin(), Escape: () => drive.set(false) };
  const hands = buildHands(data, () => drive.active, keys);
  const simulator = buildSimulator(machine, { ...data, dt: data.step, inputsAt: hands.inputs });
  const driven = buildDriven(machine, figure), companion = planned && buildCompanion(figure.bodies, plan.motion);
  let origin = clock.first, shown = planned; // when the driven motion began in the plan; whether the ghost is seen
  const flash = buildFlash(figure.bodies, around.surfaces);
  let contacts = null; // read when somebody drives
  let { speed } = clock; // of the plan's film; one drives as fast as the machine moves

  const begin = (state, t) => {
    simulator.reset(state);
    hands.release();
    cockpit.reset();
    origin = t;
    clock.seek(t);
    changed();
  };
  drive.reset = (state = data.start) => begin(state, clock.first);
  /** Go on from where the plan is: from the stored state at or before the clock's time. */
  drive.rejoin = () => {
    const row = clock.time >= clock.last ? plan.knots.length - 1 : rowAt(plan.knots, clock.time);
    const width = machine.stateNames.length;
    begin(planned ? plan.states.subarray(row * width, (row + 1) * width) : data.start, plan.knots[row]);
  };
  drive.pause = () => { drive.paused = !drive.paused; changed(); };
  drive.close = (closed) => {
    simulator.close(closed);
    hands.arrange(simulator.loop, simulator.loop !== machine.plant);
    cockpit.arrange(hands.channels, simulator.loop.inputs);
  };
  drive.setParameter = (index, value) => { simulator.setParameter(index, value); cockpit.reset(); changed(); };

  const layer = (label, set) => ({ label, on: true, set: (on) => { set(on); changed(); } });
  const layers = [...(planned ? [layer("Show the plan as a ghost", (on) => { shown = on; })] : []),
                  ...(machine.constraints.length ? [layer("Constraint forces", (on) => { driven.forces = on; })] : [])];
  const cockpit = buildCockpit(machine, data.bounds, {
    reset: () => drive.reset(), rejoin: planned && drive.rejoin, pause: drive.pause, close: drive.close, layers,
    hold: hands.hold, strength: (share) => { hands.strength = share; }, parameter: drive.setParameter,
  });

  drive.set = (on) => {
    drive.active = on;
    drive.paused = false;
    if (on) { contacts ??= around.contacts(); clock.pause(); ({ speed } = clock); drive.reset(); } else { driven.hide(); hands.release(); light([]); }
    clock.setSpeed(on ? 1 : speed);
    if (companion) companion.group.visible = on && shown;
    drive.listeners.forEach((listener) => listener(on));
    changed();
  };
  drive.toggle = () => drive.set(!drive.active);
  /** Let the viewer's seconds pass; says whether anything moved. */
  drive.pass = (seconds) => {
    if (drive.paused) return false;
    simulator.pass(seconds * clock.speed);
    clock.seek(origin + simulator.time);
    return true;
  };
  /** Bodies and obstacles that touch light up. */
  const light = (pairs) => { if (flash(pairs)) around.switched(); };
  /** Pairs of names of what touches now. */
  drive.touching = () => {
    const { state, parameters } = simulator, poses = machine.frames(state, parameters);
    const pairs = contacts ? contacts.touching(poses, machine.shapes(parameters)) : [];
    light(pairs);
    return pairs.map(([body, obstacle]) => [around.names.bodies[body], around.names.obstacles[obstacle]]);
  };
  drive.show = () => {
    const facts = { ...driven.show(simulator), touching: drive.touching() };
    if (companion) { companion.group.visible = shown; companion.show(clock.time); }
    cockpit.show({ ...facts, simulator, paused: drive.paused });
  };
  drive.joints = () => machine.jointFrames(simulator.state, simulator.parameters);
  drive.middle = () => new THREE.Vector3(...driven.middle(simulator));
  drive.paint = (colors) => { driven.paint(colors); companion && companion.paint(colors); };
  drive.close(true);
  return Object.assign(drive, { simulator, hands, panel: cockpit.whole, groups: [driven.group, companion && companion.group].filter(Boolean) });
}

/** What tests and teachers may call. */
export function offeredDrive(drive) {
  const { simulator } = drive;
  return {
    get active() { return drive.active; },
    get paused() { return drive.paused; },
    get state() { return Array.from(simulator.state); },
    get begin() { return Array.from(simulator.begin); },
    get time() { return simulator.time; },
    get failure() { return simulator.failure; },
    get touching() { return drive.touching(); },
    get log() { return simulator.log.map(({ parameters, ...entry }) => ({ ...entry, parameters: Array.from(parameters) })); },
    dt: simulator.dt,
    start: () => drive.set(true), stop: () => drive.set(false),
    pause: drive.pause, reset: drive.reset, rejoin: drive.rejoin, close: drive.close,
    step: (inputs) => { simulator.step(inputs); drive.show(); },
    setParameter: drive.setParameter,
  };
}
