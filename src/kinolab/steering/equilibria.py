"""States in which a machine can stay."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.errors import SingularError
from kinolab.problem import Problem
from kinolab.steering.ignorable import ignorable

Array: TypeAlias = NDArray[np.float64]

STILL = 1e-10  # of a state's scale per second: what counts as rest
ROUNDS = 20  # of Newton's method
DRAWN_BACK = 10  # of them look for the nearest equilibrium, the others for any
SPARE = 0.98  # share of an input's range that may be used to stay


def settle(problem: Problem, x: Array) -> tuple[Array, Array] | None:
    """Return the equilibrium near a state, and the inputs that hold it; None where there is none.

    The smallest change of configuration and inputs, in units of scales and ranges, that stops all
    motion (Newton's method on f(x, u) = 0 with all velocities 0, drawn back along the equilibria
    to where it began).

    Args:
        problem: Whose machine.
        x: State near which to look, shape (nx,).
    """
    model = problem.model
    y, u = np.asarray(x, dtype=float).copy(), np.clip(np.zeros(model.nu), *model.control_bounds.T)
    y[model.speeds] = 0.0
    y = model.project(y)
    open_to_change = ~ignorable(problem)
    open_to_change[model.speeds] = False
    sizes = np.concatenate(
        [problem.scales * open_to_change, np.ptp(model.control_bounds, axis=1) / 2]
    )
    begun = np.concatenate([y, u])
    for k in range(ROUNDS):
        try:
            left = model.f(y, u) / problem.scales
        except SingularError:
            return None
        if not np.isfinite(left).all():
            return None
        if np.abs(left).max(initial=0.0) <= STILL:
            return (y, u) if _holds(problem, y, u) else None
        A, B = model.jacobian(y, u)
        rows = np.hstack([A, B]) * sizes / problem.scales[:, None]
        back = np.zeros(len(sizes))
        if k < DRAWN_BACK:
            np.divide(begun - np.concatenate([y, u]), sizes, out=back, where=sizes > 0)
        change = (back + np.linalg.lstsq(rows, -left - rows @ back, rcond=1e-10)[0]) * sizes
        y, u = y + change[: model.nx], u + change[model.nx :]
        y = model.project(y)
    return None


def _holds(problem: Problem, x: Array, u: Array) -> bool:
    """Say whether an equilibrium keeps the limits, and the inputs some of their range."""
    lower, upper = problem.model.control_bounds.T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    if (np.abs(u - middle) > SPARE * half + 1e-12).any():
        return False
    if problem.system.requirements and (problem.model.requirements(x, u) < 0).any():
        return False
    return not any(problem.limit_violations(x))
