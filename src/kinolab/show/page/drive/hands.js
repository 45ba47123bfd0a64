// What the driver does: keys, sticks and buttons become the inputs of the next step.

import { buildInputs, channelsOf } from "./channels.js";
import { watchKeys } from "./pressed.js";

const STRENGTH = 0.5; // of keys at first

/** Build the hands of a driver; `data` has {idle, usual} inputs per loop and the step, `actions` other keys. */
export function buildHands(data, active, actions) {
  const hands = { channels: [], strength: STRENGTH };
  const keys = watchKeys(active, () => hands.channels, actions);
  let inputs = null;

  /** Take hold of other inputs: those of the machine, or the references of its controller. */
  hands.arrange = (loop, closed) => {
    hands.channels = channelsOf(loop.inputs, closed);
    inputs = buildInputs(loop.inputs, hands.channels, closed ? data.closed : data.plant, data.step);
    keys.clear();
  };
  hands.inputs = () => inputs.at(keys.pushes(), hands.strength);
  hands.release = () => { keys.clear(); inputs?.reset(); };
  hands.hold = keys.hold;
  return hands;
}
