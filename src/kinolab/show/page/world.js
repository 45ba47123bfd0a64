// What stands still: floor with its marks, obstacles in their colours.

import { edgesOf, geometryOf } from "./meshes.js";

const EDGE = 0.58; // of the colour of faces: how bright their edges are
const VEIL = 0.16; // opacity of walls that hide the way

/** Build the world; `paint(colors)` gives it the brightness of a theme. */
export function buildWorld(data, array) {
  const group = new THREE.Group(), painted = []; // {material, rgb}: what a theme makes brighter or darker
  const kept = (material, rgb) => { painted.push({ material, rgb }); return material; };
  const surfaces = [];
  let triangles = 0;
  for (const { mesh, room, veiled } of data.obstacles) {
    const side = room ? THREE.FrontSide : THREE.DoubleSide; // one looks into a room
    const paints = mesh.colors.map(({ rgb }) => kept(new THREE.MeshLambertMaterial({ ...SET_BACK, side, ...(veiled ? SEEN_THROUGH : {}) }), rgb));
    const surface = new THREE.Mesh(geometryOf(mesh, array), paints);
    surface.castShadow = !room && !veiled;
    surface.receiveShadow = true;
    const first = mesh.colors[0]?.rgb ?? [1, 1, 1];
    const ink = kept(new THREE.LineBasicMaterial({ transparent: true, opacity: veiled ? 0.35 : 0.6 }), first.map((part) => EDGE * part));
    const edges = new THREE.LineSegments(edgesOf(mesh, array), ink);
    edges.visible = !room; // the far edges of a room would shine through its near walls
    group.add(surface, edges);
    surfaces.push(surface);
    triangles += mesh.faces.count / 3;
  }
  const floor = data.floor && buildFloor(data, array, kept);
  if (floor) group.add(...floor.parts);
  const paint = (colors) => {
    painted.forEach(({ material, rgb }) => material.color.setRGB(...rgb.map((part) => colors.world * part), "srgb"));
    if (floor && data.setting.name === "studio") {
      floor.ground.color.set(colors.floor); floor.lines.color.set(colors.grid);
    }
  };
  return { group, surfaces, triangles, paint };
}

const SET_BACK = { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 };
const SEEN_THROUGH = { transparent: true, opacity: VEIL, depthWrite: false };

function buildFloor({ floor, setting }, array, kept) {
  const { low, high, areas } = floor;
  const ground = kept(new THREE.MeshLambertMaterial({ polygonOffset: true, polygonOffsetFactor: 4, polygonOffsetUnits: 16 }), setting.floor);
  const lines = kept(new THREE.LineBasicMaterial(), setting.lines);
  const plane = new THREE.Mesh(new THREE.PlaneGeometry(high[0] - low[0], high[1] - low[1]), ground);
  plane.position.set((low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0);
  plane.receiveShadow = true;
  const points = new THREE.BufferGeometry();
  points.setAttribute("position", new THREE.BufferAttribute(array(floor.lines), 3));
  const parts = [plane, new THREE.LineSegments(points, lines)];
  if (areas) {
    const marks = areas.colors.map(({ rgb }) => kept(new THREE.MeshLambertMaterial({ polygonOffset: true, polygonOffsetFactor: 3, polygonOffsetUnits: 8 }), rgb));
    const painted = new THREE.Mesh(geometryOf(areas, array), marks);
    painted.receiveShadow = true;
    parts.push(painted);
  }
  return { parts, ground, lines };
}
