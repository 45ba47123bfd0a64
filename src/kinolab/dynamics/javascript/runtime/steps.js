// A step of a method of integration, from its coefficients (dynamics/codegen/methods.py).

const SMALL_TURN = 1e-8; // rad^2 of half a turn, squared: sin(a)/a is 1 - a^2/6 to rounding

// Returns advance(x, u, p, h, out), which writes the state after one substep, not yet moved back onto
// constraints and unit spheres, and returns a status.
function stepOf({ a, b, c, gamma, geodesic }, facts, { f, tangent }) {
  const n = facts.stateNames.length;
  const k = b.map(() => new Float64Array(n)), at = new Float64Array(n);
  const [along, column] = [new Float64Array(n), new Float64Array(n)];
  const matrix = new Float64Array(gamma ? n * n : 0), pivots = new Int32Array(n);
  const still = new Float64Array(facts.inputs.length);

  // Factors 1 - gamma h J.
  function factor(x, u, p, h) {
    let status = 0;
    for (let j = 0; j < n; j++) {
      along[j] = 1;
      status |= tangent(x, u, p, along, still, column);
      along[j] = 0;
      for (let i = 0; i < n; i++) matrix[i * n + j] = (i === j) - gamma * h * column[i];
    }
    return status | luFactor(matrix, pivots, n);
  }

  return (x, u, p, h, out) => {
    let status = gamma ? factor(x, u, p, h) : 0;
    out.set(x);
    for (let stage = 0; stage < b.length; stage++) {
      const own = k[stage];
      at.set(x);
      a[stage].forEach((weight, j) => addTo(at, h * weight, k[j]));
      status |= f(at, u, p, own);
      c[stage]?.forEach((weight, j) => addTo(own, weight, k[j]));
      if (gamma) luSolve(matrix, pivots, n, own);
      addTo(out, h * b[stage], own);
    }
    if (geodesic) for (const [first, size] of facts.spheres) turn(x, k[0], h, first, first + size, out);
    return status;
  };
}

function addTo(sum, factor, values) {
  if (factor) for (let i = 0; i < sum.length; i++) sum[i] += factor * values[i];
}

// Moves a unit vector, from one index to another, along the great circle of its derivative.
function turn(x, k, h, first, end, out) {
  let square = 0;
  for (let i = first; i < end; i++) square += k[i] * k[i];
  square *= h * h;
  const angle = Math.sqrt(square);
  const ratio = square < SMALL_TURN ? 1 - square / 6 : Math.sin(angle) / angle;
  for (let i = first; i < end; i++) out[i] = Math.cos(angle) * x[i] + h * ratio * k[i];
}
