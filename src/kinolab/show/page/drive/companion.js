// The plan's machine as a translucent companion of the one that is driven.

/** Copy the bodies as a ghost; `show(t)` puts it where the plan is at a time. */
export function buildCompanion(bodies, motion) {
  const group = new THREE.Group();
  group.visible = false;
  const veil = new THREE.MeshBasicMaterial({ color: 0x3a6ea5, transparent: true, opacity: 0.3, depthWrite: false,
    side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
  const ink = new THREE.LineBasicMaterial({ color: 0x3a6ea5, transparent: true, opacity: 0.6 });
  const frames = bodies.map(({ geometry, spinning }) => {
    const frame = new THREE.Group();
    frame.add(new THREE.Mesh(geometry, veil), new THREE.LineSegments(spinning.children[1].geometry, ink));
    group.add(frame);
    return frame;
  });
  const show = (t) => frames.forEach((frame, k) => {
    frame.position.set(...motion.place(k, t));
    frame.quaternion.set(...motion.turn(k, t));
  });
  const paint = (colors) => [veil, ink].forEach((material) => material.color.set(colors.path));
  return { group, show, paint };
}
