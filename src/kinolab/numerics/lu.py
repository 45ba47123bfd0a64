"""LU factorisation with row pivoting, for the small matrices inside compiled loops.

Source: Golub, Van Loan, Matrix Computations, 4th ed., algorithm 3.4.1.
"""

from __future__ import annotations

from kinolab.numerics.jit import kernel


@kernel
def factor(A, pivots):  # type: ignore[no-untyped-def]
    """Factor a matrix in place with row pivoting; 0 if it is regular."""
    n, failed = A.shape[0], 0
    for k in range(n):
        row = k
        for i in range(k, n):
            if abs(A[i, k]) > abs(A[row, k]):
                row = i
        pivots[k] = row
        # 1e-300: the compiled step calls smaller pivots singular, too
        failed |= 0 if abs(A[row, k]) > 1e-300 else 1
        for j in range(n):
            A[k, j], A[row, j] = A[row, j], A[k, j]
        for i in range(k + 1, n):
            A[i, k] /= A[k, k]
            for j in range(k + 1, n):
                A[i, j] -= A[i, k] * A[k, j]
    return failed


@kernel
def substitute(A, pivots, b):  # type: ignore[no-untyped-def]
    """Replace b by the solution z of A z = b, of which A holds the factors."""
    n = b.shape[0]
    for k in range(n):
        row = int(pivots[k])
        b[k], b[row] = b[row], b[k]
    for k in range(n):
        for i in range(k + 1, n):
            b[i] -= A[i, k] * b[k]
    for k in range(n - 1, -1, -1):
        b[k] /= A[k, k]
        for i in range(k):
            b[i] -= A[i, k] * b[k]
