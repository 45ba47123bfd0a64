// A machine that is stepped at a fixed rate, whatever the rate of pictures: the same inputs at the
// same steps lead to the same states.

/**
 * Simulate a machine with steps of `dt` seconds.
 *
 * `inputsAt(step)` gives the inputs that are held over the next step. `log` keeps them, with the
 * loop that was closed or open and the parameters, so that a motion can be made again elsewhere.
 */
export function buildSimulator(machine, { start, dt, method, substeps, inputsAt }) {
  const simulator = {
    loop: machine, dt, parameters: Float64Array.from(machine.defaults),
    begin: null, before: null, state: null, inputs: null, steps: 0, log: [], failure: null,
  };
  let owed = 0; // [s]

  simulator.reset = (state = start) => {
    simulator.begin = Float64Array.from(state);
    simulator.before = simulator.state = simulator.begin;
    Object.assign(simulator, { steps: 0, log: [], failure: null });
    simulator.inputs = null;
    owed = 0;
  };

  /** Make one step; where the equations have no solution the machine stays, and says why. */
  simulator.step = (inputs = inputsAt(simulator.steps)) => {
    if (simulator.failure) return false;
    const held = Array.from(inputs);
    try {
      const { loop, state, parameters } = simulator;
      const after = loop.step(state, held, dt, parameters, method, substeps);
      simulator.before = state;
      simulator.state = after;
    } catch (error) {
      simulator.failure = error.message;
      return false;
    }
    simulator.inputs = held;
    simulator.log.push({ inputs: held, closed: simulator.loop !== simulator.loop.plant,
                         parameters: simulator.parameters });
    simulator.steps += 1;
    return true;
  };

  /** Let seconds of motion pass: as many whole steps as fit, the rest is owed to the next call. */
  simulator.pass = (seconds) => {
    owed += seconds;
    while (owed >= dt) {
      owed -= dt;
      if (!simulator.step()) owed = 0;
    }
  };

  /** Change a parameter from the next step on; what was logged keeps its own values. */
  simulator.setParameter = (index, value) => {
    simulator.parameters = simulator.parameters.slice();
    simulator.parameters[index] = value;
    simulator.failure = null;
  };

  /** Open or close the loop of a machine with a controller. */
  simulator.close = (closed) => { simulator.loop = closed ? machine : machine.plant; };

  Object.defineProperties(simulator, {
    time: { get: () => simulator.steps * dt },
    share: { get: () => Math.min(owed / dt, 1) }, // of the way from the last but one state to the last
  });
  simulator.reset();
  return simulator;
}
