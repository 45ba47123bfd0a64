// What stands still, drawn once and kept as colours and depths while the camera stands still too.
//
// Without a graphics processor every triangle costs time in every picture. The GIF's renderer saves
// it in the same way: only the machine is drawn anew.

export const STILL = 0; // layers of the scene
export const MOVING = 1;

const VERTEX = "varying vec2 place; void main() { place = uv; gl_Position = vec4(position.xy, 0.0, 1.0); }";
const FRAGMENT = `
uniform sampler2D colors; uniform sampler2D depths; varying vec2 place;
void main() {
  gl_FragColor = texture2D(colors, place);
  gl_FragDepth = texture2D(depths, place).r;
  #include <colorspace_fragment>
}`;

/** Draw a scene in two steps; `forget()` is called when something that stands still changed. */
export function buildBackdrop(renderer, scene, camera) {
  const kept = new THREE.WebGLRenderTarget(1, 1, { samples: 0 });
  kept.texture.colorSpace = THREE.SRGBColorSpace;
  kept.depthTexture = new THREE.DepthTexture(1, 1);
  const paint = new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT,
    uniforms: { colors: { value: kept.texture }, depths: { value: kept.depthTexture } } });
  const sheet = new THREE.Scene(), flat = new THREE.OrthographicCamera();
  const picture = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), paint);
  picture.frustumCulled = false;
  sheet.add(picture);
  let seen = "";

  const keep = (layer) => {
    const { width, height } = renderer.domElement;
    kept.setSize(width, height);
    renderer.setRenderTarget(kept);
    only(layer);
    renderer.render(scene, camera);
    renderer.setRenderTarget(null);
  };
  const only = (layer) => camera.layers.set(layer);
  const draw = () => {
    const { width, height } = renderer.domElement;
    const now = [width, height, ...camera.matrixWorld.elements, ...camera.projectionMatrix.elements].join();
    if (now !== seen) keep(STILL);
    seen = now;
    renderer.render(sheet, flat);
    const paper = scene.background;
    scene.background = null; renderer.autoClear = false;
    only(MOVING);
    renderer.render(scene, camera);
    scene.background = paper; renderer.autoClear = true;
  };
  return { draw, forget: () => { seen = ""; } };
}

/** Put an object and all that is in it on a layer. */
export function onLayer(object, layer) {
  object.traverse((part) => part.layers.set(layer));
}
