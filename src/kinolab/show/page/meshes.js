// Surfaces with smooth rounds and sharp creases, in several colours, and their inked edges.

const CREASE = Math.cos((35 * Math.PI) / 180); // as the GIF's renderer draws it
const SAME = 0.99995; // cosine between normals that are one

/** Return a geometry with a group per colour, from the pack's mesh. */
export function geometryOf(mesh, array) {
  const points = array(mesh.vertices), faces = array(mesh.faces);
  const { origin, normals, index } = creased(points, faces);
  const places = new Float32Array(3 * origin.length);
  origin.forEach((v, k) => places.set(points.subarray(3 * v, 3 * v + 3), 3 * k));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(Float32Array.from(normals), 3));
  geometry.setIndex(new THREE.BufferAttribute(index, 1));
  mesh.colors.forEach(({ first, count }, k) => geometry.addGroup(3 * first, 3 * count, k));
  return geometry;
}

/** Return the edges that a draughtsman would ink, as pairs of points. */
export function edgesOf(mesh, array) {
  const points = array(mesh.vertices), edges = array(mesh.edges);
  const ends = new Float32Array(3 * edges.length);
  for (let i = 0; i < edges.length; i++)
    for (let k = 0; k < 3; k++) ends[3 * i + k] = points[3 * edges[i] + k];
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(ends, 3));
  return geometry;
}

/**
 * Split vertices where the surface folds: a corner's normal is the mean of those faces around its
 * vertex that bend little. Returns new vertices, each with its `origin`, their normals, and faces.
 */
function creased(points, faces) {
  const { normals, areas } = facing(points, faces), { begins, around } = neighbours(faces, points.length / 3);
  const origin = [], made = [], index = new Uint32Array(faces.length);
  const last = new Int32Array(points.length / 3).fill(-1), before = []; // new vertices of an old one
  for (let corner = 0; corner < faces.length; corner++) {
    const own = 3 * Math.floor(corner / 3), v = faces[corner];
    let x = 0, y = 0, z = 0;
    for (let k = begins[v]; k < begins[v + 1]; k++) {
      const f = 3 * around[k], area = areas[around[k]];
      const bend = normals[own] * normals[f] + normals[own + 1] * normals[f + 1] + normals[own + 2] * normals[f + 2];
      if (bend < CREASE) continue;
      x += area * normals[f]; y += area * normals[f + 1]; z += area * normals[f + 2];
    }
    const norm = Math.hypot(x, y, z) || 1;
    x /= norm; y /= norm; z /= norm;
    let vertex = last[v];
    while (vertex >= 0 && made[3 * vertex] * x + made[3 * vertex + 1] * y + made[3 * vertex + 2] * z < SAME) vertex = before[vertex];
    if (vertex < 0) {
      vertex = origin.push(v) - 1;
      made.push(x, y, z);
      before.push(last[v]);
      last[v] = vertex;
    }
    index[corner] = vertex;
  }
  return { origin, normals: made, index };
}

/** Return the unit normal and the area of every face. */
function facing(points, faces) {
  const count = faces.length / 3, normals = new Float32Array(3 * count), areas = new Float32Array(count);
  for (let f = 0; f < count; f++) {
    const a = 3 * faces[3 * f], b = 3 * faces[3 * f + 1], c = 3 * faces[3 * f + 2];
    const bx = points[b] - points[a], by = points[b + 1] - points[a + 1], bz = points[b + 2] - points[a + 2];
    const cx = points[c] - points[a], cy = points[c + 1] - points[a + 1], cz = points[c + 2] - points[a + 2];
    const x = by * cz - bz * cy, y = bz * cx - bx * cz, z = bx * cy - by * cx;
    const norm = Math.hypot(x, y, z);
    areas[f] = norm / 2;
    normals[3 * f] = x / (norm || 1); normals[3 * f + 1] = y / (norm || 1); normals[3 * f + 2] = z / (norm || 1);
  }
  return { normals, areas };
}

/** Return the faces around every vertex: those of v are around[begins[v]] to around[begins[v + 1] - 1]. */
function neighbours(faces, vertices) {
  const begins = new Uint32Array(vertices + 1), around = new Uint32Array(faces.length);
  for (const v of faces) begins[v + 1]++;
  for (let v = 0; v < vertices; v++) begins[v + 1] += begins[v];
  const next = begins.slice(0, vertices);
  for (let corner = 0; corner < faces.length; corner++) around[next[faces[corner]]++] = Math.floor(corner / 3);
  return { begins, around };
}
