"""The nearest equilibrium to a state, within limits."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics.analysis.equilibrium import equilibrium
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.cyclic_coordinates import cyclic_coordinates


def nearest_equilibrium(problem: PlanningTask, x: Array) -> tuple[Array, Array] | None:
    """Return the equilibrium (nx,) near a state and its inputs (nu,); None if there is none.

    It satisfies the problem's limits and requirements and keeps the inputs off their bounds.

    Args:
        x: State, shape (nx,).
    """
    found = equilibrium(
        problem.model,
        x,
        scales=problem.scales,
        movable=~cyclic_coordinates(problem),
        rounds=20,  # of Newton's method
        drawn_back=10,  # of these project towards the nearest equilibrium, the others find any
    )
    return found if found is not None and _holds(problem, *found) else None


def _holds(problem: PlanningTask, x: Array, u: Array) -> bool:
    """Say whether an equilibrium satisfies the limits, with an input margin."""
    lower, upper = problem.model.control_bounds.T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    # 0.98: fraction of an input's range available to hold an equilibrium
    if (np.abs(u - middle) > 0.98 * half + 1e-12).any():
        return False
    if problem.machine.requirements and (problem.model.requirements(x, u) < 0).any():
        return False
    return not any(problem.limit_violations(x))
