// Steps of several methods. Each makes advance(x, u, p, h, out), which writes the state after one
// substep, not yet moved back onto constraints and unit quaternions, and returns a status.

const SMALL_TURN = 1e-8; // rad^2 of half a turn, squared: sin(a)/a is 1 - a^2/6 to rounding
const GAMMA = 1 - Math.SQRT1_2; // makes the Rosenbrock method L-stable

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
