"""The trajectory optimisation problem and its multiple-shooting transcription.

Source: Bock, Plitt, A multiple shooting algorithm for direct solution of optimal control problems,
IFAC 1984; Malyuta and others, Convex optimization for trajectory generation, IEEE Control Systems
42(5), 2022.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from kinolab.concurrency.cancel import CancellationToken, never_cancelled
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.simulation import Propagator
from kinolab.simulation.collision_context import resolution
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints
from kinolab.trajopt.nlp.decision import Knots, Scaling, Weights
from kinolab.trajopt.nlp.dynamics_constraint import derived_map, is_discrete
from kinolab.trajopt.nlp.goal_constraint import GoalConstraint
from kinolab.trajopt.nlp.linearization import Linearization
from kinolab.trajopt.nlp.options import NLP, SQP
from kinolab.trajopt.nlp.path_constraints import (
    LinearInequalities,
    PathConstraints,
    Samples,
    beginnings,
    samples,
    variable_scales,
)
from kinolab.trajopt.nlp.transitions import Transitions

Inequalities: TypeAlias = PathConstraints | CollisionConstraints  # along a trajectory


@dataclass(frozen=True, eq=False)
class Excess:
    """How far a motion passes limits between knots, which are satisfied at the knots.

    Attributes:
        limits: Of the states, at least 0, shape (nx,).
        margins: Of path constraints, scaled, at least 0, shape (constraints,).
    """

    limits: Array
    margins: Array

    def __bool__(self) -> bool:
        return bool(self.limits.any() or self.margins.any())

    def __add__(self, more: Excess) -> Excess:
        return Excess(self.limits + more.limits, self.margins + more.margins)


NO_EXCESS = Excess(np.zeros(()), np.zeros(()))


# Takes the duration in [s] that a search for the least time has come to, and the fraction by which
# the last half of its steps made that shorter if it was given up, else zero.
Minimised: TypeAlias = Callable[[float, float], object]


def nobody_asks(duration: float, still: float) -> None:
    """Do nothing with what a search for the least time has come to."""


class TrajectoryProblem:
    """A planning problem as a trajectory optimisation problem.

    Args:
        clearance: Safety margin of distances, as a fraction of the machine's size.
        room: The same in [m], at least.
        fraction: Scaled margin of state limits and path constraints, as a fraction of that.
        near: Activation distance of collision constraints beyond the safety margin, as a fraction
            of half the largest shape.
        cancelled: Whether to give up.
        minimised: Called after each search for the least time.

    Attributes:
        problem: The planning problem.
        minimised: As given.
        cancelled: Whether to give up.
        discrete: Whether the step length is fixed and motions are straight lines between knots.
        bare: Collision constraints without a safety margin.
    """

    def __init__(
        self,
        problem: PlanningTask,
        clearance: float,
        *,
        room: float = 0.0,
        fraction: float = NLP.limit_fraction,
        near: float = 1.0,
        cancelled: CancellationToken = never_cancelled,
        minimised: Minimised = nobody_asks,
    ) -> None:
        self.minimised = minimised
        self.problem, self.discrete = problem, is_discrete(problem)
        self.cancelled, self._most_samples = cancelled, NLP.max_samples_per_step
        self.bare = CollisionConstraints(problem, 0.0)
        self._gap = max(clearance * self.bare.size, room)
        self._obstacles = CollisionConstraints(problem, self._gap, near)
        reserve = NLP.amplified_tolerance if self.discrete else fraction * clearance
        self._reserve = reserve
        self._demands = [
            PathConstraints(problem, reserve, begins=begins) for begins in (False, True)
        ]
        self._inset = reserve * variable_scales(problem)[0]

    def of(self, problem: PlanningTask) -> TrajectoryProblem:
        """Return the same for another problem of the same machine in the same world.

        The collision arrays are shared: building them takes longer than a small problem.
        """
        other = copy.copy(self)
        other.problem = problem
        return other

    def until(self, cancelled: CancellationToken) -> TrajectoryProblem:
        """Return the same with another token."""
        other = copy.copy(self)
        other.cancelled = cancelled
        return other

    def sampled(self, most: int) -> TrajectoryProblem:
        """Return the same with at most so many samples per step."""
        other = copy.copy(self)
        other._most_samples = most
        return other

    def tightened(self, excess: Excess) -> TrajectoryProblem:
        """Return the same with limits tightened by what a motion passes them between knots."""
        other = copy.copy(self)
        on_the_way, where_steps_begin = self._demands
        other._inset = self._inset + NLP.excess_factor * excess.limits
        tighter = on_the_way.tightened(NLP.excess_factor * excess.margins)
        other._demands = [tighter, where_steps_begin]
        return other

    def scaling(self, shortest: float | Array, longest: float | Array) -> Scaling:
        """Return scales and bounds of all variables, given bounds of the step lengths in [s].

        The limits of the states are tightened, and still contain start and goal.
        """
        problem, inset = self.problem, self._inset
        limits = problem.model.control_bounds
        half = (limits[:, 1] - limits[:, 0]) / 2
        large = np.where(np.isfinite(half) & (half > 0), half, 1.0)
        goal, (lower, upper) = problem.goal.centre(problem.start), problem.bounds.T
        least, most = np.minimum(problem.start, goal), np.maximum(problem.start, goal)
        low = np.maximum(lower, np.minimum(lower + inset, least))
        high = np.minimum(upper, np.maximum(upper - inset, most))
        bounds = np.column_stack([low, high])
        return Scaling(problem.scales, large, bounds, limits, (shortest, longest))

    def weights(self, knots: Knots) -> Weights:
        """Return weights by which the cost of a motion is 1, beside a little effort."""
        # 1e-3: weight of the mean square input, and of changes, relative to 1 for the cost
        entry, rest = self.problem.cost_entry, (1e-3, 1e-3, SQP.violation_penalty)
        if entry is None:
            return Weights(1 / knots.duration, *rest)
        return Weights(0.0, 0.0, *rest[1:], spent=1 / self.problem.cost_of(knots), entry=entry)

    def curvature(self, knots: Knots, scaling: Scaling, weights: Weights) -> Array | None:
        """Return the convex part of the second derivatives of the cost, as ``Subproblem`` has it.

        Of the rate of the cost alone, at the knots: what curves the motion is left out, as Gauss
        and Newton do.
        """
        entry = self.problem.cost_entry
        if entry is None:
            return None
        z, large = np.hstack([knots.x[:-1], knots.u]), np.concatenate([scaling.x, scaling.u])
        ends = NLP.curvature_step * np.vstack([np.eye(z.shape[1]), -np.eye(z.shape[1])]) * large
        slopes = np.array([self._slopes(z + end, entry) for end in ends]) * large
        forward, back = np.split(slopes, 2)
        H = (forward - back).transpose(1, 0, 2) / (2 * NLP.curvature_step)
        H *= weights.spent * knots.lengths[knots.phase][:, None, None]
        values, vectors = np.linalg.eigh((H + H.transpose(0, 2, 1)) / 2)
        convex: Array = vectors * np.maximum(values, 0.0)[:, None, :] @ vectors.transpose(0, 2, 1)
        return convex

    def _slopes(self, z: Array, entry: int) -> Array:
        """Return the derivatives of the rate of the cost by states and inputs (N, nx + nu)."""
        model = self.problem.model
        by_x, by_u = model.jacobian(z[:, : model.nx], z[:, model.nx :])
        return np.hstack([by_x[:, entry], by_u[:, entry]])

    def within_limits(self, knots: Knots) -> Knots:
        """Clip knots to the limits of states and inputs, and begin them at the start."""
        scaling = self.scaling(knots.h, knots.h)
        x = np.clip(knots.x, *scaling.x_bounds.T)
        x[0] = self.problem.start
        return replace(knots, x=x, u=np.clip(knots.u, *scaling.u_bounds.T))

    def transcription(self, knots: Knots, times: int = 1) -> MultipleShooting:
        """Return the transcription near a guess, with ``times`` steps of the problem per knot."""
        parts: list[Inequalities] = [*self._demands, self._obstacles]
        step = derived_map(self.problem, knots, times)
        pieces = self.samples_per_step(knots)
        linkage = Transitions(self.problem, step, self._reserve)
        return MultipleShooting(
            self.problem, step, linkage, knots.x[-1], parts, pieces, self.cancelled
        )

    @cached_property
    def judge(self) -> Propagator:
        """The planners' collision check of single steps.

        It wants half its resolution of clearance, and with theirs it would refuse motions with a
        smaller reserve than that.
        """
        return Propagator(self.problem, finest=self._gap or math.inf)

    def samples_per_step(self, knots: Knots) -> int:
        """Return how many samples per step resolve the motion well enough."""
        model = self.problem.model
        speed = np.max(model.point_speed(knots.x[:-1], knots.u), initial=0.0)
        if self.problem.cables:
            speed = np.max(model.cable_speed(knots.x[:-1], knots.u), initial=speed)
        if not self.bare.size:
            return 1
        moved = float(speed) * knots.h / (NLP.check_resolution * self.bare.size)
        return min(max(1, math.ceil(moved)), self._most_samples)


def most_time(problem: PlanningTask) -> float:
    """Return how long a motion may take in [s]."""
    section = problem.scenario.objective
    return math.inf if section is None or section.max_time is None else section.max_time


def usual_room(problem: PlanningTask) -> float:
    """Return a clearance in [m] that the planners' collision check lets pass, for a first try."""
    return NLP.room * resolution(problem)


def linearization_seconds(step_map: StepSensitivities, steps: int) -> float:
    """Return the work of a linearisation of so many steps without inequalities, in [s]."""
    return 4e-4 + step_map.seconds(steps)


class MultipleShooting:
    """Multiple-shooting transcription of one problem for knots near a guess.

    Args:
        step_map: From knot to knot.
        end: Guess of the final state, shape (nx,); it selects the branch of the goal constraint.
        inequalities: Path and collision constraints.
        pieces: Samples per step at which inequalities are evaluated.
        cancelled: Whether to give up.
    """

    def __init__(
        self,
        problem: PlanningTask,
        step_map: StepSensitivities,
        linkage: Transitions,
        end: Array,
        inequalities: Sequence[Inequalities],
        pieces: int,
        cancelled: CancellationToken = never_cancelled,
    ) -> None:
        self.cancelled = cancelled
        self._map, self._linkage, self._scales = step_map, linkage, problem.scales
        self._ends = GoalConstraint(problem, end)
        self._inequalities, self._pieces = inequalities, pieces
        self._rows = 0
        self._stepped: tuple[Knots, Array] | None = None  # an accepted candidate comes once more

    def linearization(self, knots: Knots, reach: float) -> Linearization:
        """Return the linearisation; ``reach`` is the largest scaled step it will be used for."""
        known = self._stepped[1] if self._stepped and self._stepped[0] is knots else None
        entries = self._linkage.linearized(knots)
        after, tangents = self._map.linearized(entries.x, knots.u, entries.spans, known=known)
        rows = LinearInequalities.joined(
            [part.rows(at, reach) for part, at in self._samples(knots, entries.x)]
        )
        nx, begins = knots.x.shape[1], knots.phases.begins
        for k, slopes in zip(begins, entries.slopes, strict=True):  # by what is before a transition
            own = rows.knot == k
            rows.du[own] += rows.dx[own] @ slopes[:, nx:]
            rows.dx[own] = rows.dx[own] @ slopes[:, :nx]
            along = tangents[k, :, :nx] @ slopes
            along[:, nx:] += tangents[k, :, nx:-1]
            tangents[k, :, :-1] = along
        if len(begins):
            rows = LinearInequalities.joined([rows, entries.rows])
        self._rows = len(rows.knot)
        charge(linearization_seconds(self._map, len(knots.u)) + 2.4e-6 * self._rows)
        end = knots.x[-1]
        miss, derivative = self._ends.residual(end), self._ends.jacobian(end)
        return Linearization(knots, after - knots.x[1:], tangents, rows, miss, derivative)

    def violation(self, knots: Knots) -> tuple[float, float, float]:
        """Return the summed violations of dynamics (defects), goal and inequalities, scaled."""
        stepping = self._map.seconds(len(knots.u), derive=False)
        charge(6e-4 + stepping + 9e-7 * self._rows)
        entered, spans = self._linkage.entered(knots)
        after = self._map.after(entered, knots.u, spans)
        self._stepped = (knots, after)
        defects = float(np.abs((after - knots.x[1:]) / self._scales).sum())
        short = sum(part.violation(at) for part, at in self._samples(knots, entered))
        short += self._linkage.violation(knots)
        return defects, float(np.abs(self._ends.residual(knots.x[-1])).sum()), short

    def _samples(self, knots: Knots, entered: Array) -> Iterator[tuple[Inequalities, Samples]]:
        """Yield each kind of inequality with its samples."""
        begin, on_the_way = beginnings(knots, entered), samples(knots, self._pieces, entered)
        for part in self._inequalities:
            yield part, begin if part.begins else on_the_way
