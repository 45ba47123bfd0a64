"""A problem as equations and inequalities of the knots of a trajectory: multiple shooting.

Source: Bock, Plitt, A multiple shooting algorithm for direct solution of optimal control problems,
IFAC 1984; Malyuta and others, Convex optimization for trajectory generation, IEEE Control Systems
42(5), 2022.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Protocol

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation import Propagator
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints
from kinolab.trajopt.nlp.decision import Knots, Scaling
from kinolab.trajopt.nlp.dynamics_constraint import derived_map, is_discrete
from kinolab.trajopt.nlp.goal_constraint import GoalConstraint
from kinolab.trajopt.nlp.linearization import Linearization
from kinolab.trajopt.nlp.path_constraints import (
    LinearInequalities,
    PathConstraints,
    Samples,
    beginnings,
    samples,
    stack,
)
from kinolab.trajopt.options import NLP


class TrajectoryProblem:
    """One problem for the optimiser.

    Args:
        problem: To solve.
        clearance: What gaps keep in reserve, as a share of the machine's size; limits of states
            and other margins keep a share of it, as a share of what counts as large.
        fraction: That one.
        near: Gaps that are looked at beyond the reserve, as a share of half the largest shape.

    Attributes:
        problem: As given.
        discrete: Whether steps have one length, and motions are straight lines between knots.
        bare: Gaps without any reserve.
    """

    def __init__(
        self,
        problem: PlanningTask,
        clearance: float,
        *,
        fraction: float = NLP.limit_fraction,
        near: float = 1.0,
    ) -> None:
        self.problem, self.discrete = problem, is_discrete(problem)
        self.bare = CollisionConstraints(problem, 0.0)
        self._obstacles = CollisionConstraints(problem, clearance * self.bare.size, near)
        reserve = NLP.amplified_tolerance if self.discrete else fraction * clearance
        self._demands = [
            PathConstraints(problem, reserve, begins=begins) for begins in (False, True)
        ]
        self._reserve = reserve

    def of(self, problem: PlanningTask) -> TrajectoryProblem:
        """Return the task of another problem of the same machine in the same world.

        What is known of the world is shared: building it takes longer than a small problem.
        """
        other = copy.copy(self)
        other.problem = problem
        return other

    def scaling(self, shortest: float, longest: float) -> Scaling:
        """Return the scaling of all variables, with a range of the step length in [s]."""
        problem = self.problem
        lower, upper = problem.model.control_bounds.T
        half = (upper - lower) / 2
        bounds = self._tightened()
        large = np.where(np.isfinite(half) & (half > 0), half, 1.0)
        limits = problem.model.control_bounds
        return Scaling(problem.scales, large, bounds, limits, (shortest, longest))

    def _tightened(self) -> Array:
        """Return the limits of states with a reserve, but not tighter than start and goal."""
        problem = self.problem
        inset, goal = self._reserve * problem.scales, problem.start.copy()
        goal[list(problem.goal.indices)] = problem.goal.targets
        lower, upper = problem.bounds.T
        least, most = np.minimum(problem.start, goal), np.maximum(problem.start, goal)
        return np.column_stack(
            [
                np.maximum(lower, np.minimum(lower + inset, least)),
                np.minimum(upper, np.maximum(upper - inset, most)),
            ]
        )

    def within_limits(self, knots: Knots) -> Knots:
        """Return knots that begin at the start, clipped to the limits of states and inputs."""
        scaling = self.scaling(knots.h, knots.h)
        x = np.clip(knots.x, *scaling.x_bounds.T)
        x[0] = self.problem.start
        return Knots(x, np.clip(knots.u, *scaling.u_bounds.T), knots.h)

    def transcription(self, knots: Knots, times: int = 1) -> MultipleShooting:
        """Return the equations for knots near a guess, of so many of the problem's steps each."""
        parts: list[Inequalities] = [*self._demands, self._obstacles]
        step = derived_map(self.problem, knots, times)
        return MultipleShooting(
            self.problem, step, knots.x[-1], parts, self.samples_per_step(knots)
        )

    @cached_property
    def judge(self) -> Propagator:
        """What planners judge single steps by."""
        return Propagator(self.problem)

    def samples_per_step(self, knots: Knots) -> int:
        """Return how many samples per step show everything of importance."""
        model = self.problem.model
        speed = np.max(model.point_speed(knots.x[:-1], knots.u), initial=0.0)
        if self.problem.cables:
            speed = np.max(model.cable_speed(knots.x[:-1], knots.u), initial=speed)
        if not self.bare.size:
            return 1
        moved = float(speed) * knots.h / (NLP.check_resolution * self.bare.size)
        return min(max(1, math.ceil(moved)), NLP.max_samples_per_step)


class Inequalities(Protocol):
    """One kind of margins along a trajectory."""

    @property
    def begins(self) -> bool:
        """Whether they are looked at where steps begin, not on the way from there."""

    def rows(self, at: Samples, reach: float) -> LinearInequalities:
        """Return the linearised margins that a change may use up."""

    def violation(self, at: Samples) -> float:
        """Return the sum of all that is missing."""


class MultipleShooting:
    """The equations of one problem for knots near a guess.

    Args:
        problem: To solve.
        step_map: From knot to knot.
        end: A guess of the last state, shape (nx,): it chooses between turns of the same angle.
        inequalities: What to keep on the way.
        pieces: Into which every step is cut, to look at the inequalities.
    """

    def __init__(
        self,
        problem: PlanningTask,
        step_map: StepSensitivities,
        end: Array,
        inequalities: Sequence[Inequalities],
        pieces: int,
    ) -> None:
        self._map, self._ends, self._scales = step_map, GoalConstraint(problem, end), problem.scales
        self._inequalities, self._pieces = inequalities, pieces

    def linearization(self, knots: Knots, reach: float) -> Linearization:
        """Return the linearisation; ``reach`` is the largest change it will be used for."""
        after, tangents = self._map.linearized(knots.x, knots.u, knots.h)
        rows = stack([part.rows(at, reach) for part, at in self._looks(knots)])
        end = knots.x[-1]
        miss, derivative = self._ends.residual(end), self._ends.jacobian(end)
        return Linearization(knots, after - knots.x[1:], tangents, rows, miss, derivative)

    def violation(self, knots: Knots) -> tuple[float, float, float]:
        """Return the sums of all defects, of what is missing in the goal and in inequalities."""
        after = self._map.after(knots.x, knots.u, knots.h)
        defects = float(np.abs((after - knots.x[1:]) / self._scales).sum())
        short = sum(part.violation(at) for part, at in self._looks(knots))
        return defects, float(np.abs(self._ends.residual(knots.x[-1])).sum()), short

    def _looks(self, knots: Knots) -> Iterator[tuple[Inequalities, Samples]]:
        """Yield each kind of margins with where it is looked at."""
        begin, on_the_way = beginnings(knots), samples(knots, self._pieces)
        for part in self._inequalities:
            yield part, begin if part.begins else on_the_way
