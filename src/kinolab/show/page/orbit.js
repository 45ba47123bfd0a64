// A camera that the pointer turns about a target, moves, and brings nearer.

const LOWEST = 0.02; // [rad] off the vertical, where "up" would have no direction

/** Turn `camera` about `orbit.target` by drags on `element`; `changed` is called after each. */
export function orbitControl(camera, element, axes, changed) {
  const orbit = { target: new THREE.Vector3(), azimuth: 0, elevation: 0.6, distance: 10,
                  nearest: 1e-3, farthest: 1e6, moved: () => {} };
  const pointers = new Map();

  orbit.place = () => {
    camera.position.copy(orbit.target).addScaledVector(orbit.look(), orbit.distance);
    camera.up.copy(Math.abs(orbit.elevation) > Math.PI / 2 - 2 * LOWEST ? level(orbit.azimuth) : axes.up);
    camera.lookAt(orbit.target);
    camera.near = Math.max(orbit.distance - orbit.depth, orbit.distance / 200);
    camera.far = orbit.distance + orbit.depth;
    camera.updateProjectionMatrix();
  };
  orbit.depth = 100;

  /** The unit vector from the target to the viewer. */
  orbit.look = () => level(orbit.azimuth).multiplyScalar(-Math.cos(orbit.elevation))
    .addScaledVector(axes.up, Math.sin(orbit.elevation));

  /** Into the picture, along the ground. */
  const level = (azimuth) => new THREE.Vector3()
    .addScaledVector(axes.toward, -Math.cos(azimuth)).addScaledVector(axes.across, -Math.sin(azimuth));

  const turn = (dx, dy) => {
    orbit.azimuth -= (dx / element.clientHeight) * Math.PI;
    const most = Math.PI / 2 - LOWEST / 2;
    orbit.elevation = Math.min(Math.max(orbit.elevation + (dy / element.clientHeight) * Math.PI, -most), most);
  };
  const move = (dx, dy) => {
    const scale = (2 * orbit.distance * Math.tan((camera.fov * Math.PI) / 360)) / element.clientHeight;
    const right = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 0);
    const above = new THREE.Vector3().setFromMatrixColumn(camera.matrix, 1);
    orbit.target.addScaledVector(right, -dx * scale).addScaledVector(above, dy * scale);
    orbit.moved();
  };
  const approach = (factor) => {
    orbit.distance = Math.min(Math.max(orbit.distance * factor, orbit.nearest), orbit.farthest);
  };
  const then = () => { orbit.place(); changed(); };

  element.addEventListener("pointerdown", (event) => {
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  });
  element.addEventListener("pointermove", (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before.x, dy = event.clientY - before.y;
    if (pointers.size === 2) {
      const [other] = [...pointers].filter(([id]) => id !== event.pointerId).map(([, p]) => p);
      const apart = (p) => Math.hypot(p.x - other.x, p.y - other.y);
      approach(apart(before) / Math.max(apart({ x: event.clientX, y: event.clientY }), 1));
      move(dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) move(dx, dy);
    else turn(dx, dy);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    then();
  });
  for (const end of ["pointerup", "pointercancel"])
    element.addEventListener(end, (event) => pointers.delete(event.pointerId));
  element.addEventListener("wheel", (event) => {
    event.preventDefault();
    approach(Math.exp(event.deltaY * (event.deltaMode ? 0.04 : 0.0012)));
    then();
  }, { passive: false });
  element.addEventListener("contextmenu", (event) => event.preventDefault());
  return orbit;
}
