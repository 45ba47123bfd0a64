"""OMPL's PRM over the configurations of a machine."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from ompl import base as ob
from ompl import geometric as og
from ompl import util as ou

from kinolab.bridge.configurations import Configurations, Ways
from kinolab.bridge.search import ompl_seed
from kinolab.search import Budget

Array: TypeAlias = NDArray[np.float64]

MOMENT = 0.2  # [s] for a question, which takes OMPL a millisecond where there is an answer


class GeometricRoadmap:
    """OMPL's probabilistic roadmap between a start and a goal.

    OMPL looks for solutions in a thread of its own while its roadmap grows, so that equal seeds
    would give different paths. Here it grows first, and is asked while no sample counts as valid.

    Args:
        configurations: Where the machine can stay.
        start: Where to begin, shape (nx,).
        goal: Where to end, shape (nx,).
        seed: Of OMPL's random numbers.
        neighbours: Configurations that each is joined to.
    """

    def __init__(
        self, configurations: Configurations, start: Array, goal: Array, seed: int, neighbours: int
    ) -> None:
        self._configurations = configurations
        self._growing = _Switch(configurations, start, goal)
        information = ob.SpaceInformation(configurations.space)
        information.setStateValidityChecker(self._growing.is_valid)
        information.setMotionValidator(Ways(information, configurations))
        information.setup()
        definition = ob.ProblemDefinition(information)
        begin, end = configurations.space.allocState(), configurations.space.allocState()
        configurations.write(begin, start)
        configurations.write(end, goal)
        definition.setStartAndGoalStates(begin, end)
        ou.RNG.setSeed(ompl_seed(seed))
        self._planner, self._definition = og.PRM(information), definition
        self._planner.setMaxNearestNeighbors(neighbours)
        self._planner.setProblemDefinition(definition)
        self._planner.setup()

    @property
    def size(self) -> int:
        """Number of configurations in the roadmap."""
        return int(self._planner.milestoneCount())

    def grow(self, count: int, budget: Budget) -> None:
        """Add some configurations."""
        end = self.size + count
        condition = ob.PlannerTerminationCondition(lambda: self.size >= end or budget.spent())
        self._planner.growRoadmapPtc(condition)

    def path(self) -> list[Array] | None:
        """Return states at rest from start to goal; None where the roadmap does not lead there."""
        self._growing.on = False
        try:
            self._planner.solve(ob.timedPlannerTerminationCondition(MOMENT))
        finally:
            self._growing.on = True
        if not self._definition.hasExactSolution():
            return None
        path = self._definition.getSolutionPath()
        states = [self._configurations.read(path.getState(k)) for k in range(path.getStateCount())]
        return [x for x in states if x is not None]


class _Switch:
    """Whether samples count, or start and goal alone."""

    def __init__(self, configurations: Configurations, start: Array, goal: Array) -> None:
        self._configurations, self._ends, self.on = configurations, (start, goal), True

    def is_valid(self, state: Any) -> bool:
        """Say whether a configuration may become part of the roadmap."""
        if self.on:
            return self._configurations.is_valid(state)
        x = self._configurations.read(state)
        return x is not None and any(np.allclose(x, end, atol=1e-9) for end in self._ends)
