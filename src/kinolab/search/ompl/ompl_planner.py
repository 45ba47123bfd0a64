"""Adapter that exposes a kinolab planner as an OMPL planner."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ompl import base as ob
from ompl import control as oc

from kinolab.search.budget import Budget
from kinolab.search.ompl.simple_setup import OmplSetup
from kinolab.search.planner import AbstractPlanner
from kinolab.search.result import Outcome
from kinolab.simulation.reference import resimulate


class OmplPlanner(ob.Planner):  # type: ignore[misc]
    """Runs wherever OMPL expects a control planner, on the problem of an ``OmplSetup``.

    Args:
        setup: The problem in OMPL's terms; its problem definition is used unless another is set.
    """

    def __init__(self, setup: OmplSetup, planner: AbstractPlanner, seed: int = 1) -> None:
        super().__init__(setup.space_information, planner.name)
        self._bridge, self._planner, self._seed = setup, planner, seed
        self.setProblemDefinition(setup.problem_definition)

    def setup(self) -> None:
        """Do nothing: a search sets itself up."""

    def clear(self) -> None:
        """Do nothing: a search leaves nothing behind."""

    def solve(self, ended: Callable[[], bool]) -> Any:
        """Search until the termination condition holds, and add the solution path."""
        budget = Budget(math.inf, cancelled=ended)
        result = self._planner.solve(self._bridge.problem, self._seed, budget)
        if not len(result.u):
            return ob.PlannerStatus(ob.PlannerStatus.TIMEOUT)
        setup, problem = self._bridge, self._bridge.problem
        motion = resimulate(problem, result.t, result.u)
        path = oc.PathControl(setup.space_information)
        state = setup.space.allocState()
        control = setup.space_information.getControlSpace().allocControl()
        for k, x in enumerate(motion.x):
            setup.write(state, x.tolist())
            if k == 0:
                path.append(state)
                continue
            for i, value in enumerate(motion.u[k - 1]):
                control[i] = float(value)
            path.append(state, control, float(motion.t[k] - motion.t[k - 1]))
        excess = problem.goal_excess(motion.x[-1])
        exact = result.outcome is Outcome.SOLVED
        self.getProblemDefinition().addSolutionPath(path, not exact, excess, self._planner.name)
        kind = "EXACT_SOLUTION" if exact else "APPROXIMATE_SOLUTION"
        return ob.PlannerStatus(getattr(ob.PlannerStatus, kind))
