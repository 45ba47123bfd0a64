// The way that bodies' origins take, the part behind the machine stronger, and the search tree.

const SAMPLES = 500; // of a path

/** Build the leading body's path, the others' paths, and the tree; each has `lines` and `paint`. */
export function buildTrails(data, array, motion) {
  const bodies = [...Array(motion.bodies).keys()];
  const times = sampled(motion);
  const main = ribbon(pathOf(motion, data.leading, times), 3.0), behind = ribbon(pathOf(motion, data.leading, times), 3.0);
  const path = new THREE.Group(), others = new THREE.Group();
  path.add(main, behind);
  bodies.filter((body) => body !== data.leading).forEach((body) => others.add(ribbon(pathOf(motion, body, times), 1.4)));
  const tree = data.tree && segments(array(data.tree));
  const show = (t) => {
    const share = (t - motion.first) / Math.max(motion.last - motion.first, 1e-12);
    behind.geometry.instanceCount = Math.round(share * (times.length - 1));
  };
  const paint = (colors) => {
    main.material.color.set(colors.ahead); behind.material.color.set(colors.path);
    others.children.forEach(({ material }) => material.color.set(colors.path));
    if (tree) tree.material.color.set(colors.tree);
  };
  const moves = motion.last > motion.first;
  return { path: moves ? path : null, behind, others: moves && bodies.length > 1 ? others : null, tree, show, paint };
}

function sampled({ first, last }) {
  return [...Array(SAMPLES).keys()].map((k) => first + ((last - first) * k) / (SAMPLES - 1));
}

function pathOf(motion, body, times) {
  return times.flatMap((t) => motion.place(body, t));
}

/** Return a line of constant width on the screen through points, three numbers each. */
export function ribbon(points, linewidth) {
  const pieces = new Float32Array(2 * Math.max(points.length - 3, 0));
  for (let k = 0; k + 3 < points.length; k += 3)
    for (let i = 0; i < 6; i++) pieces[2 * k + i] = points[k + i];
  const geometry = new THREE.LineSegmentsGeometry();
  geometry.setPositions(pieces);
  const line = new THREE.LineSegments2(geometry, new THREE.LineMaterial({ linewidth }));
  line.frustumCulled = false;
  return line;
}

/** Return thin lines, each between two points. */
export function segments(points, opacity = 0.45) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
  return new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ transparent: true, opacity }));
}
