// Which bodies of the driven machine touch which obstacles, as they are drawn.

import { overlap } from "./overlap.js";

const CELLS = 48; // along the longest side of the world
const AXES = { x: 0, y: 1, z: 2 };

/** Read the obstacles; `touching(poses, shapes)` gives [body, obstacle] by their indices, each pair once. */
export function buildContacts(obstacles, array) {
  const faces = obstacles.flatMap(({ mesh }, k) => trianglesOf(array(mesh.vertices), array(mesh.faces), k));
  const grid = buildGrid(faces);
  let asked = 0;
  const touching = (poses, shapes) => {
    const found = [];
    shapes.forEach((list, body) => list.forEach((shape) => {
      const farthest = reachOf(shape, poses.subarray ? poses.subarray(12 * body, 12 * body + 12) : poses.slice(12 * body, 12 * body + 12));
      const box = boxOf(farthest);
      asked += 1;
      grid.near(box, (face) => {
        if (face.asked === asked || apart(face, box)) return;
        face.asked = asked;
        if (found.some(([b, o]) => b === body && o === face.obstacle)) return;
        if (overlap(farthest, (d) => farthestOf(face.corners, d))) found.push([body, face.obstacle]);
      });
    }));
    return found;
  };
  return { touching };
}

function trianglesOf(points, faces, obstacle) {
  const made = [], corner = (v) => [points[3 * v], points[3 * v + 1], points[3 * v + 2]];
  for (let f = 0; f < faces.length; f += 3) {
    const corners = [corner(faces[f]), corner(faces[f + 1]), corner(faces[f + 2])];
    const low = [0, 1, 2].map((k) => Math.min(...corners.map((p) => p[k])));
    const high = [0, 1, 2].map((k) => Math.max(...corners.map((p) => p[k])));
    made.push({ corners, low, high, obstacle, asked: 0 });
  }
  return made;
}

/** Cells of equal size, each with the faces whose boxes reach into it. */
function buildGrid(faces) {
  const low = [0, 1, 2].map((k) => faces.reduce((least, face) => Math.min(least, face.low[k]), Infinity));
  const high = [0, 1, 2].map((k) => faces.reduce((most, face) => Math.max(most, face.high[k]), -Infinity));
  const size = Math.max(...[0, 1, 2].map((k) => high[k] - low[k]), 1e-9) / CELLS, cells = new Map();
  const place = (value, k) => Math.min(Math.max(Math.floor((value - low[k]) / size), 0), CELLS - 1);
  const visit = (box, each) => {
    for (let x = place(box.low[0], 0); x <= place(box.high[0], 0); x++)
      for (let y = place(box.low[1], 1); y <= place(box.high[1], 1); y++)
        for (let z = place(box.low[2], 2); z <= place(box.high[2], 2); z++) each((x * CELLS + y) * CELLS + z);
  };
  faces.forEach((face) => visit(face, (key) => {
    if (!cells.has(key)) cells.set(key, []);
    cells.get(key).push(face);
  }));
  return { near: (box, each) => visit(box, (key) => cells.get(key)?.forEach(each)) };
}

function apart(a, b) {
  return [0, 1, 2].some((k) => a.low[k] > b.high[k] || a.high[k] < b.low[k]);
}

function boxOf(farthest) {
  const unit = (k, sign) => [0, 1, 2].map((i) => (i === k ? sign : 0));
  return { low: [0, 1, 2].map((k) => farthest(unit(k, -1))[k]), high: [0, 1, 2].map((k) => farthest(unit(k, 1))[k]) };
}

function farthestOf(corners, d) {
  const along = corners.map((p) => p[0] * d[0] + p[1] * d[1] + p[2] * d[2]);
  return corners[along.indexOf(Math.max(...along))];
}

/** A function from a direction to the farthest point of a shape {kind, axis, size, at} at a pose [R | p]. */
function reachOf({ kind, axis, size, at }, g) {
  const support = { box: ofBox, sphere: ofBall, cylinder: ofRound, disk: ofRound, capsule: ofCapsule, hull: ofHull }[kind];
  return (d) => {
    const own = [0, 1, 2].map((k) => g[k] * d[0] + g[4 + k] * d[1] + g[8 + k] * d[2]);
    const p = support(own, size, AXES[axis]).map((value, k) => value + at[k]);
    return [0, 1, 2].map((k) => g[4 * k] * p[0] + g[4 * k + 1] * p[1] + g[4 * k + 2] * p[2] + g[4 * k + 3]);
  };
}

const sign = (value) => (value < 0 ? -1 : 1);

function ofBox(d, { x, y, z }) {
  return [x, y, z].map((edge, k) => (sign(d[k]) * edge) / 2);
}

function ofHull(d, { corners }) {
  return farthestOf(corners, d);
}

function ofBall(d, { radius }) {
  const norm = Math.hypot(...d) || 1;
  return d.map((part) => (radius * part) / norm);
}

function ofRound(d, { radius, length, thickness }, axis) {
  const across = Math.hypot(...d.filter((_, k) => k !== axis)) || 1;
  return d.map((part, k) => (k === axis ? (sign(part) * (length ?? thickness)) / 2 : (radius * part) / across));
}

function ofCapsule(d, { radius, length }, axis) {
  return ofBall(d, { radius }).map((part, k) => (k === axis ? part + (sign(d[axis]) * length) / 2 : part));
}
