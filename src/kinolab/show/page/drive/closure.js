// Poses that keep constraints on positions: unit vectors stay unit, loops stay closed.

const STEPS = 30; // of Newton's method
const CLOSED = 1e-11; // [m] or [rad] of a gap
const NUDGE = 1e-6; // of finite differences
const TRIFLE = 1e-12; // of the trace: loops that say the same leave it singular

/** Return a state with one entry of the configuration changed; those of a unit vector stay on it. */
export function normalised(machine, x, entry, value) {
  const found = Float64Array.from(x);
  found[entry] = value;
  for (const [first, size] of machine.spheres) {
    if (entry < first || entry >= first + size) continue;
    found[entry] = Math.min(Math.max(value, -1), 1);
    const others = [...Array(size).keys()].map((k) => first + k).filter((k) => k !== entry);
    const left = Math.sqrt(1 - found[entry] ** 2), norm = Math.hypot(...others.map((k) => found[k]));
    others.forEach((k) => { found[k] *= norm ? left / norm : 0; });
    if (!norm) found[others.at(-1)] = left;
  }
  return found;
}

/**
 * Return the state whose loops are closed, with the least change of all entries of the configuration
 * but the one that is held, if any, by Newton's method; null where it finds none.
 */
export function closed(machine, x, size, held) {
  const found = Float64Array.from(x), free = [...Array(size).keys()].filter((k) => k !== held);
  for (let step = 0; step < STEPS; step++) {
    const gaps = machine.gaps(found);
    if (gaps.every((gap) => Math.abs(gap) < CLOSED)) return found;
    const rows = free.map((k) => slopeOf(machine, found, k)); // one per free entry
    const share = solved(rows, gaps);
    if (!share) return null;
    free.forEach((k, i) => { found[k] -= rows[i].reduce((sum, slope, j) => sum + slope * share[j], 0); });
  }
  return null;
}

function slopeOf(machine, x, entry) {
  const [ahead, behind] = [NUDGE, -NUDGE].map((nudge) => {
    const moved = Float64Array.from(x);
    moved[entry] += nudge;
    return machine.gaps(moved);
  });
  return Array.from(ahead, (value, k) => (value - behind[k]) / (2 * NUDGE));
}

/** Solve (J J^T) s = h by elimination, given the columns of J. */
function solved(columns, gaps) {
  const n = gaps.length, trace = columns.reduce((sum, c) => sum + c.reduce((s, v) => s + v * v, 0), 0);
  const A = [...Array(n).keys()].map((i) => [...Array(n).keys()].map((j) =>
    columns.reduce((sum, c) => sum + c[i] * c[j], 0) + (i === j ? TRIFLE * trace : 0)).concat(gaps[i]));
  for (let k = 0; k < n; k++) {
    const best = A.slice(k).reduce((top, row, i) => (Math.abs(row[k]) > Math.abs(A[top][k]) ? k + i : top), k);
    [A[k], A[best]] = [A[best], A[k]];
    if (!(Math.abs(A[k][k]) > 0)) return null;
    for (let i = 0; i < n; i++) {
      if (i === k) continue;
      const factor = A[i][k] / A[k][k];
      for (let j = k; j <= n; j++) A[i][j] -= factor * A[k][j];
    }
  }
  const share = A.map((row, k) => row[n] / row[k]);
  return share.every(Number.isFinite) ? share : null;
}
