// Small linear systems.

// Factors the n by n matrix A in place by elimination with row pivoting.
// Source: Golub, Van Loan, Matrix Computations, 4th ed., algorithm 3.4.1.
function luFactor(A, pivots, n) {
  let status = 0;
  for (let k = 0; k < n; k++) {
    let row = k;
    for (let i = k + 1; i < n; i++) {
      if (Math.abs(A[i * n + k]) > Math.abs(A[row * n + k])) row = i;
    }
    pivots[k] = row;
    if (!(Math.abs(A[row * n + k]) > 1e-300)) status = SINGULAR;
    for (let j = 0; j < n; j++) {
      const kept = A[k * n + j];
      A[k * n + j] = A[row * n + j];
      A[row * n + j] = kept;
    }
    for (let i = k + 1; i < n; i++) {
      const factor = A[i * n + k] / A[k * n + k];
      A[i * n + k] = factor;
      for (let j = k + 1; j < n; j++) A[i * n + j] -= factor * A[k * n + j];
    }
  }
  return status;
}

// Solves in place with the factors of luFactor.
function luSolve(A, pivots, n, b) {
  for (let k = 0; k < n; k++) {
    const kept = b[k];
    b[k] = b[pivots[k]];
    b[pivots[k]] = kept;
  }
  for (let k = 0; k < n; k++) {
    for (let i = k + 1; i < n; i++) b[i] -= A[i * n + k] * b[k];
  }
  for (let k = n - 1; k >= 0; k--) {
    b[k] /= A[k * n + k];
    for (let i = 0; i < k; i++) b[i] -= A[i * n + k] * b[k];
  }
}
