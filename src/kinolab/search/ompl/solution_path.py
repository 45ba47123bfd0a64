"""The solution path of an OMPL planner as inputs, one row per propagation step."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.goal_connection import SteeredGoalConnection


def path_in(problem: PlanningTask, definition: Any) -> tuple[float, Array]:
    """Copy the path out of OMPL, which frees its states and controls when it is cleared.

    Returns:
        The normalised goal error at its end, infinite if there is no path, and its inputs (N, nu).
    """
    if not definition.hasSolution():
        return math.inf, np.zeros((0, problem.model.nu))
    return definition.getSolutionDifference(), inputs_of(problem, definition.getSolutionPath())


def inputs_of(problem: PlanningTask, path: Any) -> Array:
    """Return the inputs (N, nu) of a path of OMPL's."""
    nu, rows = problem.model.nu, range(path.getControlCount())
    controls = [[path.getControl(k)[i] for i in range(nu)] for k in rows]
    steps = np.rint(np.array(path.getControlDurations(), dtype=float) / problem.step).astype(int)
    return np.repeat(np.array(controls, dtype=float).reshape(-1, nu), steps, axis=0)


def with_last_step(u: Array, last_step: SteeredGoalConnection | None) -> Array:
    """Append the goal connection from the end of a path with inputs (N, nu), if there is one."""
    return np.vstack([u, *(last_step.inputs if last_step else ())])
