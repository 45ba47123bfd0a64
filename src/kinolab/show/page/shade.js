// The machine's shadow on the floor without a shadow map: its bodies pressed flat along the light.

/** Build flat copies of bodies on the plane z = 0; `show()` lays them below the bodies. */
export function buildShade(bodies, from, { low, high }) {
  const side = (x, y, constant) => new THREE.Plane(new THREE.Vector3(x, y, 0), constant);
  const clippingPlanes = [side(1, 0, -low[0]), side(-1, 0, high[0]), side(0, 1, -low[1]), side(0, -1, high[1])];
  const group = new THREE.Group(), paint = new THREE.MeshBasicMaterial({
    clippingPlanes, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -2 });
  group.matrixAutoUpdate = false;
  const [x, y] = [from.x / from.z, from.y / from.z]; // z goes to 0 along the light
  group.matrix.set(1, 0, -x, 0, 0, 1, -y, 0, 0, 0, 0, 0, 0, 0, 0, 1);
  const flat = bodies.map(({ geometry }) => {
    const mesh = new THREE.Mesh(geometry, paint);
    mesh.matrixAutoUpdate = false;
    mesh.frustumCulled = false;
    group.add(mesh);
    return mesh;
  });
  const show = () => bodies.forEach(({ spinning }, k) => {
    spinning.updateWorldMatrix(true, false);
    flat[k].matrix.copy(spinning.matrixWorld);
  });
  return { group, show, paint: (colors) => paint.color.set(colors.shade) };
}
