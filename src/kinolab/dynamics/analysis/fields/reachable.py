"""The states that a linear system x_dot = A x + B u gets to from 0."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.analysis.jets.ranks import RANK_TOLERANCE

Array = NDArray[np.float64]


def reachable_subspace(A: Array, B: Array, tolerance: float = RANK_TOLERANCE) -> Array:
    """Return an orthonormal basis of the span of B, A B, A^2 B, …

    One block at a time is made orthogonal to those before it, so that no power of A is formed
    (Kalman's matrix itself loses its digits for ten states).

    Args:
        A: Shape (n, n).
        B: Shape (n, m).
        tolerance: Share of the size of A, or of B, below which a direction counts as none.

    Returns:
        Shape (n, rank).

    Source: Rosenbrock, State-space and Multivariable Theory, 1970 (the staircase); Paige,
    Properties of numerical algorithms related to computing controllability, IEEE Trans. Automatic
    Control 26(1), 1981.
    """
    A, B = np.asarray(A, dtype=float), np.asarray(B, dtype=float)
    size = np.abs(B).max(axis=0, initial=0.0)
    basis = np.empty((len(A), 0))
    block = B[:, size > 0] / size[size > 0]
    largest = 1.0
    while block.size:
        block = block - basis @ (basis.T @ block)
        block = block - basis @ (basis.T @ block)  # once more, for what rounding left
        left, values, _ = np.linalg.svd(block, full_matrices=False)
        fresh = left[:, values > tolerance * largest]
        basis = np.hstack([basis, fresh])
        block, largest = A @ fresh, max(float(np.linalg.norm(A, 2)), 1e-300)
    return basis
