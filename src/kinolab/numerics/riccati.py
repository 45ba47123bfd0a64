"""LQR gains for time-invariant and time-varying linear systems.

Source: Anderson, Moore, Optimal Control: Linear Quadratic Methods, 1990, chapters 2 and 3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy

from kinolab.arguments import checked
from kinolab.errors import KinolabError
from kinolab.numerics.arrays import Array


class NotStabilisableError(KinolabError):
    """A linear system is not stabilisable, or its weights do not detect an unstable mode."""

    exit_code = 2


@checked
def lqr(A: Array, B: Array, Q: Array, R: Array) -> Array:
    """Return the gain K of u = -K x that minimises the integral of x^T Q x + u^T R u.

    Args:
        A: Of x_dot = A x + B u, shape (n, n), in [1/s].
        B: Shape (n, m).
        Q: Weights of the states, shape (n, n), positive semidefinite.
        R: Weights of the inputs, shape (m, m), positive definite.

    Returns:
        Gain, shape (m, n).

    Raises:
        NotStabilisableError: If there is no such gain.
    """
    P = _solution(scipy.linalg.solve_continuous_are, A, B, Q, R)
    return np.linalg.solve(R, B.T @ P)


@checked
def dlqr(A: Array, B: Array, Q: Array, R: Array) -> Array:
    """Return the gain K of u_k = -K x_k that minimises the sum of x^T Q x + u^T R u.

    Args:
        A: Of x_(k+1) = A x_k + B u_k, shape (n, n).
        B: Shape (n, m).
        Q: Weights of the states, shape (n, n), positive semidefinite.
        R: Weights of the inputs, shape (m, m), positive definite.

    Returns:
        Gain, shape (m, n).

    Raises:
        NotStabilisableError: If there is no such gain.
    """
    P = _solution(scipy.linalg.solve_discrete_are, A, B, Q, R)
    return np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A)


def _solution(solve: Callable[..., Any], *matrices: Array) -> Any:
    """Return the stabilising solution of a Riccati equation."""
    try:
        return solve(*matrices)
    except (np.linalg.LinAlgError, ValueError) as error:
        raise NotStabilisableError(f"there is no stabilising gain ({error})") from error


@checked
def tvlqr(A: Array, B: Array, Q: Array, R: Array, final: Array) -> Array:
    """Return the gains K_k of u_k = -K_k x_k along a trajectory, by the backward Riccati recursion.

    Args:
        A: Of x_(k+1) = A_k x_k + B_k u_k, shape (N, n, n).
        B: Shape (N, n, m).
        Q: Weights of the states at every step, shape (n, n).
        R: Weights of the inputs, shape (m, m), positive definite.
        final: Weights of the last state, shape (n, n).

    Returns:
        Gains, shape (N, m, n).
    """
    P, gains = final, np.empty((len(A), B.shape[2], A.shape[1]))
    for k in range(len(A) - 1, -1, -1):
        PB = P @ B[k]
        gains[k] = np.linalg.solve(R + B[k].T @ PB, PB.T @ A[k])
        P = Q + A[k].T @ P @ (A[k] - B[k] @ gains[k])
        P = (P + P.T) / 2  # rounding must not break its symmetry
    return gains
