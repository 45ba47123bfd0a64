// Renderer, camera and light; a picture is drawn when something changed, and simpler when it is slow.

import { buildBackdrop, MOVING } from "./backdrop.js";

const FOV = 30; // [degrees]
const SLOW = 45; // [ms] per picture: beyond it, pixels and shadows are saved
const PATIENCE = 8; // slow pictures in a row
const COARSEST = 0.6; // pixels of a picture per pixel of the screen, in each direction

/** Show a scene on a canvas; `draw()` paints it, `resize()` follows the canvas. */
export function buildViewer(canvas, axes, size) {
  const plain = drawsInSoftware();
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: !plain, powerPreference: "high-performance" });
  const camera = new THREE.PerspectiveCamera(FOV, 1, 0.1, 100), scene = new THREE.Scene();
  const light = buildLight(scene, axes, size), backdrop = buildBackdrop(renderer, scene, camera);
  let ratio = plain ? 1 : Math.min(devicePixelRatio || 1, 2), slow = 0, moving = true, before = "";
  renderer.shadowMap.enabled = light.sun.castShadow = !plain;
  renderer.shadowMap.type = THREE.PCFShadowMap;
  renderer.localClippingEnabled = true;

  const resize = () => {
    const width = Math.max(canvas.clientWidth, 1), height = Math.max(canvas.clientHeight, 1);
    renderer.setPixelRatio(ratio);
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
  };
  /** Save work after several slow pictures: first fine pixels, then shadows, then more pixels. */
  const spare = (milliseconds) => {
    slow = milliseconds > SLOW ? slow + 1 : 0;
    if (slow < PATIENCE) return;
    slow = 0;
    if (ratio > 1) ratio = 1;
    else if (renderer.shadowMap.enabled) renderer.shadowMap.enabled = light.sun.castShadow = false;
    else if (ratio > COARSEST) ratio = COARSEST;
    else return;
    resize();
  };
  const draw = (target, distance) => {
    light.aim(target, distance);
    camera.updateMatrixWorld();
    const place = camera.matrixWorld.elements.join();
    moving = place !== before;
    before = place;
    if (plain && !moving) { backdrop.draw(); return; }
    camera.layers.enable(0); camera.layers.enable(MOVING);
    renderer.render(scene, camera);
  };
  /** Draw the scene once more into a corner {x, y, width, height}, in [pixel] from the lower left. */
  const corner = (eye, { x, y, width, height }) => {
    eye.layers.enable(0); eye.layers.enable(MOVING);
    renderer.setViewport(x, y, width, height); renderer.setScissor(x, y, width, height);
    renderer.setScissorTest(true);
    renderer.render(scene, eye);
    renderer.setScissorTest(false);
    renderer.setViewport(0, 0, Math.max(canvas.clientWidth, 1), Math.max(canvas.clientHeight, 1));
  };
  const paint = (colors) => {
    scene.background = new THREE.Color(colors.paper);
    light.paint(colors);
    backdrop.forget();
  };
  return { camera, scene, resize, spare, draw, corner, paint, forget: backdrop.forget, plain, from: light.from };
}

/** Whether no graphics processor helps: then edges are not smoothed, and nothing casts shadows. */
function drawsInSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const facts = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = facts ? gl.getParameter(facts.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|basic render|software/i.test(name);
}

/** A sun from above, whose shadows are as fine as the part of the world that is looked at. */
function buildLight(scene, axes, size) {
  const sky = new THREE.HemisphereLight(), sun = new THREE.DirectionalLight();
  sky.position.copy(axes.up);
  const from = new THREE.Vector3().addScaledVector(axes.up, 2.2)
    .addScaledVector(axes.toward, 0.9).addScaledVector(axes.across, 0.7).normalize();
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.bias = -2e-4;
  [sky, sun].forEach((lamp) => lamp.layers.enable(MOVING));
  scene.add(sky, sun, sun.target);
  const aim = (target, distance) => {
    const reach = Math.min(0.75 * distance, size), box = sun.shadow.camera;
    sun.target.position.copy(target);
    sun.position.copy(target).addScaledVector(from, 2 * size);
    if (box.right === reach) return;
    Object.assign(box, { left: -reach, right: reach, bottom: -reach, top: reach, near: 0.1 * size, far: 4 * size });
    sun.shadow.normalBias = reach / 600;
    box.updateProjectionMatrix();
  };
  const paint = (colors) => {
    sky.color.set(colors.sky); sky.groundColor.set(colors.earth);
    sky.intensity = colors.fill; sun.intensity = colors.sun;
    sun.shadow.intensity = colors.shadow;
  };
  return { sun, aim, paint, from };
}
