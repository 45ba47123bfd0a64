// Places and turns of bodies between two steps, for pictures that come in between.

const POSE = 12; // numbers per body: the rows of [R | p]

/** Return {place, turn} of a body at a share of the way from one list of poses to another. */
export function poseBetween(before, after, body, share) {
  const first = POSE * body, place = [3, 7, 11].map((k) => mix(before[first + k], after[first + k], share));
  return { place, turn: turnBetween(quaternionOf(before, first), quaternionOf(after, first), share) };
}

/** Return numbers at a share of the way from one list to another. */
export function between(before, after, share) {
  return Array.from(after, (value, k) => mix(before[k], value, share));
}

function mix(a, b, share) {
  return a + share * (b - a);
}

/** The nearer of two quaternions of one turn, on the straight way and made unit again. */
function turnBetween(a, b, share) {
  const sign = a.reduce((sum, value, k) => sum + value * b[k], 0) < 0 ? -1 : 1;
  const q = a.map((value, k) => mix(value, sign * b[k], share)), norm = Math.hypot(...q);
  return q.map((value) => value / norm);
}

/**
 * The unit quaternion x, y, z, w of a rotation matrix.
 *
 * Source: Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1(3), 1978.
 */
export function quaternionOf(poses, first) {
  const R = (i, j) => poses[first + 4 * i + j];
  const trace = R(0, 0) + R(1, 1) + R(2, 2), diagonal = [R(0, 0), R(1, 1), R(2, 2), trace];
  const largest = diagonal.indexOf(Math.max(...diagonal)), q = [0, 0, 0, 0];
  if (largest === 3) {
    q[3] = 1 + trace;
    for (let i = 0; i < 3; i++) q[i] = R((i + 2) % 3, (i + 1) % 3) - R((i + 1) % 3, (i + 2) % 3);
  } else {
    const i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
    q[i] = 1 - trace + 2 * R(i, i);
    q[j] = R(j, i) + R(i, j);
    q[k] = R(k, i) + R(i, k);
    q[3] = R(k, j) - R(j, k);
  }
  const norm = Math.hypot(...q);
  return q.map((value) => value / norm);
}
