"""States in which a machine can stay."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics.analysis.equilibrium import equilibrium
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.cyclic_coordinates import cyclic_coordinates

NEWTON_STEPS = 20  # of Newton's method
PROJECTED_STEPS = 10  # of them look for the nearest equilibrium, the others for any
INPUT_FRACTION = 0.98  # share of an input's range that may be used to stay


def nearest_equilibrium(problem: PlanningTask, x: Array) -> tuple[Array, Array] | None:
    """Return the equilibrium near a state, and the inputs that hold it; None where there is none.

    It keeps the problem's limits and requirements, and the inputs some of their range.

    Args:
        problem: Whose machine.
        x: State near which to look, shape (nx,).
    """
    found = equilibrium(
        problem.model,
        x,
        scales=problem.scales,
        movable=~cyclic_coordinates(problem),
        rounds=NEWTON_STEPS,
        drawn_back=PROJECTED_STEPS,
    )
    return found if found is not None and _holds(problem, *found) else None


def _holds(problem: PlanningTask, x: Array, u: Array) -> bool:
    """Say whether an equilibrium keeps the limits, and the inputs some of their range."""
    lower, upper = problem.model.control_bounds.T
    middle, half = (lower + upper) / 2, (upper - lower) / 2
    if (np.abs(u - middle) > INPUT_FRACTION * half + 1e-12).any():
        return False
    if problem.system.requirements and (problem.model.requirements(x, u) < 0).any():
        return False
    return not any(problem.limit_violations(x))
