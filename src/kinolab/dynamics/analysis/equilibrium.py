"""Equilibria near a state: f(x, u) = 0 with all velocities 0."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.model.model import Model
from kinolab.errors import SingularError
from kinolab.numerics.arrays import Array


def equilibrium(
    model: Model,
    near: Array,
    *,
    scales: Array | None = None,
    movable: NDArray[np.bool_] | None = None,
    rounds: int = 50,  # at most, of Newton's method
    drawn_back: int = 0,
    polish: bool = False,
) -> tuple[Array, Array] | None:
    """Return an equilibrium near a state, x of shape (nx,) and u of shape (nu,), or None.

    Newton's method with least-norm steps of configuration and inputs, in units of scales and of
    half the inputs' ranges. Limits are ignored.

    Args:
        near: Initial guess, shape (nx,); starts from zero velocities and inputs near 0.
        scales: Characteristic magnitude of each state entry, shape (nx,).
        movable: Which state entries may change, shape (nx,); velocities never do.
        rounds: Largest number of Newton steps.
        drawn_back: Number of initial steps pulled back, within the linearised solution set, towards
            the initial guess, to find the nearest equilibrium; later steps are not.
        polish: Whether to iterate until the residual stops decreasing.

    Source: Deuflhard, Newton Methods for Nonlinear Problems, 2004, section 4.4 (underdetermined
    systems).
    """
    nx, scales = model.nx, model.state_scales if scales is None else scales
    free = np.ones(nx, dtype=bool) if movable is None else movable.copy()
    free[model.speeds] = False
    sizes = np.concatenate([scales * free, np.ptp(model.control_bounds, axis=1) / 2])
    z = _beginning(model, near)
    begun, motion = z, np.inf
    for k in range(rounds):
        x, u = z[:nx], z[nx:]
        try:
            left = model.f(x, u) / scales
            left[model.clocks] = 0.0
        except SingularError:
            return None
        if not np.isfinite(left).all():
            return None
        before, motion = motion, float(np.abs(left).max(initial=0.0))
        # 1e-10 of a state's scale per second
        if motion <= 1e-10 and (motion >= before / 2 or not polish):
            return x, u
        rows = np.hstack(model.jacobian(x, u)) * sizes / scales[:, None]
        back = np.zeros(len(sizes))
        if k < drawn_back:
            np.divide(begun - z, sizes, out=back, where=sizes > 0)
        change = (back + np.linalg.lstsq(rows, -left - rows @ back, rcond=1e-10)[0]) * sizes
        z = np.concatenate([model.project(x + change[:nx]), u + change[nx:]])
    return None


def _beginning(model: Model, near: Array) -> Array:
    """Return a state at rest with closed loops, and the inputs nearest to 0 within limits."""
    x = np.array(near, dtype=float)
    x[model.speeds] = 0.0
    for _ in range(20 if model.projects else 0):  # at most, towards loop closure
        before, x = x, model.project(x)
        if (x == before).all():
            break
    return np.concatenate([x, model.null_control()])
