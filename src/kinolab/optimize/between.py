"""From one state of a motion to another one, as a problem of its own.

Systems do not depend on time, so that a piece of a motion may be replaced by any other one between
the same two states. What nothing depends on, such as how far wheels have rolled, need not be met.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.goal import AttitudeTarget, Goal
from kinolab.problem import Problem
from kinolab.steering.ignorable import ignorable

Array: TypeAlias = NDArray[np.float64]

MET = 1e-6  # of a scale: how far from a state a piece may end; the rest of a motion starts there


def between(problem: Problem, begin: Array, end: Array) -> Problem:
    """Return the problem of moving from one state to another, among the same obstacles.

    Args:
        problem: With the machine, its world and its limits.
        begin: Shape (nx,).
        end: Shape (nx,).
    """
    turned = problem.model.attitudes
    own = [k for first in turned.values() for k in range(first, first + 4)]
    matters = ~ignorable(problem)
    matters[own] = False
    met = tuple(np.flatnonzero(matters).tolist())
    attitudes = tuple(
        AttitudeTarget(name, first, tuple(end[first : first + 4].tolist()), MET)
        for name, first in turned.items()
    )
    near = MET * problem.scales[list(met)]
    goal = Goal(met, end[list(met)], near, problem.circular[list(met)], attitudes=attitudes)
    return replace(problem, start=begin, goal=goal)


def straight(problem: Problem, begin: Array, end: Array) -> Array:
    """Return the straight way between two states, shape (2, nx), by the shorter way round."""
    way = np.stack([begin, end])
    ways_round = problem.circular
    way[1, ways_round] -= 2 * np.pi * np.round((way[1] - way[0])[ways_round] / (2 * np.pi))
    alike = ignorable(problem)
    way[1, alike] = begin[alike]
    for first in problem.model.attitudes.values():
        own = slice(first, first + 4)
        way[1, own] *= 1.0 if begin[own] @ end[own] >= 0 else -1.0
    return way
