// What is behind everything: one colour, or a sky from its upper edge to its foot.

const VERTEX = "varying float high; void main() { high = 0.5 + 0.5 * position.y; gl_Position = vec4(position.xy, 1.0, 1.0); }";
const FRAGMENT = `
uniform vec3 top; uniform vec3 foot; varying float high;
void main() {
  gl_FragColor = vec4(mix(foot, top, high), 1.0);
  #include <colorspace_fragment>
}`;
const DIM = 0.42; // of a bright sky on a dark page

/** Build the sky of a setting {sky, dark}; `paint(dark)` gives it the brightness of a theme. */
export function buildSky({ sky, dark: black }) {
  const colors = { top: { value: new THREE.Vector3() }, foot: { value: new THREE.Vector3() } };
  const paint = new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms: colors,
    depthTest: false, depthWrite: false });
  const sheet = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), paint);
  sheet.frustumCulled = false;
  sheet.renderOrder = -1;
  return { sheet, paint: (dark) => ["top", "foot"].forEach((edge, k) => {
    const { r, g, b } = new THREE.Color().setRGB(...sky[k].map((part) => (dark && !black ? DIM : 1) * part), "srgb");
    colors[edge].value.set(r, g, b);
  }) };
}
