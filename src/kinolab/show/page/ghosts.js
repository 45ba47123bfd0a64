// Start and goal: the machine as a translucent outline, or the region where it shall arrive.

import { cableOf } from "./machine.js";
import { geometryOf } from "./meshes.js";

/** Return a group with the machine in one colour at given poses. */
function ghost({ poses, cables, rgb }, bodies) {
  const group = new THREE.Group(), paint = veil(rgb, 0.38, 2);
  const line = new THREE.LineBasicMaterial({ color: paint.color, transparent: true, opacity: 0.9, depthWrite: false });
  poses.forEach((p, k) => {
    const frame = new THREE.Group();
    frame.matrixAutoUpdate = false;
    frame.matrix.set(...p.slice(0, 12), 0, 0, 0, 1);
    frame.add(new THREE.Mesh(bodies[k].geometry, paint));
    frame.add(new THREE.LineSegments(bodies[k].spinning.children[1].geometry, line));
    group.add(frame);
  });
  cables.forEach(({ ends, radius }) => {
    const seen = { color: paint.color, transparent: true, opacity: 0.5, depthWrite: false };
    for (const width of [{ linewidth: 2 * radius, worldUnits: true }, {}]) {
      const cable = cableOf({ ...seen, ...width });
      cable.geometry.setPositions(ends);
      group.add(cable);
    }
  });
  return group;
}

/** Return the ball that a point must enter. */
function ball({ position, radius, rgb }) {
  const mesh = new THREE.Mesh(new THREE.SphereGeometry(radius, 48, 32), veil(rgb, 0.35));
  mesh.position.set(...position);
  return mesh;
}

/** Return a ring on the floor, or a ball where there is none. */
function region({ position, radius, rgb }, floor) {
  const group = new THREE.Group();
  if (floor) {
    group.add(new THREE.Mesh(new THREE.CircleGeometry(radius, 64), veil(rgb, 0.28)));
    group.add(new THREE.Mesh(new THREE.RingGeometry(0.9 * radius, radius, 64), veil(rgb, 0.95)));
    group.position.set(position[0], position[1], 2e-3 * radius);
  } else {
    group.add(ball({ position, radius, rgb }));
  }
  return group;
}

/** A translucent paint; `behind` lets what stands in the same place win, a floor loses. */
function veil(rgb, opacity, behind = -1) {
  const color = new THREE.Color().setRGB(...rgb, "srgb");
  return new THREE.MeshBasicMaterial({ color, transparent: true, opacity, depthWrite: false,
    forceSinglePass: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: behind, polygonOffsetUnits: 4 * behind });
}

/** Build what marks start and goal; each is null where there is nothing to mark. */
export function buildGhosts(data, bodies) {
  const start = data.start && ghost(data.start, bodies);
  const goal = data.goal && (data.goal.poses ? ghost(data.goal, bodies) : region(data.goal, data.floor));
  return { start, goal: data.points.length ? new THREE.Group().add(...data.points.map(ball)) : goal };
}

/** Build the cones that axes shall or must not have. */
export function buildCones(data, array) {
  const group = new THREE.Group();
  for (const { mesh } of data.cones) {
    const surface = new THREE.Mesh(geometryOf(mesh, array), mesh.colors.map(({ rgb }) => veil(rgb, 0.28)));
    group.add(surface);
  }
  return data.cones.length ? group : null;
}
