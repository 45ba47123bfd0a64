// Boxes, balls, cylinders, capsules, disks and hulls as surfaces.

const SIDES = 32, RINGS = 8;

/** Return the surface of a shape {kind, axis, size, at} of a machine, in its body's frame. */
export function solid({ kind, axis, size, at }) {
  const surface = { box: () => box(size), hull: () => ({ points: size.corners, faces: size.faces }) };
  const { points, faces } = (surface[kind] ?? (() => turned(profileOf(kind, size), axis)))();
  const places = new Float32Array(points.flatMap((point) => point.map((value, k) => value + at[k])));
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
  geometry.setIndex(faces);
  const flat = geometry.toNonIndexed(); // every face with a normal of its own
  flat.computeVertexNormals();
  return flat;
}

function box({ x, y, z }) {
  const points = [];
  for (let k = 0; k < 8; k++) points.push([k & 1 ? x / 2 : -x / 2, k & 2 ? y / 2 : -y / 2, k & 4 ? z / 2 : -z / 2]);
  const sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
  return { points, faces: sides.flatMap(([a, b, c, d]) => [a, b, c, a, c, d]) };
}

/** Points (radius, height) from one end of the axis to the other. */
function profileOf(kind, { radius, length, thickness }) {
  const half = (length ?? thickness ?? 0) / 2;
  if (kind === "cylinder" || kind === "disk") return [[0, -half], [radius, -half], [radius, half], [0, half]];
  const bow = (from, offset) => [...Array(RINGS + 1).keys()].map((k) => {
    const angle = from + (Math.PI / 2) * (k / RINGS);
    return [radius * Math.cos(angle), offset + radius * Math.sin(angle)];
  });
  return [...bow(-Math.PI / 2, -half), ...bow(0, half)];
}

/** Turn a profile about an axis. */
export function turned(profile, axis) {
  const points = [], faces = [], order = { x: [2, 0, 1], y: [1, 2, 0], z: [0, 1, 2] }[axis];
  for (const [radius, height] of profile)
    for (let k = 0; k < SIDES; k++) {
      const angle = (2 * Math.PI * k) / SIDES;
      const point = [radius * Math.cos(angle), radius * Math.sin(angle), height];
      points.push(order.map((i) => point[i]));
    }
  for (let ring = 0; ring + 1 < profile.length; ring++)
    for (let k = 0; k < SIDES; k++) {
      const a = ring * SIDES + k, b = ring * SIDES + ((k + 1) % SIDES);
      faces.push(a, b, b + SIDES, a, b + SIDES, a + SIDES);
    }
  return { points, faces };
}
