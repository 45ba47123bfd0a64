// Camera presets, and the one that goes with the machine.

import { framed } from "./framing.js";

const OVERVIEW = { azimuth: (18 * Math.PI) / 180 }; // off the front, so that two sides are seen
const FLAT = (58 * Math.PI) / 180, TALL = (20 * Math.PI) / 180; // over a floor plan, beside a tower
const NEAR = 0.62; // [rad] elevation of the view that follows
const GLIDE = 350; // [ms] from one view to the next
const ROOM = 3.6; // radii of the machine in the picture that follows it
const MOST = 0.85; // times the distance from which all is seen, for machines as large as their world

export const VIEWS = [
  { name: "perspective", label: "3-D", key: "0" },
  { name: "front", label: "Front", key: "1" },
  { name: "top", label: "Top", key: "2" },
  { name: "side", label: "Side", key: "3" },
  { name: "follow", label: "Follow", key: "4" },
];

/** Steer an orbit by presets; returns {choose, follow, name}. */
export function views(orbit, camera, corners, axes, machine, changed) {
  const quiet = matchMedia("(prefers-reduced-motion: reduce)");
  const views = { name: "perspective", listeners: [] };
  let glide = null;
  orbit.moved = () => { if (views.name === "follow") tell(null); };

  /** Angles, target and distance of a preset in a picture of the present shape. */
  const aim = (name, t) => {
    const angles = anglesOf(name);
    orbit.azimuth = angles.azimuth; orbit.elevation = angles.elevation;
    const up = name === "top" ? axes.toward.clone().negate() : axes.up;
    const fov = (camera.fov * Math.PI) / 180;
    const whole = framed(corners, orbit.look(), up, fov, camera.aspect);
    if (name !== "follow") return { ...angles, ...whole };
    const near = (ROOM * machine.reach) / (Math.tan(fov / 2) * Math.min(1, camera.aspect));
    return { ...angles, target: machine.middle(t), distance: Math.min(near, MOST * whole.distance) };
  };
  const anglesOf = (name) => {
    if (name === "top") return { azimuth: 0, elevation: Math.PI / 2 - 0.011 };
    if (name === "front") return { azimuth: 0, elevation: 0 };
    if (name === "side") return { azimuth: Math.PI / 2, elevation: 0 };
    if (name === "follow") return { azimuth: (-32 * Math.PI) / 180, elevation: NEAR };
    return { azimuth: -OVERVIEW.azimuth, elevation: steepness(corners, axes) };
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

  /** Bring the camera to where it belongs at a time; says whether it is still on its way. */
  views.follow = (t) => {
    if (views.name === "follow" && !glide) { orbit.target.copy(machine.middle(t)); orbit.place(); }
    if (!glide) return false;
    if (views.name === "follow") glide.to.target = machine.middle(t);
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

/** The elevation of the overview: steep over what is flat, where walls hide the floor. */
function steepness(corners, axes) {
  const extent = (axis) => {
    const along = corners.map((corner) => corner.dot(axis));
    return Math.max(...along) - Math.min(...along);
  };
  const slender = extent(axes.up) / Math.max(extent(axes.across), extent(axes.toward), 1e-12);
  const share = Math.min(Math.max((slender - 0.25) / (0.8 - 0.25), 0), 1);
  return FLAT + share * (TALL - FLAT);
}
