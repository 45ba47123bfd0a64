// A search while it goes on: its tree, and the way of the best motion so far.

import { ribbon, segments } from "./trail.js";

/** Build both, empty; `grow` and `lead` take points, three numbers each. */
export function buildGrowing() {
  const tree = new THREE.Group(), path = new THREE.Group();
  let colors = null;
  const renew = (group, line) => {
    group.children.forEach(({ geometry, material }) => { geometry.dispose(); material.dispose(); });
    group.clear();
    group.add(line);
    paint(colors);
  };
  const paint = (next) => {
    colors = next;
    if (!colors) return;
    tree.children.forEach(({ material }) => material.color.set(colors.tree));
    path.children.forEach(({ material }) => material.color.set(colors.path));
  };
  return { tree, path, paint,
           grow: (points) => renew(tree, segments(points, 0.8)),
           lead: (points) => renew(path, ribbon(Array.from(points), 3.0)) };
}
