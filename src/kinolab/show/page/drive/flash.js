// What touches lights up for as long as it does.

const GLOW = 0xd5320f, BODY_GLOW = 0x8a1500;

/** Light up bodies and obstacles; `show(pairs)` takes [body, obstacle], and says whether obstacles changed. */
export function buildFlash(bodies, surfaces) {
  const light = (materials, on, color) => [materials].flat().forEach((paint) => paint.emissive?.set(on ? color : 0));
  let before = new Set(), lit = new Set();
  return (pairs) => {
    const obstacles = new Set(pairs.map(([, obstacle]) => obstacle)), own = new Set(pairs.map(([body]) => body));
    bodies.forEach(({ spinning }, k) => { if (own.has(k) !== lit.has(k)) light(spinning.children[0].material, own.has(k), BODY_GLOW); });
    const changed = surfaces.filter((_, k) => obstacles.has(k) !== before.has(k));
    surfaces.forEach((surface, k) => light(surface.material, obstacles.has(k), GLOW));
    before = obstacles; lit = own;
    return changed.length > 0;
  };
}
