// Machines with modes: one machine for each, and steps that end where a transition takes place.

const HALVINGS = 48, MOST_SWITCHES = 64; // as in codegen/hybrid.py
const OF_STATES = ["f", "frames", "cableEnds", "energy", "constraintForces", "constraintResidual",
                   "margins", "arrows"];

// The last entry of a state says in which mode it is.
function switching(modes) {
  const modeOf = (x) => modes[Math.trunc(x[x.length - 1])];
  const machine = { ...modes[0] };
  for (const name of OF_STATES) machine[name] = (x, ...rest) => modeOf(x)[name](x, ...rest);

  // The number of the transition that takes place at a state: its guard is not positive and falls.
  function leaving(x, u, p) {
    const values = modeOf(x).switches("guards", x, u, p);
    return modeOf(x).targets.findIndex((_, k) =>
      values[3 * k] <= 0 && values[3 * k + 1] < 0 && values[3 * k + 2] > 0);
  }

  function after(x, u, p) {
    const mode = modeOf(x), k = leaving(x, u, p);
    const changed = mode.switches(`reset${k}`, x, u, p);
    return modes[mode.targets[k]].switches("landed", changed, u, p);
  }

  machine.step = (x, u, dt, p = machine.defaults, method = "rk4", substeps = 1) => {
    const flow = (at, length) => modeOf(at).step(at, u, length, p, method, substeps);
    let begin = Float64Array.from(x), rest = dt;
    for (let switches = 0; switches < MOST_SWITCHES; switches++) {
      if (leaving(begin, u, p) >= 0) begin = after(begin, u, p);
      if (leaving(begin, u, p) >= 0) continue; // another one at the same instant
      const end = flow(begin, rest);
      if (leaving(end, u, p) < 0) return end;
      let low = 0, high = rest;
      for (let k = 0; k < HALVINGS; k++) {
        const middle = 0.5 * (low + high);
        if (leaving(flow(begin, middle), u, p) >= 0) high = middle;
        else low = middle;
      }
      begin = flow(begin, high);
      rest -= high;
    }
    throw new SingularError("transitions follow each other without end");
  };
  machine.plant = machine;
  return machine;
}
