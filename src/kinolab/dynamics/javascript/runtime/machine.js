// The machine: what kinolab.Model offers, under the same names in camelCase.
//
// States, inputs and parameters are arrays of float64 in SI units. Where a machine has feedback, the
// inputs u are references; a step holds them together with what the law makes of them, and ``plant``
// is the machine without its feedback.

function assemble(facts, functions) {
  const advancing = {};
  for (const [name, method] of Object.entries(facts.methods)) {
    if (functions.tangent || !method.gamma) advancing[name] = stepOf(method, facts, functions);
  }
  const n = facts.stateNames.length;
  const defaults = Float64Array.from(facts.parameters, ({ value }) => value);

  // The result of an emitted function, nothing where the machine has no such result.
  function called(name, given, required = true) {
    const out = new Float64Array(facts.sizes[name] ?? 0);
    const status = functions[name]?.(...given, out);
    if (status && required) throw new SingularError(why(status));
    return out;
  }

  // The state after a step with the plant's inputs held.
  function advanced(x, u, dt, p, method, substeps) {
    if (!(method in advancing)) throw new RangeError(`no integration method is called ${method}`);
    let at = Float64Array.from(x), next = new Float64Array(n), status = 0;
    for (let k = 0; k < substeps; k++) {
      status |= advancing[method](at, u, p, dt / substeps, next);
      if (functions.project) {
        status |= functions.project(next, p, at) | functions.project(at, p, next);
      }
      [at, next] = [next, at];
    }
    if (status) throw new SingularError(why(status));
    return at;
  }

  // A machine that is decided by some inputs; acting(x, u, p) gives the plant's.
  function loop(inputs, acting) {
    const under = (name, x, u, p, required) => called(name, [x, acting(x, u, p), p], required);
    return {
      ...facts,
      inputs,
      inputNames: inputs.map(({ name }) => name),
      defaults,
      acting: (x, u, p = defaults) => acting(x, u, p),
      f: (x, u, p = defaults) => under("f", x, u, p),
      step: (x, u, dt, p = defaults, method = "rk4", substeps = 1) =>
        advanced(x, acting(x, u, p), dt, p, method, substeps),
      frames: (x, p = defaults) => called("frames", [x, p], false),
      cableEnds: (x, p = defaults) => called("cables", [x, p], false),
      jointFrames: (x, p = defaults) => called("joint_frames", [x, p], false),
      gaps: (x, p = defaults) => called("gaps", [x, p], false),
      slipRows: (x, p = defaults) => called("slip_rows", [x, p], false),
      hasEnergy: "energy" in functions,
      energy: (x, u, p = defaults) => {
        const [kinetic, potential] = under("energy", x, u, p);
        return { kinetic, potential };
      },
      constraintForces: (x, u, p = defaults) => under("constraint_forces", x, u, p),
      constraintResidual: (x, u, p = defaults) => under("constraint_residual", x, u, p),
      margins: (x, u, p = defaults) => under("requirements", x, u, p, false),
      switches: (name, x, u, p = defaults) => under(name, x, u, p), // of a machine with modes
      arrows: (x, u, p = defaults) => arrowsOf(facts, called, x, acting(x, u, p), p),
      shapes: (p = defaults) => shapesOf(facts, called, p),
    };
  }

  const plant = loop(facts.inputs, (x, u) => u);
  plant.plant = plant;
  if (!functions.law) return plant;
  return { ...loop(facts.references, (x, u, p) => called("law", [x, u, p], false)), plant };
}

function why(status) {
  return status & SINGULAR ? "a velocity or mass is undetermined here" : "the result is not finite";
}
