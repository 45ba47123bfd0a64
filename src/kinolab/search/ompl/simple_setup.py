"""A problem as OMPL objects, ready for any control planner."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import control as oc
from ompl import util as ou

from kinolab.arguments import require_fit
from kinolab.errors import InputError, Mistake
from kinolab.problem import PlanningTask
from kinolab.search.ompl.control_guidance import ControlGuide
from kinolab.search.ompl.goal_region import GoalRegion, GoalSamples
from kinolab.search.ompl.projection import CellProjection
from kinolab.search.ompl.solution_path import inputs_of, path_in, with_last_step
from kinolab.search.ompl.spaces import StateCodec, control_space
from kinolab.search.ompl.state_propagator import StatePropagator
from kinolab.simulation.reference import resimulate
from kinolab.steering.goal_connection import SteeredGoalConnection
from kinolab.trajectory import Trajectory

ou.setLogLevel(ou.LogLevel.LOG_NONE)


class _ProblemDefinition(ob.ProblemDefinition):  # type: ignore[misc]
    """A problem definition whose start can be looked at.

    OMPL's own ``getStartState`` gives Python a state that both of them free.
    """

    def __init__(self, space_information: Any, start: Any) -> None:
        super().__init__(space_information)
        self.addStartState(start)  # which copies it
        self._start = start

    def getStartState(self, index: int) -> Any:
        if index:
            raise IndexError(index)
        return self._start


class OmplSetup:
    """A problem in OMPL's terms.

    Args:
        min_steps: Minimum control duration in propagation steps.
        max_steps: Maximum control duration in propagation steps.
        goal_region_scale: Factor on the goal's tolerances up to which goal samples are drawn, the
            default projection is refined, and motions are guided to the goal.
        seed: Random seed of goal samples and of candidate inputs.
        cells, angles: Of the default projection, as ``CellProjection`` takes them.
        guide: Makes the control guidance; None leaves control sampling to OMPL.
        last_step: Goal connection; without it OMPL's path has to end in the goal.
        given_up: Whether no state counts as valid any more, so that OMPL terminates.

    Attributes:
        problem: The planning problem.
        seed: Random seed.
        states: Conversion to and from OMPL's states.
        guide: Control guidance; None if OMPL samples controls.
        last_step: Goal connection; None if there is none.
        space: The compound state space.
        space_information: Ready for any control planner.
        problem_definition: With start and goal.
        rejections: Numbers of rejected motions, by cause and source.
        forget: To be called before a planner restarts.
    """

    def __init__(
        self,
        problem: PlanningTask,
        *,
        min_steps: int = 1,
        max_steps: int = 20,
        goal_region_scale: float = 1.0,
        seed: int = 0,
        cells: int = 20,
        angles: bool = True,
        guide: Callable[..., ControlGuide] | None = None,
        last_step: SteeredGoalConnection | None = None,
        given_up: Callable[[], bool] = lambda: False,
    ) -> None:
        self.problem, self.states, self.last_step = problem, StateCodec(problem), last_step
        samples = GoalSamples(problem, goal_region_scale, seed)
        self.seed = seed
        held = {"min_steps": min_steps, "max_steps": max_steps}
        near = {"goal_region_scale": goal_region_scale, "seed": seed}
        self.guide = guide(problem, samples, **held, **near) if guide else None
        propagation = StatePropagator(problem, self.states, self.guide, given_up)
        self.forget, self._propagation = propagation.forget, propagation
        self.space = self.states.space
        self.rejections = propagation.rejections
        information = oc.SpaceInformation(self.space, control_space(problem, self.states))
        information.setStatePropagator(propagation.propagate)
        information.setStateValidityChecker(propagation.is_valid)
        information.setPropagationStepSize(problem.step)
        information.setMinMaxControlDuration(min_steps, max_steps)
        information.setup()
        self.space_information = information
        self.projection = CellProjection(
            problem, self.space, cells, angles, goal_region_scale, self.guide
        )
        self.projection.set_cells()
        self.space.registerDefaultProjection(self.projection)
        start = self.space.allocState()
        # A start may violate a limit by rounding; OMPL would reject it.
        self.write(start, np.clip(problem.start, *problem.bounds.T).tolist())
        self.problem_definition = _ProblemDefinition(information, start)
        goal = GoalRegion(problem, self.states, information, samples, last_step)
        self.problem_definition.setGoal(goal)

    @property
    def statistics(self) -> dict[str, float]:
        """Counters of simulated steps, and of goal connections where they are tried, by name."""
        connections = {} if self.last_step is None else self.last_step.statistics
        return {"propagations": float(self._propagation.propagations), **connections}

    def trajectory(self, path: Any = None) -> Trajectory:
        """Return what an OMPL planner found as a trajectory, simulated anew from the start.

        ``planner.solve(…)`` comes before; ``kinolab.verify`` says whether it solves the problem.

        Args:
            path: An ``ompl.control.PathControl`` of this space; the best solution path of the
                problem definition when left out.

        Raises:
            InputError: If there is no solution path, or the path is none of controls.
            DivergedError: If the motion cannot be integrated to its end.
        """
        if path is None and not self.problem_definition.hasSolution():
            what = "the problem definition has no solution path."
            remedy = "Call solve(…) of a planner with more time, or give a path."
            raise InputError([Mistake("trajectory", what, remedy)])
        if path is None:
            u = with_last_step(path_in(self.problem, self.problem_definition)[1], self.last_step)
        else:
            require_fit("trajectory path", oc.PathControl, path)
            u = inputs_of(self.problem, path)
        return resimulate(self.problem, self.problem.step * np.arange(len(u) + 1.0), u)

    def read(self, state: Any) -> list[float]:
        """Return the entries of an OMPL state in the machine's order."""
        return self.states.read(state)

    def write(self, state: Any, values: Sequence[float]) -> None:
        """Set an OMPL state from entries in the machine's order; angles are wrapped."""
        self.states.write(state, values)
