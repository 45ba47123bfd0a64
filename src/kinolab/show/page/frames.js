// The frames of world, joints and bodies as three axes each, with their names; before everything else.

import { element } from "./dom.js";
import { cableOf } from "./machine.js";
import { quaternionOf } from "./drive/between.js";

const COLORS = [0xd55e00, 0x009e73, 0x0072b2]; // x, y, z, as in films and in the corner
const LINE = 17; // [pixel] from a name to the one below it
const LINES = 5; // of names under each other, where several frames have the same origin

/**
 * Build the axes of `frames` {names, length}; `joints` is the motion of the joints' frames, `bodies` are
 * those of the machine. `show(t, posed)` moves them: `posed` has the poses of joints of a machine that
 * somebody else moves, 12 numbers each. `label(camera)` writes the names.
 */
export function buildFrames({ names, length }, joints, bodies, stage) {
  const group = new THREE.Group(), layer = element("div", { class: "names", "aria-hidden": "true" });
  const frames = names.map((name) => {
    const frame = tripod(length), sign = element("span", { class: "sign frame" }, name);
    group.add(frame);
    layer.append(sign);
    return { frame, sign };
  });
  stage.append(layer);

  const show = (t, posed) => {
    for (let k = 0; k < joints.bodies; k++) {
      const { frame } = frames[1 + k], at = 12 * k;
      frame.position.set(...(posed ? [3, 7, 11].map((i) => posed[at + i]) : joints.place(k, t)));
      frame.quaternion.set(...(posed ? quaternionOf(posed, at) : joints.turn(k, t)));
    }
    bodies.forEach(({ frame: body }, k) => {
      const { frame } = frames[1 + joints.bodies + k];
      frame.position.copy(body.position);
      frame.quaternion.copy(body.quaternion);
    });
  };
  const label = (camera) => {
    if (!group.visible) return;
    const taken = [];
    frames.forEach(({ frame, sign }) => {
      const seen = frame.position.clone().project(camera);
      const x = (0.5 + seen.x / 2) * stage.clientWidth, top = (0.5 - seen.y / 2) * stage.clientHeight + 4;
      const row = [...Array(LINES).keys()].map((k) => top + k * LINE).find((y) => taken.every(
        ([a, b, wide]) => Math.abs(b - y) >= LINE || Math.abs(a - x) > (wide + sign.textContent.length) * 4 + 12));
      sign.hidden = row === undefined || Math.abs(seen.z) > 1 || x < 0 || x > stage.clientWidth || row > stage.clientHeight;
      if (sign.hidden) return;
      taken.push([x, row, sign.textContent.length]);
      sign.style.transform = `translate(${x.toFixed(1)}px, ${row.toFixed(1)}px) translate(-50%, 0)`;
    });
  };
  const object = { get visible() { return group.visible; }, set visible(on) { group.visible = on; layer.hidden = !on; } };
  return { group, object, show, label };
}

function tripod(length) {
  const frame = new THREE.Group();
  COLORS.forEach((color, axis) => {
    const tip = [0, 0, 0];
    tip[axis] = length;
    [[0xffffff, 4.4], [color, 2.4]].forEach(([paint, linewidth], k) => { // bodies may have the colour of an axis
      const line = cableOf({ color: paint, linewidth, depthTest: false, transparent: true });
      line.geometry.setPositions([0, 0, 0, ...tip]);
      line.renderOrder = 5 + k; // after all that hides something
      frame.add(line);
    });
  });
  return frame;
}
