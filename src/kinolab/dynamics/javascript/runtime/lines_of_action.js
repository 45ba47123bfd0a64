// Where forces of constraints act.

const POSE = 12; // numbers per body: the rows of [R | p]
const PREFERENCE = 100; // m; for wrenches of little force, as in constraint_forces.py
const RIGHT = 1e-6; // cosine of what counts as a right angle
const TRIFLE = 1e-9, REFINEMENTS = 4; // of the search for a wrench

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
