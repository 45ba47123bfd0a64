// Arrays of numbers out of the page's pack: base64 of gzip, each found by where it begins.

const TYPES = { f4: Float32Array, f8: Float64Array, u2: Uint16Array, u4: Uint32Array };

/** Return a function that gives the typed array at a place {at, count, type}. */
export async function unpacked(text) {
  const packed = Uint8Array.from(atob(text.trim()), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const buffer = await new Response(stream).arrayBuffer();
  return ({ at, count, type }) => new TYPES[type](buffer, at, count);
}
