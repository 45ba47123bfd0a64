// Bodies whose sizes follow from parameters: drawn anew while a parameter is not the plan's.

import { solid } from "./solids.js";

/** Watch the sizes of all bodies; `show(parameters)` draws those that changed in plain colours. */
export function buildResizing(machine, bodies) {
  const usual = machine.shapes().map((list) => JSON.stringify(list));
  const drawn = bodies.map((_, k) => ({ text: usual[k], group: null }));
  let shown = machine.defaults;

  const draw = (k, shapes, text) => {
    const { spinning } = bodies[k], body = drawn[k];
    if (body.group) spinning.remove(body.group);
    body.group = null;
    body.text = text;
    spinning.children.forEach((part) => { part.visible = text === usual[k]; });
    if (text === usual[k]) return;
    body.group = new THREE.Group();
    const paint = spinning.children[0].material;
    shapes.forEach((shape) => body.group.add(new THREE.Mesh(solid(shape), Array.isArray(paint) ? paint[0] : paint)));
    body.group.traverse((part) => { part.layers.mask = spinning.layers.mask; });
    spinning.add(body.group);
  };
  const show = (parameters) => {
    if (parameters === shown) return;
    shown = parameters;
    machine.shapes(parameters).forEach((shapes, k) => {
      const text = JSON.stringify(shapes);
      if (text !== drawn[k].text) draw(k, shapes, text);
    });
  };
  return { show, undo: () => show(machine.defaults) };
}
