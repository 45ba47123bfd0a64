// A small machine enlarged in a corner of the scene, as in films.

const SMALL = 0.07, FILL = 0.42; // of the picture's height: what is small; how large it becomes in the corner
const PART = 0.26, SHAPE = 4 / 3, EDGE = 12; // the corner's height in the picture's, width for height 1, [pixel] to the edge
const MANY = 20000; // triangles that are drawn once more where there is no graphics processor

/** Build the corner of a viewer; `show(machine, t)` draws it where the machine is small, over the picture. */
export function buildInset(viewer, stage, { triangles }) {
  const frame = document.createElement("div"), eye = viewer.camera.clone();
  frame.id = "inset";
  frame.hidden = true;
  frame.setAttribute("aria-hidden", "true");
  stage.append(frame);
  const inset = { visible: true };

  inset.show = (machine, t) => {
    const { camera } = viewer, middle = machine.middle(t), slope = Math.tan((camera.fov * Math.PI) / 360);
    const away = camera.position.distanceTo(middle), size = machine.reach / (away * slope);
    const height = Math.round(PART * stage.clientHeight), width = Math.round(SHAPE * height);
    const wanted = inset.visible && size < SMALL && stage.clientWidth > 2 * width && !(viewer.plain && triangles > MANY);
    frame.hidden = !wanted;
    if (!wanted) return;
    frame.style.width = `${width}px`; frame.style.height = `${height}px`;
    frame.dataset.times = `${Number(((FILL * PART) / size).toPrecision(2))}×`;
    eye.fov = camera.fov; eye.aspect = SHAPE;
    const look = camera.position.clone().sub(middle).normalize(), near = machine.reach / (FILL * slope);
    eye.position.copy(middle).addScaledVector(look, near);
    eye.up.copy(camera.up);
    eye.lookAt(middle);
    eye.near = near / 100; eye.far = 2 * away;
    eye.updateProjectionMatrix();
    viewer.corner(eye, { x: stage.clientWidth - width - EDGE, y: EDGE, width, height });
  };
  return inset;
}
