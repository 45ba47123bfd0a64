// The driven machine in the scene: its bodies and cables between two steps, and its arrows.

import { buildArrows } from "./arrows.js";
import { between, poseBetween } from "./between.js";
import { buildResizing } from "./resizing.js";

/** Build what is seen of a driven machine; `figure` is the page's own, which it moves. */
export function buildDriven(machine, figure) {
  const arrows = buildArrows(figure.reach), resizing = buildResizing(machine, figure.bodies);
  const driven = { group: arrows.group, paint: arrows.paint, forces: true };

  /** Draw the machine as simulated; returns {energy, longest} of its last state. */
  driven.show = (simulator) => {
    const { before, state, share, parameters } = simulator;
    const inputs = simulator.inputs ?? simulator.loop.inputs.map(() => 0);
    const [first, last] = [before, state].map((x) => machine.frames(x, parameters));
    figure.bodies.forEach((_, k) => {
      const { place, turn } = poseBetween(first, last, k, share);
      figure.put(k, place, turn, simulator.time);
    });
    if (machine.cables) {
      const [a, b] = [before, state].map((x) => machine.cableEnds(x, parameters));
      figure.pull(between(a, b, share));
    }
    resizing.show(parameters);
    arrows.group.visible = driven.forces && machine.constraints.length > 0;
    const forces = arrows.group.visible ? simulator.loop.arrows(state, inputs, parameters) : [];
    return { energy: energyOf(simulator, inputs), longest: arrows.group.visible ? arrows.show(forces) : null };
  };
  driven.hide = () => { arrows.group.visible = false; resizing.undo(); };
  driven.middle = ({ state, parameters }) => {
    const poses = machine.frames(state, parameters), count = figure.bodies.length;
    return [3, 7, 11].map((k) => figure.bodies.reduce((sum, _, body) => sum + poses[12 * body + k], 0) / count);
  };
  return driven;
}

function energyOf({ loop, state, parameters }, inputs) {
  if (!loop.hasEnergy) return null;
  try {
    return loop.energy(state, inputs, parameters);
  } catch {
    return null; // where the equations have no solution there is none
  }
}
