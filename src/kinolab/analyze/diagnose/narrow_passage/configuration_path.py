"""Geometric paths between configurations, without dynamics, by OMPL's RRT-Connect.

Source: Kuffner, LaValle, RRT-Connect, ICRA 2000.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from kinolab.analyze.diagnose.narrow_passage.free_space import FreeSpace
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.ompl.spaces import StateCodec


class Configurations(StateCodec):
    """Space of all coordinates that move the machine; the others stay as at the start.

    Args:
        problem: The machine and its limits.
        reach: Displacement of the machine per unit of each coordinate, in [m], shape (nx,).
        resolution: Motion between two collision checks, in [m].
    """

    def __init__(self, problem: PlanningTask, reach: Array, resolution: float) -> None:
        entries = [int(i) for i in np.flatnonzero(reach)]
        super().__init__(replace(problem, weights=reach), entries)
        for k in range(self.space.getSubspaceCount()):
            part = self.space.getSubspace(k)
            extent = self.space.getSubspaceWeight(k) * part.getMaximumExtent()
            part.setLongestValidSegmentFraction(min(max(resolution / extent, 1e-6), 0.5))


class SearchEffort:
    """Budget of a path search: collision checks and seconds of this thread's processor time."""

    def __init__(self, checks: int, seconds: float) -> None:
        self._left, self._end = checks, time.thread_time() + seconds

    def count(self) -> bool:
        """Count a collision check; False once there have been too many."""
        self._left -= 1
        return self._left >= 0

    def spent(self) -> bool:
        """Return whether the search must end."""
        return self._left <= 0 or time.thread_time() > self._end


def find_path(
    space: Configurations,
    shape: FreeSpace,
    begin: Sequence[float],
    ends: Sequence[Sequence[float]],
    effort: SearchEffort,
    seed: int,
) -> Array | None:
    """Return states along a collision-free path, shape (n, nx); None if none was found in time.

    Args:
        space: The configuration space.
    """
    information = ob.SpaceInformation(space.space)

    def is_valid(state: Any) -> bool:
        return effort.count() and shape.free(space.read(state))

    information.setStateValidityChecker(is_valid)
    information.setup()
    definition = ob.ProblemDefinition(information)
    definition.addStartState(_state(space, begin))
    goal = ob.GoalStates(information)
    for end in ends:
        goal.addState(_state(space, end))
    definition.setGoal(goal)
    ou.RNG.setSeed(seed)
    planner = og.RRTConnect(information)
    planner.setProblemDefinition(definition)
    planner.setup()
    planner.solve(ob.PlannerTerminationCondition(effort.spent))
    if not definition.hasExactSolution():
        return None
    path = definition.getSolutionPath()
    simplifier = og.PathSimplifier(information)
    simplifier.reduceVertices(path)
    simplifier.partialShortcutPath(path)
    path.interpolate()
    return np.array([space.read(path.getState(k)) for k in range(path.getStateCount())])


def _state(space: Configurations, values: Sequence[float]) -> Any:
    state = space.space.allocState()
    space.write(state, values)
    return state
