// The page: reads its data, builds its parts, and draws whenever something changed.

import { buildAddress, timeIn } from "./address.js";
import { axesOf } from "./axes.js";
import { MOVING, onLayer } from "./backdrop.js";
import { buildCaptions } from "./captions.js";
import { buildClock } from "./clock.js";
import { buildCompass } from "./compass.js";
import { element } from "./dom.js";
import { offeredDrive } from "./drive/drive.js";
import { joinDrive } from "./drive/join.js";
import { joinPoser } from "./drive/poser.js";
import { buildFrames } from "./frames.js";
import { buildCones, buildGhosts } from "./ghosts.js";
import { buildGrowing } from "./growing.js";
import { radiusOf, vectorsOf } from "./framing.js";
import { buildInset } from "./inset.js";
import { buildKeyboard } from "./keyboard.js";
import { followSearch } from "./live.js";
import { buildMachine } from "./machine.js";
import { motion } from "./motion.js";
import { orbitControl } from "./orbit.js";
import { unpacked } from "./pack.js";
import { buildPlots } from "./plots.js";
import { buildConstraints, buildHeading, buildReport } from "./report.js";
import { buildShade } from "./shade.js";
import { buildSky } from "./sky.js";
import { buildSnapshot } from "./snapshot.js";
import { buildSwitches } from "./switches.js";
import { PAINT, themes } from "./theme.js";
import { playTogether } from "./together.js";
import { buildTrails } from "./trail.js";
import { buildTransport } from "./transport.js";
import { buildViewer } from "./viewer.js";
import { VIEWS, views } from "./views.js";
import { buildWorld } from "./world.js";

const byId = (id) => document.getElementById(id);

/** Read the data and build everything; returns what `window.kinolab` offers. */
async function start() {
  const data = JSON.parse(byId("data").textContent), array = await unpacked(byId("pack").textContent);
  const moves = motion(data.motion, array);
  const clock = buildClock(moves.first, moves.last, data.speed);
  if (moves.last <= moves.first) document.body.classList.add("still");
  buildHeading(data, byId);
  const scene = buildScene(data, array, moves, clock);
  const transport = buildTransport(clock, array(data.knots), byId);
  const repainted = [];
  const drive = joinDrive(data, array, { clock, motion: moves }, scene, byId);
  const poser = joinPoser(data, scene, byId);
  fillPanel(data, array, clock, scene, repainted);
  const theme = themes(byId("theme"), (name) => {
    scene.paint(PAINT[name]);
    repainted.forEach((paint) => paint());
  });
  buildDrawer(scene.resize, Boolean(poser));
  const save = buildSnapshot(byId("snapshot"), byId("view"), { draw: scene.draw, name: data.name, title: data.title, clock });
  buildKeyboard(actionsOf(clock, transport, scene, theme, drive, save), byId("keys"), byId("keys-list"), byId("help"));
  const asked = timeIn(location.hash);
  if (data.live && scene.growing) followSearch(data.live, scene.growing, scene.switched, byId);
  clock.seek(asked ?? moves.first);
  buildAddress(clock);
  playTogether(clock);
  scene.draw();
  if (asked === null && !matchMedia("(prefers-reduced-motion: reduce)").matches) clock.play();
  return offered(data, moves, clock, scene, { drive, poser });
}

/** Build what is seen in 3-D; where WebGL is missing the rest of the page still works. */
function buildScene(data, array, moves, clock) {
  const axes = axesOf(data.up), canvas = byId("view");
  const corners = vectorsOf(array(data.hull)), size = radiusOf(corners);
  let viewer;
  try {
    viewer = buildViewer(canvas, axes, size);
  } catch (error) {
    byId("note").textContent = `This browser cannot show 3-D graphics here (${error.message}). The plots still work.`;
    byId("note").hidden = false;
    const nothing = () => {};
    return { layers: [], switched: nothing, paint: nothing, resize: nothing, draw: nothing, fps: () => 0, choose: nothing };
  }
  const world = buildWorld(data, array), machine = buildMachine(data, array, moves);
  const trails = buildTrails(data, array, moves), ghosts = buildGhosts(data, machine.bodies);
  const cones = buildCones(data, array), { scene, camera } = viewer;
  const growing = data.live ? buildGrowing() : null;
  const shade = viewer.plain && data.floor ? buildShade(machine.bodies, viewer.from, data.floor) : null;
  const sky = data.setting.name === "studio" ? null : buildSky(data.setting);
  const captions = buildCaptions(data.captions, byId("stage"));
  const compass = buildCompass(data, moves.last > moves.first, byId("stage"));
  const inset = buildInset(viewer, byId("stage"), world);
  const frames = buildFrames(data.frames, motion(data.frames.joints, array), machine.bodies, byId("stage"));
  const parts = [sky?.sheet, shade?.group, world.group, machine.group, trails.path, trails.others, trails.tree, ghosts.start, ghosts.goal, cones,
                 growing?.tree, growing?.path, frames.group];
  parts.filter(Boolean).forEach((part) => scene.add(part));
  [machine.group, trails.behind, shade?.group, frames.group].filter(Boolean).forEach((part) => onLayer(part, MOVING));

  let dirty = true;
  const drivers = [], acting = () => drivers.find(({ active }) => active); // who moves the machine instead of the plan
  const changed = () => { dirty = true; };
  const switched = () => { viewer.forget(); changed(); };
  const orbit = orbitControl(camera, canvas, axes, changed);
  orbit.depth = 4 * Math.max(size, machine.reach);
  orbit.nearest = machine.reach / 20; orbit.farthest = 20 * size;
  const followed = { middle: (t) => (acting() ?? machine).middle(t), reach: machine.reach };
  const track = array(data.follow), planned = () => !acting();
  const camera_views = views(orbit, camera, { corners, axes, overview: data, track, planned }, followed, changed);
  const resize = () => {
    viewer.resize();
    if (camera_views.name && camera_views.name !== "follow") camera_views.choose(camera_views.name, clock.time, { jump: true });
    changed();
  };
  const pictures = [];
  const draw = () => {
    const driver = acting();
    (driver ?? machine).show(clock.time); trails.show(clock.time); shade?.show();
    frames.show(clock.time, driver?.joints());
    camera_views.follow(clock.time);
    viewer.draw(orbit.target, orbit.distance);
    inset.show(followed, clock.time);
    captions.show(camera); compass.show(camera); frames.label(camera);
  };
  let before = null;
  const tick = (now) => {
    requestAnimationFrame(tick);
    const passed = before === null ? 0 : (now - before) / 1000;
    before = now;
    const driver = acting();
    if (driver) dirty = driver.pass(Math.min(passed, 0.25)) || dirty;
    else if (clock.playing) { clock.pass(Math.min(passed, 0.25)); dirty = true; }
    if (!dirty) { pictures.length = 0; return; }
    dirty = camera_views.follow(clock.time);
    draw();
    pictures.push(now);
    while (pictures.length > 2 && now - pictures[0] > 2000) pictures.shift(); // slow is not none
    clock.pace = 1000 * passed;
    if ((clock.playing || driver) && pictures.length > 2) viewer.spare(clock.pace);
  };
  clock.listeners.push(changed);
  new ResizeObserver(resize).observe(canvas);
  viewer.resize();
  camera_views.choose(data.view, clock.time, { jump: true });
  buildViewButtons(camera_views, clock);
  requestAnimationFrame(tick);
  const paint = (colors) => {
    [world, machine, trails, growing, shade, ...drivers, viewer].forEach((part) => part?.paint(colors));
    sky?.paint(colors.dark);
    changed();
  };
  const fps = () => (pictures.length < 2 ? 0
    : (1000 * (pictures.length - 1)) / (pictures[pictures.length - 1] - pictures[0]));
  const layers = [
    { label: `Path of ${data.bodies[data.leading]?.name}`, object: trails.path, on: true },
    { label: "Paths of the other bodies", object: trails.others, on: false },
    { label: "Search tree", object: growing?.tree ?? trails.tree, on: growing !== null },
    { label: "Start", object: ghosts.start, on: true }, { label: "Goal", object: ghosts.goal, on: true },
    { label: "Target and keep-out cones", object: cones, on: true },
    { label: "World", object: world.group, on: true },
    { label: "Frames of joints and bodies, with names", object: frames.object, on: data.frames.shown },
    { label: "Labels", object: captions.object, on: true },
    { label: "Close-up of a small machine", object: inset, on: true },
    { label: "Legend and axes", object: compass.object, on: true },
  ];
  /** Let somebody else move the machine while `active`, with more to see. */
  const join = (another) => {
    drivers.push(another);
    another.groups.forEach((group) => { scene.add(group); onLayer(group, MOVING); });
  };
  return { layers, switched, changed, join, machine, axes: frames.object, world, viewName: () => camera_views.name, growing, paint, resize, draw, fps, triangles: world.triangles,
           choose: (name) => camera_views.choose(name, clock.time) };
}

function buildViewButtons(camera_views, clock) {
  const buttons = VIEWS.map(({ name, label, key }) => {
    const button = element("button", { type: "button", title: `${label} (${key})` }, label);
    button.addEventListener("click", () => camera_views.choose(name, clock.time));
    byId("views").append(button);
    return { name, button };
  });
  const mark = (chosen) => buttons.forEach(({ name, button }) => button.setAttribute("aria-pressed", name === chosen));
  camera_views.listeners.push(mark);
  mark(camera_views.name);
}

function fillPanel(data, array, clock, scene, repainted) {
  const panel = byId("panel");
  panel.append(buildReport(data));
  if (array(data.knots).length > 1) panel.append(buildPlots(data, array, clock, repainted));
  if (data.constraints.length && !data.posing) panel.append(buildConstraints(data));
  panel.append(buildSwitches(scene.layers, () => scene.switched()));
}

/** The panel beside the scene; on a narrow screen it begins closed, unless what one came for is in it. */
function buildDrawer(resize, needed) {
  const button = byId("drawer"), narrow = matchMedia("(max-width: 760px)");
  const set = (open) => {
    document.body.classList.toggle("closed", !open);
    button.setAttribute("aria-expanded", open);
    resize();
  };
  button.addEventListener("click", () => set(document.body.classList.contains("closed")));
  narrow.addEventListener("change", () => set(!narrow.matches));
  set(needed || !narrow.matches);
}

function actionsOf(clock, transport, scene, theme, drive, save) {
  const step = (count) => (event) => transport.step(event.shiftKey ? 10 * count : count);
  return [
    { keys: [" "], shown: ["space"], help: "Play or pause", run: clock.toggle },
    { keys: ["ArrowLeft"], shown: ["←", "→"], help: "Previous or next step (with shift: ten steps)", run: step(-1) },
    { keys: ["ArrowRight"], run: step(1) },
    { keys: ["Home"], shown: ["Home", "End"], help: "Jump to the beginning or the end", run: () => clock.seek(clock.first) },
    { keys: ["End"], run: () => clock.seek(clock.last) },
    { keys: ["+", "="], shown: ["+", "−"], help: "Faster or slower", run: () => transport.faster(1) },
    { keys: ["-"], run: () => transport.faster(-1) },
    ...VIEWS.map(({ name, label, key }) => ({ keys: [key], shown: [key], help: `View: ${label}`, run: () => scene.choose(name) })),
    ...(drive ? [{ keys: ["m"], shown: ["m"], help: "Start or stop driving the machine yourself", run: drive.toggle }] : []),
    { keys: ["a"], shown: ["a"], help: "Frames of joints and bodies: show or hide", run: () => scene.axes?.toggle() },
    { keys: ["d"], shown: ["d"], help: "Dark or light mode", run: theme.toggle },
    { keys: ["s"], shown: ["s"], help: "Save a picture of the scene", run: save },
    { keys: ["p"], shown: ["p"], help: "Show or hide the panel", run: () => byId("drawer").click() },
  ];
}

/** What tests and teachers may call; docs/page.md describes it. */
function offered(data, moves, clock, scene, { drive, poser }) {
  return {
    get time() { return clock.time; },
    get playing() { return clock.playing; },
    get speed() { return clock.speed; },
    set speed(value) { clock.setSpeed(value); },
    first: moves.first, last: moves.last, bodies: data.bodies.map(({ name }) => name),
    play: clock.play, pause: clock.pause, fps: scene.fps,
    seek: (t) => { clock.seek(t); scene.draw(); },
    view: scene.choose, drive: drive && offeredDrive(drive), pose: poser,
    frames: (t = clock.time) => Object.fromEntries(data.bodies.map(({ name }, k) => [name, moves.frame(k, t)])),
  };
}

window.kinolab = { ready: null };
window.kinolab.ready = start().then((api) => {
  Object.defineProperties(window.kinolab, Object.getOwnPropertyDescriptors(api));
  return window.kinolab;
});
