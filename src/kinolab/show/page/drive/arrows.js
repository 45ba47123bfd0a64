// Forces of constraints as arrows where they act.

import { turned } from "./solids.js";

const LONGEST = 1.8; // of an arrow, in reaches of the machine
const FADING = 0.995; // per picture: how fast the scale forgets a large force
const LEAST = 0.02; // of the longest arrow; what is shorter is left out
const SHAFT = [[0, 0], [0.016, 0], [0.016, 1]], HEAD = [[0, 0], [0.05, 0], [0, 1]]; // radius, height

/** Build arrows for a machine that reaches so far, in [m]; `show(forces)` gives the longest in N. */
export function buildArrows(reach) {
  const group = new THREE.Group(), paint = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true }); // seen through the machine
  const [shaft, head] = [SHAFT, HEAD].map(surface), arrows = [];
  let scale = 0;
  group.visible = false;

  const arrow = (k) => {
    if (!arrows[k]) {
      arrows[k] = new THREE.Group();
      arrows[k].add(new THREE.Mesh(shaft, paint), new THREE.Mesh(head, paint));
      arrows[k].traverse((part) => { part.layers.mask = group.layers.mask; });
      group.add(arrows[k]);
    }
    return arrows[k];
  };
  const show = (forces) => {
    const sized = forces.map(({ at, force }) => ({ at, force, size: force ? Math.hypot(...force) : 0 }))
      .filter(({ at, size }) => size > 0 && Number.isFinite(size) && at.every(Number.isFinite));
    scale = Math.max(FADING * scale, ...sized.map(({ size }) => size));
    arrows.forEach((made) => { made.visible = false; });
    sized.filter(({ size }) => size > LEAST * scale).forEach(({ at, force, size }, k) => {
      point(arrow(k), at, force, size, (LONGEST * reach * size) / scale, reach);
    });
    return scale;
  };
  return { group, show, paint: (colors) => paint.color.set(colors.force) };
}

/** Lay one arrow: its shaft begins where the force acts. */
function point(arrow, at, force, size, length, reach) {
  const [shaft, head] = arrow.children, tip = Math.min(0.25 * reach, length);
  arrow.visible = true;
  arrow.position.set(...at);
  arrow.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), new THREE.Vector3(...force).divideScalar(size));
  shaft.scale.set(reach, reach, Math.max(length - tip, 1e-9));
  head.scale.set(reach, reach, tip);
  head.position.z = length - tip;
}

function surface(profile) {
  const { points, faces } = turned(profile, "z"), geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(points.flat()), 3));
  geometry.setIndex(faces);
  return geometry;
}
