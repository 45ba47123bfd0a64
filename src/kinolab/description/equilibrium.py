"""States in which a machine can stay, and the inputs that hold it there."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import Model
from kinolab.errors import SingularError

Array = NDArray[np.float64]

STILL = 1e-9  # of a state's scale per second: what counts as rest
ROUNDS = 50  # of Newton's method
CLOSINGS = 20  # steps towards a configuration in which loops close


def equilibrium(model: Model, starts: Iterable[Array]) -> tuple[Array, Array] | None:
    """Return a state in which the machine stays and the inputs that hold it, or None.

    Args:
        model: The machine.
        starts: States to begin from, each of shape (nx,); the first that leads to one counts.

    Returns:
        x of shape (nx,) and u of shape (nu,), within the limits of the inputs.
    """
    found = (_equilibrium_near(model, x) for x in starts)
    return next((pair for pair in found if pair is not None), None)


def _equilibrium_near(model: Model, x: Array) -> tuple[Array, Array] | None:
    """Follow Newton's method on f(x, u) = 0, all velocities 0, by steps of least change in units of
    scales and ranges."""
    scales, half = model.state_scales, np.ptp(model.control_bounds, axis=1) / 2
    lower, upper = model.control_bounds.T
    movable = scales.copy()
    movable[model.speeds] = 0.0
    sizes = np.concatenate([movable, half])
    x, u = x.copy(), np.clip(np.zeros(model.nu), lower, upper)
    x[model.speeds] = 0.0
    for _ in range(CLOSINGS):
        x = model.project(x)
    motion = np.inf
    for _ in range(ROUNDS):
        try:
            left = model.f(x, u) / scales
        except SingularError:
            return None
        if not np.isfinite(left).all():
            return None
        before, motion = motion, float(np.abs(left).max(initial=0.0))
        if motion <= STILL and motion >= before / 2:  # as still as rounding lets it be
            inside = (lower - 1e-9 <= u).all() and (u <= upper + 1e-9).all()
            return (x, u) if inside else None
        rows = np.hstack(model.jacobian(x, u)) * sizes / scales[:, None]
        change = np.linalg.lstsq(rows, -left, rcond=1e-10)[0] * sizes
        x, u = model.project(x + change[: model.nx]), u + change[model.nx :]
    return None
