"""From one state of a motion to another one, as a problem of its own.

Systems do not depend on time, so that a piece of a motion may be replaced by any other one between
the same two states. What nothing depends on, such as how far wheels have rolled, need not be met.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.problem.goal import AttitudeTarget, Goal
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajopt.options import SHORT

Array: TypeAlias = NDArray[np.float64]


def segment_problem(problem: Problem, begin: Array, end: Array) -> Problem:
    """Return the problem of moving from one state to another, among the same obstacles.

    Args:
        problem: With the machine, its world and its limits.
        begin: Shape (nx,).
        end: Shape (nx,).
    """
    model, matters = problem.model, ~cyclic_coordinates(problem)
    for own in model.space.quaternions:
        matters[own] = False
    met = tuple(np.flatnonzero(matters).tolist())
    attitudes = tuple(
        AttitudeTarget(name, own.start, tuple(end[own].tolist()), SHORT.end_tolerance)
        for name, own in zip(model.attitudes, model.space.quaternions, strict=True)
    )
    near = SHORT.end_tolerance * problem.scales[list(met)]
    goal = Goal(met, end[list(met)], near, problem.circular[list(met)], attitudes=attitudes)
    return replace(problem, start=begin, goal=goal)


def straight(problem: Problem, begin: Array, end: Array) -> Array:
    """Return the straight way between two states, shape (2, nx), by the shorter way round."""
    near = problem.space.nearest(begin, end)
    return np.stack([begin, np.where(cyclic_coordinates(problem), begin, near)])
