// What stands still: floor, grid, obstacles.

import { edgesOf, geometryOf } from "./meshes.js";

/** Build the world; `paint(colors)` gives it the colours of a theme. */
export function buildWorld(data, array) {
  const group = new THREE.Group();
  const wall = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
  const paints = {
    solid: new THREE.MeshLambertMaterial({ ...wall, side: THREE.DoubleSide }),
    room: new THREE.MeshLambertMaterial({ ...wall, side: THREE.FrontSide }), // one looks into it
    edge: new THREE.LineBasicMaterial({ transparent: true, opacity: 0.6 }),
    floor: new THREE.MeshLambertMaterial({ polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 4 }),
    grid: new THREE.LineBasicMaterial(),
  };
  let triangles = 0;
  for (const { mesh, room } of data.obstacles) {
    const surface = new THREE.Mesh(geometryOf(mesh, array), Array(mesh.colors.length).fill(room ? paints.room : paints.solid));
    surface.castShadow = !room;
    surface.receiveShadow = true;
    const edges = new THREE.LineSegments(edgesOf(mesh, array), paints.edge);
    edges.visible = !room; // the far edges of a room would shine through its near walls
    group.add(surface, edges);
    triangles += mesh.faces.count / 3;
  }
  if (data.floor) group.add(...buildFloor(data.floor, paints));
  const paint = (colors) => {
    paints.solid.color.set(colors.wall); paints.room.color.set(colors.wall);
    paints.edge.color.set(colors.wallEdge);
    paints.floor.color.set(colors.floor); paints.grid.color.set(colors.grid);
  };
  return { group, triangles, paint };
}

function buildFloor([low, high], paints) {
  const plane = new THREE.Mesh(new THREE.PlaneGeometry(high[0] - low[0], high[1] - low[1]), paints.floor);
  plane.position.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0);
  plane.receiveShadow = true;
  return [plane, new THREE.LineSegments(gridOn(low, high), paints.grid)];
}

/** Lines at round distances: at most 24 of them along the longer side. */
function gridOn(low, high) {
  const step = spacing(Math.max(high[0] - low[0], high[1] - low[1]) / 12), points = [];
  for (let x = Math.ceil(low[0] / step) * step; x <= high[0]; x += step) points.push(x, low[1], 0, x, high[1], 0);
  for (let y = Math.ceil(low[1] / step) * step; y <= high[1]; y += step) points.push(low[0], y, 0, high[0], y, 0);
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
  return geometry;
}

/** The largest of 1, 2, 5, 10, … that is no more than a length. */
export function spacing(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  return [5, 2, 1].map((factor) => factor * power).find((step) => step <= length * (1 + 1e-9));
}
