"""A problem as OMPL objects, ready for any control planner."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import control as oc
from ompl import util as ou

from kinolab.bridge.goal_region import GoalRegion
from kinolab.bridge.projection import Projection
from kinolab.bridge.propagation import Propagation
from kinolab.bridge.spaces import States, control_space
from kinolab.problem import Problem

ou.setLogLevel(ou.LogLevel.LOG_NONE)


class Bridge:
    """A problem in OMPL's terms.

    Args:
        problem: What to plan.
        min_steps: Propagation steps for which an input is held at least.
        max_steps: Propagation steps for which an input is held at most.
        goal_zoom: Factor on the goal's tolerances, up to which samples of the goal are drawn.
        given_up: Whether no state counts as valid any more, so that OMPL comes to an end.

    Attributes:
        problem: What it was made of.
        space: The compound state space.
        space_information: Ready for any control planner.
        problem_definition: With start and goal.
        rejections: How many motions were refused, by cause and culprit.
        forget: Call it before a planner begins anew.
    """

    def __init__(
        self,
        problem: Problem,
        *,
        min_steps: int = 1,
        max_steps: int = 20,
        goal_zoom: float = 1.0,
        given_up: Callable[[], bool] = lambda: False,
    ) -> None:
        self.problem, self._states = problem, States(problem)
        propagation = Propagation(problem, self._states)
        self.forget = propagation.forget
        self.space = self._states.space
        self.rejections = propagation.rejections
        information = oc.SpaceInformation(self.space, control_space(problem, self._states))
        information.setStatePropagator(propagation.propagate)
        information.setStateValidityChecker(
            lambda state: not given_up() and propagation.is_valid(state)
        )
        information.setPropagationStepSize(problem.step)
        information.setMinMaxControlDuration(min_steps, max_steps)
        information.setup()
        self.space_information = information
        projection = Projection(problem, self.space)
        projection.set_cells()
        self.space.registerDefaultProjection(projection)
        self.problem_definition = ob.ProblemDefinition(information)
        start = self.space.allocState()
        # A start may pass a limit by rounding; OMPL would refuse it.
        self.write(start, np.clip(problem.start, *problem.bounds.T).tolist())
        self.problem_definition.addStartState(start)
        self.problem_definition.setGoal(GoalRegion(problem, self._states, information, goal_zoom))

    def read(self, state: Any) -> list[float]:
        """Return the entries of an OMPL state in the machine's order."""
        return self._states.read(state)

    def write(self, state: Any, values: Sequence[float]) -> None:
        """Set an OMPL state from entries in the machine's order; angles are wrapped."""
        self._states.write(state, values)
