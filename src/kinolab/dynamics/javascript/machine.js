// Integrators and views around the functions of one machine, as kinolab's compiled model has them.
// States, inputs and parameters are arrays of float64; lengths are in m, angles in rad, times in s.

const SINGULAR = 1, NOT_FINITE = 2; // bits of a status; 0 is success
const SMALL_TURN = 1e-8; // rad^2 of half a turn, squared: sin(a)/a is 1 - a^2/6 to rounding
const GAMMA = 1 - Math.SQRT1_2; // makes the Rosenbrock method L-stable
const PREFERENCE = 100; // m; for wrenches of little force, as in holding.py
const RIGHT = 1e-6; // cosine of what counts as a right angle
const TRIFLE = 1e-9, REFINEMENTS = 4; // of the search for a wrench
const POSE = 12; // numbers per body: the rows of [R | p]

class SingularError extends Error {}

// The larger of two; of a number and NaN the number.
function fmax(a, b) {
  return a > b || b !== b ? a : b;
}

function sign(value) {
  return (value > 0) - (value < 0);
}

function finite(values, size) {
  let total = 0;
  for (let i = 0; i < size; i++) total += values[i] * 0;
  return total === 0 ? 0 : NOT_FINITE;
}

// Factors the n by n matrix A in place by elimination with row pivoting.
// Source: Golub, Van Loan, Matrix Computations, 4th ed., algorithm 3.4.1.
function luFactor(A, pivots, n) {
  let status = 0;
  for (let k = 0; k < n; k++) {
    let row = k;
    for (let i = k + 1; i < n; i++) {
      if (Math.abs(A[i * n + k]) > Math.abs(A[row * n + k])) row = i;
    }
    pivots[k] = row;
    if (!(Math.abs(A[row * n + k]) > 1e-300)) status = SINGULAR;
    for (let j = 0; j < n; j++) {
      const kept = A[k * n + j];
      A[k * n + j] = A[row * n + j];
      A[row * n + j] = kept;
    }
    for (let i = k + 1; i < n; i++) {
      const factor = A[i * n + k] / A[k * n + k];
      A[i * n + k] = factor;
      for (let j = k + 1; j < n; j++) A[i * n + j] -= factor * A[k * n + j];
    }
  }
  return status;
}

// Solves in place with the factors of luFactor.
function luSolve(A, pivots, n, b) {
  for (let k = 0; k < n; k++) {
    const kept = b[k];
    b[k] = b[pivots[k]];
    b[pivots[k]] = kept;
  }
  for (let k = 0; k < n; k++) {
    for (let i = k + 1; i < n; i++) b[i] -= A[i * n + k] * b[k];
  }
  for (let k = n - 1; k >= 0; k--) {
    b[k] /= A[k * n + k];
    for (let i = 0; i < k; i++) b[i] -= A[i * n + k] * b[k];
  }
}

// Steps of several methods. Each returns advance(x, u, p, h, out), which makes one substep without
// moving the state back onto the constraints and returns a status.

// Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.1.
function rungeKutta(facts, { f }) {
  const n = facts.stateNames.length;
  const at = new Float64Array(n), k = new Float64Array(n);
  const fractions = [0, 0.5, 0.5, 1], weights = [1 / 6, 1 / 3, 1 / 3, 1 / 6];
  return (x, u, p, h, out) => {
    let status = 0;
    out.set(x);
    for (let stage = 0; stage < 4; stage++) {
      for (let i = 0; i < n; i++) at[i] = stage ? x[i] + h * fractions[stage] * k[i] : x[i];
      status |= f(at, u, p, k);
      for (let i = 0; i < n; i++) out[i] += h * weights[stage] * k[i];
    }
    return status;
  };
}

// The explicit Euler step, along geodesics where the state is an attitude.
// Source: Iserles, Munthe-Kaas, Norsett, Zanna, Lie-group methods, Acta Numerica 9, 2000, 2.4.
function euler(facts, { f }) {
  const n = facts.stateNames.length, k = new Float64Array(n);
  return (x, u, p, h, out) => {
    const status = f(x, u, p, k);
    for (let i = 0; i < n; i++) out[i] = x[i] + h * k[i];
    for (const first of facts.attitudes) turn(x, k, h, first, out);
    return status;
  };
}

// Moves the quaternion that begins at an index along the great circle of its derivative.
function turn(x, k, h, first, out) {
  let square = 0;
  for (let i = first; i < first + 4; i++) square += k[i] * k[i];
  square *= h * h;
  const angle = Math.sqrt(square);
  const ratio = square < SMALL_TURN ? 1 - square / 6 : Math.sin(angle) / angle;
  for (let i = first; i < first + 4; i++) out[i] = Math.cos(angle) * x[i] + h * ratio * k[i];
}

// The L-stable Rosenbrock method of order 2 with the exact Jacobian.
// Source: Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20(4), 1999, equation (3.1).
function rosenbrock(facts, { f, tangent }) {
  const n = facts.stateNames.length;
  const matrix = new Float64Array(n * n), pivots = new Int32Array(n);
  const [k1, k2, at, along, column] = Array.from({ length: 5 }, () => new Float64Array(n));
  const still = new Float64Array(facts.inputs.length);
  return (x, u, p, h, out) => {
    let status = 0;
    for (let j = 0; j < n; j++) {
      along[j] = 1;
      status |= tangent(x, u, p, along, still, column);
      along[j] = 0;
      for (let i = 0; i < n; i++) matrix[i * n + j] = (i === j) - GAMMA * h * column[i];
    }
    status |= luFactor(matrix, pivots, n) | f(x, u, p, k1);
    luSolve(matrix, pivots, n, k1);
    for (let i = 0; i < n; i++) at[i] = x[i] + h * k1[i];
    status |= f(at, u, p, k2);
    for (let i = 0; i < n; i++) k2[i] -= 2 * k1[i];
    luSolve(matrix, pivots, n, k2);
    for (let i = 0; i < n; i++) out[i] = x[i] + h * (1.5 * k1[i] + 0.5 * k2[i]);
    return status;
  };
}

// Where a constraint's force of one unit acts: the wrench z on a body with J^T z = w, w being the
// constraint's covector and J the body's six rows, as the force and the arm from the body's origin
// to the force's line of action, and the torque that is left. Of several the one with least force
// is taken. Regularised, and refined until the regularisation has left the result.
function lineOfAction(J, first, w, row, n) {
  const A = (i, k) => J[first + i * n + k] * (i < 3 ? 1 : PREFERENCE);
  const G = new Float64Array(36), z = new Float64Array(6), pivots = new Int32Array(6);
  let trace = 0;
  for (let i = 0; i < 6; i++) {
    for (let j = 0; j < 6; j++) {
      for (let k = 0; k < n; k++) G[i * 6 + j] += A(i, k) * A(j, k);
    }
    trace += G[i * 6 + i];
  }
  for (let i = 0; i < 6; i++) G[i * 6 + i] += TRIFLE * trace;
  luFactor(G, pivots, 6);
  for (let pass = 0; pass < REFINEMENTS; pass++) {
    const change = new Float64Array(6);
    for (let k = 0; k < n; k++) {
      let left = w[row * n + k];
      for (let i = 0; i < 6; i++) left -= A(i, k) * z[i];
      for (let i = 0; i < 6; i++) change[i] += A(i, k) * left;
    }
    luSolve(G, pivots, 6, change);
    for (let i = 0; i < 6; i++) z[i] += change[i];
  }
  for (let i = 3; i < 6; i++) z[i] *= PREFERENCE;
  const force = Array.from(z.subarray(0, 3)), torque = Array.from(z.subarray(3));
  const square = dot(force, force);
  if (!(square > TRIFLE * dot(torque, torque))) return { force: [0, 0, 0], torque, arm: [0, 0, 0] };
  const along = dot(force, torque) / square;
  return {
    force,
    torque: force.map((component) => along * component),
    arm: cross(force, torque).map((component) => component / square),
  };
}

// The point of a line of action nearest to one at right angles to it on the same body, for a wheel
// feels what keeps it from rolling on and from slipping aside at one point.
function contact(line, lines) {
  const square = dot(line.force, line.force);
  for (const other of lines) {
    if (other === null || other === line || other.body !== line.body || !square) continue;
    const cosine = dot(line.force, other.force) / Math.sqrt(square * dot(other.force, other.force));
    if (!(Math.abs(cosine) < RIGHT)) continue;
    const way = dot(other.at.map((part, i) => part - line.at[i]), line.force) / square;
    return line.at.map((part, i) => part + way * line.force[i]);
  }
  return line.at;
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

// The machine: what ``kinolab.Model`` offers, under the same names in camelCase. Where a machine has
// feedback the inputs u are references, held over a step together with what the law makes of them.
function assemble(facts, functions) {
  const methods = { rk4: rungeKutta, euler, ...(functions.tangent && { rosenbrock }) };
  const advancing = {};
  for (const name in methods) advancing[name] = methods[name](facts, functions);
  const n = facts.stateNames.length;
  const defaults = Float64Array.from(facts.parameters, (parameter) => parameter.value);
  const bodies = facts.bodies.length;

  function called(name, size, given, required = true) {
    const out = new Float64Array(size);
    const status = functions[name] ? functions[name](...given, out) : 0;
    if (status && required) throw new SingularError(why(status));
    return out;
  }

  function why(status) {
    return status & SINGULAR
      ? "a velocity or mass is undetermined here"
      : "the result is not finite";
  }

  // The state after a step with the inputs held.
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

  // The forces of constraints in the world: [{ name, value, at, force, torque }]; at is null where
  // no single body is held, and value is the multiplier.
  function arrows(x, u, p) {
    if (!facts.constraints.length) return [];
    const values = called("constraint_forces", facts.sizes.constraint_forces, [x, u, p], false);
    const width = functions.covectors.width, poses = called("frames", POSE * bodies, [x, p], false);
    const w = called("covectors", facts.constraints.length * width, [x, p], false);
    const twists = called("twists", functions.twists.count * 6 * width, [x, p], false);
    const lines = facts.constraints.map(({ body, twist, onGround }, row) => {
      if (body === null) return null;
      const line = lineOfAction(twists, twist * 6 * width, w, row, width);
      const at = line.arm.map((component, i) => poses[POSE * body + 4 * i + 3] + component);
      if (onGround) at[2] = 0;
      return { ...line, at, body };
    });
    return facts.constraints.map(({ name }, row) => {
      const value = values[row], line = lines[row];
      if (line === null) return { name, value, at: null, force: null, torque: null };
      const [force, torque] = [line.force, line.torque].map((v) => v.map((part) => value * part));
      return { name, value, at: contact(line, lines), force, torque };
    });
  }

  // Sizes and places of all shapes: per body [{ kind, axis, size: {…}, at }].
  function shapes(p = defaults) {
    const last = facts.shapes.flat().reduce((n, s) => n + s.dimensions.length + 3, 0);
    const values = called("shapes", last, [p], false);
    return facts.shapes.map((list) =>
      list.map(({ kind, axis, dimensions, first }) => ({
        kind,
        axis,
        size: Object.fromEntries(dimensions.map((name, i) => [name, values[first + i]])),
        at: Array.from(values.subarray(first + dimensions.length, first + dimensions.length + 3)),
      })),
    );
  }

  if (functions.covectors) {
    functions.covectors.width = facts.sizes.velocities;
    functions.twists.count = new Set(
      facts.constraints.map(({ twist }) => twist).filter((twist) => twist !== null),
    ).size;
  }

  // acting: (x, u, p) => the plant's inputs.
  function loop(inputs, acting) {
    return {
      ...facts,
      inputs,
      inputNames: inputs.map((input) => input.name),
      acting,
      f: (x, u, p = defaults) => called("f", n, [x, acting(x, u, p), p]),
      step: (x, u, dt, p = defaults, method = "rk4", substeps = 1) =>
        advanced(x, acting(x, u, p), dt, p, method, substeps),
      frames: (x, p = defaults) => called("frames", POSE * bodies, [x, p], false),
      cableEnds: (x, p = defaults) => called("cables", facts.sizes.cables, [x, p], false),
      hasEnergy: facts.sizes.energy > 0,
      energy: (x, u, p = defaults) => {
        if (!facts.sizes.energy) return null;
        const [kinetic, potential] = called("energy", 2, [x, acting(x, u, p), p]);
        return { kinetic, potential };
      },
      constraintForces: (x, u, p = defaults) =>
        called("constraint_forces", facts.sizes.constraint_forces, [x, acting(x, u, p), p]),
      constraintResidual: (x, u, p = defaults) =>
        called("constraint_residual", facts.sizes.constraint_residual, [x, acting(x, u, p), p]),
      margins: (x, u, p = defaults) =>
        called("requirements", facts.sizes.requirements, [x, acting(x, u, p), p], false),
      arrows: (x, u, p = defaults) => arrows(x, acting(x, u, p), p),
      shapes,
      defaults,
    };
  }

  const plant = loop(facts.inputs, (x, u) => u);
  plant.plant = plant;
  if (!functions.law) return plant;
  const law = (x, u, p) => called("law", facts.inputs.length, [x, u, p], false);
  return { ...loop(facts.references, law), plant };
}
