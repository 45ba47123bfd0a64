// Whether two convex things overlap, from where they reach farthest in a direction.

const ROUNDS = 24; // of the search; what is undecided then hardly touches

/**
 * Whether two convex sets overlap; each is given by a function from a direction to its farthest point.
 *
 * Source: Gilbert, Johnson, Keerthi, A fast procedure for computing the distance between complex objects
 * in three-dimensional space, IEEE J. Robotics and Automation 4(2), 1988.
 */
export function overlap(first, second) {
  const reach = (d) => minus(first(d), second(times(-1, d)));
  let corners = [reach([1, 0, 0])], d = times(-1, corners[0]);
  for (let round = 0; round < ROUNDS; round++) {
    if (dot(d, d) < 1e-24) return true; // the origin is on the simplex
    const corner = reach(d);
    if (dot(corner, d) < 0) return false; // a plane is between them
    corners.unshift(corner);
    const next = { 2: ofLine, 3: ofTriangle, 4: ofTetrahedron }[corners.length](corners);
    if (next === null) return true;
    [corners, d] = next;
  }
  return false;
}

/** The part of a simplex next to the origin, its newest corner first, and the way to the origin; null inside. */
function ofLine([a, b]) {
  const ab = minus(b, a), ao = times(-1, a);
  return dot(ab, ao) > 0 ? [[a, b], cross(cross(ab, ao), ab)] : [[a], ao];
}

function ofTriangle([a, b, c]) {
  const ab = minus(b, a), ac = minus(c, a), ao = times(-1, a), normal = cross(ab, ac);
  if (dot(cross(normal, ac), ao) > 0) return dot(ac, ao) > 0 ? [[a, c], cross(cross(ac, ao), ac)] : ofLine([a, b]);
  if (dot(cross(ab, normal), ao) > 0) return ofLine([a, b]);
  return dot(normal, ao) > 0 ? [[a, b, c], normal] : [[a, c, b], times(-1, normal)];
}

function ofTetrahedron([a, b, c, d]) {
  const ao = times(-1, a);
  for (const [p, q, r] of [[b, c, d], [c, d, b], [d, b, c]]) {
    let normal = cross(minus(p, a), minus(q, a));
    if (dot(normal, minus(r, a)) > 0) normal = times(-1, normal); // it looks outward
    if (dot(normal, ao) > 0) return ofTriangle([a, p, q]);
  }
  return null;
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (s, a) => [s * a[0], s * a[1], s * a[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
