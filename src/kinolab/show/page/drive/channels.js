// What a pair of keys pushes: one input, or the two of a pair of wheels together.

const KEYS = [["ArrowUp", "ArrowDown"], ["ArrowRight", "ArrowLeft"], ["w", "s"], ["d", "a"],
              ["t", "g"], ["u", "j"], ["i", "k"], ["o", "l"]];
const SIGNS = { ArrowUp: "↑", ArrowDown: "↓", ArrowLeft: "←", ArrowRight: "→" };
const LATERAL = /steer|turn|yaw|lean|roll|rudder|psi|lateral|side/i; // inputs for keys to left and right
const SWEEP = 4; // [s] in which a held key moves a set point from one limit to the other

/**
 * Return a channel per pair of keys: {keys, shown, label, unit, weights, sticky}.
 *
 * `weights` says how a push of 1 moves each input, from where it idles toward its limits. A machine
 * turns to the left where an angle about the vertical grows, so keys to the left push there.
 */
export function channelsOf(inputs, closed) {
  const wheels = pairOfWheels(inputs);
  const unit = (k) => inputs.map((_, i) => (i === k ? 1 : 0));
  const plain = inputs.map((input, k) => ({
    label: input.name, unit: input.unit, weights: unit(k), lateral: LATERAL.test(input.name),
  }));
  const found = wheels ? bothWheels(inputs, wheels) : inOrder(plain);
  return found.slice(0, KEYS.length).map((channel, k) => {
    const pair = found.length === 1 && !channel.lateral ? KEYS[1] : KEYS[k];
    const keys = channel.lateral && k === 1 ? [...pair].reverse() : pair;
    return { ...channel, keys, shown: keys.map((key) => SIGNS[key] ?? key.toUpperCase()),
             sticky: closed && k === 0 && !channel.lateral };
  });
}

/** Put what drives before what steers where the first two are the other way round. */
function inOrder(channels) {
  const [first, second, ...others] = channels;
  return second && first.lateral && !second.lateral ? [second, first, ...others] : channels;
}

/** The indices of a left and a right input, where a machine has just these two. */
function pairOfWheels(inputs) {
  const find = (word) => inputs.findIndex(({ name }) => name.toLowerCase().includes(word));
  const left = find("left"), right = find("right");
  return inputs.length === 2 && left >= 0 && right >= 0 && left !== right ? { left, right } : null;
}

function bothWheels(inputs, { left, right }) {
  const weights = (first, second) => inputs.map((_, k) => (k === left ? first : k === right ? second : 0));
  const { unit } = inputs[left], [one, other] = [inputs[left].name, inputs[right].name];
  return [
    { label: `${one} + ${other}`, unit, weights: weights(1, 1), lateral: false },
    { label: `${other} − ${one}`, unit, weights: weights(-1, 1), lateral: true },
  ];
}

/**
 * Inputs from pushes in [-1, 1], one per channel: idle inputs moved toward their limits.
 *
 * `usual` is the share of its way that an input goes where keys push half as hard as they can. A
 * sticky channel is a set point that keys move and that stays; `dt` is the step in s.
 */
export function buildInputs(inputs, channels, { idle, usual }, dt) {
  const kept = channels.map(() => 0);
  /** The inputs of the next step; a strength of 1 reaches their limits. */
  const at = (pushes, strength) => {
    const total = inputs.map(() => 0), most = usual.map((share) => share ** (2 - 2 * strength));
    channels.forEach((channel, c) => {
      if (channel.sticky) kept[c] = clamp(kept[c] + (2 * dt * pushes[c]) / SWEEP, -1, 1);
      channel.weights.forEach((weight, i) => { total[i] += weight * (channel.sticky ? kept[c] : most[i] * pushes[c]); });
    });
    return inputs.map(({ lower, upper }, i) => {
      const share = clamp(total[i], -1, 1), toward = share < 0 ? lower : upper;
      return clamp(idle[i] + Math.abs(share) * (toward - idle[i]), lower, upper);
    });
  };
  return { at, reset: () => kept.fill(0) };
}

function clamp(value, lower, upper) {
  return Math.min(Math.max(value, lower), upper);
}
