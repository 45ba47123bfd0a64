// From how far away a camera sees every point.

/**
 * Return the target and the distance at which all points are within the picture.
 *
 * @param points of the world, as Vector3.
 * @param look unit vector from the scene to the viewer.
 * @param up unit vector that points upward, not along `look`.
 * @param fov vertical angle of view in [rad].
 * @param aspect width of the picture over its height.
 * @param margin share of the picture that stays empty on every side.
 */
export function framed(points, look, up, fov, aspect, margin = 0.05) {
  const right = new THREE.Vector3().crossVectors(up, look).normalize();
  const above = new THREE.Vector3().crossVectors(look, right);
  const slope = (1 - 2 * margin) * Math.tan(fov / 2);
  const seen = points.map((p) => [p.dot(right), p.dot(above), -p.dot(look)]);
  const [x, depthX] = pinhole(seen, 0, slope * aspect), [y, depthY] = pinhole(seen, 1, slope);
  const near = Math.min(...seen.map((p) => p[2])), far = Math.max(...seen.map((p) => p[2]));
  const depth = Math.min(depthX, depthY, near - 0.02 * Math.max(far - near, 1e-3));
  const middle = (near + far) / 2;
  const target = new THREE.Vector3().addScaledVector(right, x).addScaledVector(above, y)
    .addScaledVector(look, -middle);
  return { target, distance: middle - depth };
}

/** Along one axis of the picture: where the pinhole is, and at most how deep. */
function pinhole(seen, axis, slope) {
  const right = Math.max(...seen.map((p) => p[axis] - slope * p[2]));
  const left = Math.max(...seen.map((p) => -p[axis] - slope * p[2]));
  return [(right - left) / 2, -(right + left) / (2 * slope)];
}

/** Return points as vectors, from three numbers each. */
export function vectorsOf(numbers) {
  return [...Array(numbers.length / 3).keys()].map((k) => new THREE.Vector3().fromArray(numbers, 3 * k));
}

/** Return half the diagonal of the box around points, at least a millimetre. */
export function radiusOf(points) {
  const low = new THREE.Vector3(Infinity, Infinity, Infinity), high = low.clone().negate();
  for (const point of points) { low.min(point); high.max(point); }
  return Math.max(high.distanceTo(low) / 2, 1e-3);
}
