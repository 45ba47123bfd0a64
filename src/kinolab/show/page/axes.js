// Which way is up, across and toward the viewer: the same choice as the GIF's camera makes.

/** Return unit vectors {up, across, toward} for a front view; up = z gives z, x and -y. */
export function axesOf(up) {
  const upward = new THREE.Vector3(...up).normalize();
  const sizes = up.map(Math.abs);
  const across = sizes[0] >= sizes[1] && sizes[0] >= sizes[2]
    ? new THREE.Vector3(0, 1, 0) : new THREE.Vector3(1, 0, 0);
  across.addScaledVector(upward, -across.dot(upward)).normalize();
  return { up: upward, across, toward: new THREE.Vector3().crossVectors(across, upward) };
}
