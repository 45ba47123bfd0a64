// Camera presets, and the one that goes with the machine.

import { framed } from "./framing.js";

const GLIDE = 350; // [ms] from one view to the next
const ROOM = 3.6; // radii of the machine in the picture that follows it
const MOST = 0.85; // times the distance from which all is seen: machines that would be seen from farther away are as large as their world

export const VIEWS = [
  { name: "perspective", label: "3-D", key: "0" },
  { name: "front", label: "Front", key: "1" },
  { name: "top", label: "Top", key: "2" },
  { name: "side", label: "Side", key: "3" },
  { name: "follow", label: "Follow", key: "4" },
];

/**
 * Steer an orbit by presets; returns {choose, follow, name}.
 *
 * `scene` has {corners, axes} of what is seen, `overview` {azimuth, elevation} from where most of the way
 * is seen, and `track`, rows of time, azimuth and elevation from where no wall hides the machine while
 * it is where it is `planned()` to be.
 */
export function views(orbit, camera, scene, machine, changed) {
  const { corners, axes, overview, track } = scene;
  const quiet = matchMedia("(prefers-reduced-motion: reduce)");
  const views = { name: "perspective", listeners: [], still: null };
  let glide = null;
  orbit.moved = () => { if (views.name === "follow") tell(null); };

  /** Angles, target and distance of a preset in a picture of the present shape. */
  const aim = (name, t) => {
    const angles = anglesOf(name, t);
    orbit.azimuth = angles.azimuth; orbit.elevation = angles.elevation;
    const up = name === "top" ? axes.toward.clone().negate() : axes.up;
    const fov = (camera.fov * Math.PI) / 180;
    const whole = framed(corners, orbit.look(), up, fov, camera.aspect);
    if (name !== "follow") return { ...angles, ...whole };
    const near = (ROOM * machine.reach) / (Math.tan(fov / 2) * Math.min(1, camera.aspect));
    const large = near > MOST * whole.distance;
    views.still = large ? whole.target : null; // beside a machine that is as large, the world would be cut off
    if (large && scene.planned()) return { ...angles, ...whole };
    return { ...angles, target: machine.middle(t), distance: large ? whole.distance : near };
  };
  const anglesOf = (name, t) => {
    if (name === "top") return { azimuth: 0, elevation: Math.PI / 2 - 0.011 };
    if (name === "front") return { azimuth: 0, elevation: 0 };
    if (name === "side") return { azimuth: Math.PI / 2, elevation: 0 };
    if (name === "follow") return beside(track, t);
    return { azimuth: overview.azimuth, elevation: overview.elevation };
  };
  /** Turn as the side changes on which no wall is, from wherever the reader has turned to. */
  const goRound = (t) => {
    const now = beside(track, t);
    if (views.beside && scene.planned()) {
      orbit.azimuth += now.azimuth - views.beside.azimuth;
      orbit.elevation += now.elevation - views.beside.elevation;
    }
    views.beside = now;
  };
  const tell = (name) => {
    views.name = name;
    views.listeners.forEach((listener) => listener(name));
  };

  /** Go to a preset, smoothly where the reader does not mind motion. */
  views.choose = (name, t, { jump = false } = {}) => {
    const from = { azimuth: orbit.azimuth, elevation: orbit.elevation, distance: orbit.distance,
                   target: orbit.target.clone() };
    const to = aim(name, t);
    tell(name);
    views.beside = null;
    glide = jump || quiet.matches ? null : { from, to, begun: performance.now() };
    if (!glide) set(to);
    else set(from);
    changed();
  };
  const set = ({ azimuth, elevation, distance, target }) => {
    Object.assign(orbit, { azimuth, elevation, distance });
    orbit.target.copy(target);
    orbit.place();
  };

  const followed = (t) => (scene.planned() && views.still) || machine.middle(t);

  /** Bring the camera to where it belongs at a time; says whether it is still on its way. */
  views.follow = (t) => {
    if (views.name === "follow" && !glide) { goRound(t); orbit.target.copy(followed(t)); orbit.place(); }
    if (!glide) return false;
    if (views.name === "follow") { glide.to.target = followed(t); views.beside = null; }
    const share = Math.min((performance.now() - glide.begun) / GLIDE, 1), s = share * share * (3 - 2 * share);
    const mix = (a, b) => a + s * (b - a), { from, to } = glide;
    set({ azimuth: mix(from.azimuth, to.azimuth), elevation: mix(from.elevation, to.elevation),
          distance: from.distance * (to.distance / from.distance) ** s,
          target: from.target.clone().lerp(to.target, s) });
    if (share === 1) glide = null;
    return share < 1;
  };
  return views;
}

/** Where the camera is that goes with the machine, between two rows of time, azimuth, elevation. */
function beside(track, t) {
  const rows = track.length / 3, row = (k) => track.subarray(3 * k, 3 * k + 3);
  let k = 0;
  while (k + 2 < rows && row(k + 1)[0] <= t) k++;
  const a = row(k), b = row(Math.min(k + 1, rows - 1));
  const part = Math.min(Math.max((t - a[0]) / Math.max(b[0] - a[0], 1e-9), 0), 1), s = part * part * (3 - 2 * part);
  return { azimuth: a[1] + s * (b[1] - a[1]), elevation: a[2] + s * (b[2] - a[2]) };
}
