// The machine's bodies and cables, and where they are.

import { edgesOf, geometryOf } from "./meshes.js";

const HIDDEN = 0.28; // opacity of the machine behind a wall
const LOOKS = 60; // moments at which the machine's reach is measured

/** Build the machine; `show(t)` moves it, `middle(t)` and `reach` say where and how large it is. */
export function buildMachine(data, array, motion) {
  const group = new THREE.Group();
  const ink = new THREE.LineBasicMaterial({ transparent: true, opacity: 0.75 });
  const behind = new THREE.LineBasicMaterial({ depthFunc: THREE.GreaterDepth, depthWrite: false });
  const bodies = data.bodies.map((body) => buildBody(body, array, { ink, behind }));
  bodies.forEach(({ frame }) => group.add(frame));
  const cables = motion.ends(motion.first) && buildCables(group, data.radii);

  const put = (k, place, turn, t) => {
    const { frame, spinning, whirl } = bodies[k];
    frame.position.set(...place);
    frame.quaternion.set(...turn);
    spinning.rotation.z = whirl * t;
  };
  const pull = (ends) => cables.forEach((cable, k) => cable.geometry.setPositions(taut(ends, k)));
  const show = (t) => {
    bodies.forEach((_, k) => put(k, motion.place(k, t), motion.turn(k, t), t));
    if (cables) pull(motion.ends(t));
  };
  const middle = (t) => {
    const mean = new THREE.Vector3();
    for (let k = 0; k < motion.bodies; k++) mean.add(new THREE.Vector3(...motion.place(k, t)));
    return mean.divideScalar(Math.max(motion.bodies, 1));
  };
  const paint = (colors) => {
    ink.color.set(colors.ink === 0xdfe5ee ? 0x0c0f14 : colors.ink);
    behind.color.set(colors.wallEdge);
    if (cables) cables.forEach(({ material }) => material.color.set(colors.ink));
  };
  return { group, bodies, show, put, pull, middle, paint, reach: reachOf(bodies, motion, middle) };
}

/** Build a body; its edges show through what hides it, but not through the machine itself. */
function buildBody({ name, whirl, mesh }, array, { ink, behind }) {
  const frame = new THREE.Group(), spinning = new THREE.Group();
  frame.name = name;
  frame.add(spinning);
  const geometry = geometryOf(mesh, array);
  const paints = mesh.colors.map(({ rgb }) => new THREE.MeshLambertMaterial({
    color: new THREE.Color().setRGB(...rgb, "srgb"), side: THREE.DoubleSide,
    polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
  const surface = new THREE.Mesh(geometry, paints);
  surface.castShadow = true;
  const edges = new THREE.LineSegments(edgesOf(mesh, array), ink);
  const hidden = new THREE.LineSegments(edges.geometry, behind);
  const veil = new THREE.Mesh(geometry, mesh.colors.map(({ rgb }) => seenThrough(rgb)));
  veil.renderOrder = hidden.renderOrder = 1; surface.renderOrder = 2; // after the world, which is 0
  spinning.add(surface, edges, hidden, veil);
  return { name, frame, spinning, whirl, geometry, mesh };
}

/**
 * A paint for what something hides: it is mixed with that.
 *
 * What is transparent would be drawn last, and could not tell the machine itself from what hides it.
 */
function seenThrough(rgb) {
  const [SOURCE_ALPHA, REST, CUSTOM] = [204, 205, 5]; // three.js's numbers for blending
  return new THREE.MeshBasicMaterial({ color: new THREE.Color().setRGB(...rgb, "srgb"), opacity: HIDDEN,
    depthFunc: THREE.GreaterDepth, depthWrite: false, blending: CUSTOM, blendSrc: SOURCE_ALPHA, blendDst: REST });
}

/** Return two lines per cable: one as wide as it is, and a thin one, which is seen from afar. */
function buildCables(group, radii) {
  const cables = radii.flatMap((radius) => [cableOf({ linewidth: 2 * radius, worldUnits: true, alphaToCoverage: true }), cableOf()]);
  group.add(...cables);
  return cables;
}

/** Return a line whose `geometry.setPositions` takes both ends; more of its paint may be given. */
export function cableOf(paint = {}) {
  const cable = new THREE.LineSegments2(
    new THREE.LineSegmentsGeometry(), new THREE.LineMaterial({ linewidth: 2.2, ...paint }));
  cable.frustumCulled = false;
  return cable;
}

/** The ends of the cable that a line is for; those of a slack one are not finite, and left out. */
function taut(ends, line) {
  const segment = ends.slice(6 * (line >> 1), 6 * (line >> 1) + 6);
  return segment.every(Number.isFinite) ? segment : [0, 0, 0, 0, 0, 0];
}

/** How far the machine reaches from the middle of its bodies at most, in [m]. */
function reachOf(bodies, motion, middle) {
  let reach = 1e-3;
  for (let i = 0; i < LOOKS; i++) {
    const t = motion.first + ((motion.last - motion.first) * i) / (LOOKS - 1), mean = middle(t);
    bodies.forEach(({ geometry }, k) => {
      if (!geometry.attributes.position.count) return;
      if (!geometry.boundingSphere) geometry.computeBoundingSphere();
      const { center, radius } = geometry.boundingSphere;
      const away = new THREE.Vector3(...motion.place(k, t)).sub(mean).length();
      reach = Math.max(reach, away + center.length() + radius);
    });
  }
  return reach;
}
