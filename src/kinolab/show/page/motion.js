// Where everything is at a time: cubics between keys, as kinolab computed them from the plan.

/** Read a curve; `width` numbers belong to each key. */
export function curve(data, array, width) {
  const { times, values, arriving, leaving } = data;
  return { times: array(times), values: array(values), arriving: array(arriving),
           leaving: array(leaving), width, row: 0 };
}

/** Return the index of the last key at or before a time, at most the one before the last key. */
export function rowAt(times, t) {
  let low = 0, high = times.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  return low;
}

/** Write a curve's values at a time into `out`; before its first and after its last key it rests. */
export function valueAt(curve, t, out) {
  const { times, values, arriving, leaving, width } = curve;
  if (times.length === 1) { for (let i = 0; i < width; i++) out[i] = values[i]; return out; }
  const row = rowAt(times, t), step = times[row + 1] - times[row];
  const s = Math.min(Math.max((t - times[row]) / step, 0), 1), r = 1 - s;
  const begin = (1 + 2 * s) * r * r, out_ = s * r * r * step;
  const end = s * s * (3 - 2 * s), into = -s * s * r * step;
  for (let i = 0, a = row * width, b = a + width; i < width; i++, a++, b++)
    out[i] = begin * values[a] + out_ * leaving[a] + end * values[b] + into * arriving[b];
  return out;
}

/** Divide a quaternion by its norm. */
function normalised(q) {
  const norm = Math.hypot(q[0], q[1], q[2], q[3]);
  for (let i = 0; i < 4; i++) q[i] /= norm;
  return q;
}

/** Read the motion: `place(body, t)`, `turn(body, t)`, `ends(t)` and `frame(body, t)`. */
export function motion(data, array) {
  const places = data.places.map((entry) => curve(entry, array, 3));
  const turns = data.turns.map((entry) => curve(entry, array, 4));
  const cables = data.ends && curve(data.ends, array, data.ends.values.count / data.ends.times.count);
  const all = [...places, ...turns, ...(cables ? [cables] : [])];
  const first = Math.min(...all.map(({ times }) => times[0]));
  const last = Math.max(...all.map(({ times }) => times[times.length - 1]));
  const place = (body, t) => valueAt(places[body], t, [0, 0, 0]);
  const turn = (body, t) => normalised(valueAt(turns[body], t, [0, 0, 0, 0]));
  return {
    first, last, bodies: places.length, place, turn,
    ends: (t) => (cables ? valueAt(cables, t, new Float32Array(cables.width)) : null),
    frame: (body, t) => frameOf(turn(body, t), place(body, t)),
  };
}

/** Return the 4 x 4 frame of a unit quaternion and a place, row by row. */
export function frameOf([x, y, z, w], [px, py, pz]) {
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), px],
    [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), py],
    [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), pz],
    [0, 0, 0, 1],
  ];
}
