// What emitted functions call, and vectors.

const SINGULAR = 1, NOT_FINITE = 2; // bits of a status; 0 is success

class SingularError extends Error {}

// The larger of two; of a number and NaN the number.
function fmax(a, b) {
  return a > b || b !== b ? a : b;
}

function sign(value) {
  return (value > 0) - (value < 0);
}

function finite(values, size) {
  let total = 0;
  for (let i = 0; i < size; i++) total += values[i] * 0;
  return total === 0 ? 0 : NOT_FINITE;
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
