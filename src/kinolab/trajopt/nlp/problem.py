"""How a problem is put to the optimiser, and how its answers become trajectories again."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from functools import cached_property, partial
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.problem.task import LIMIT_TOLERANCE
from kinolab.simulation import Propagator
from kinolab.simulation.machine import states_under
from kinolab.simulation.reference import (
    MAX_ERROR_AMPLIFICATION,
    DivergedError,
    error_amplification,
    perturbed_start,
    resimulate,
    trajectory_under,
)
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints
from kinolab.trajopt.nlp.decision import Knots, Scaling
from kinolab.trajopt.nlp.path_constraints import PathConstraints, Samples, beginnings, samples
from kinolab.trajopt.nlp.transcription import Inequalities, MultipleShooting
from kinolab.trajopt.options import NLP

Array: TypeAlias = NDArray[np.float64]


class TrajectoryProblem:
    """One problem for the optimiser.

    Args:
        problem: To solve.
        clearance: What gaps keep in reserve, as a share of the machine's size; limits of states
            and other margins keep a share of it, as a share of what counts as large.
        fraction: That one.
        near: Gaps that are looked at beyond the reserve, as a share of half the largest shape.
    """

    def __init__(
        self,
        problem: Problem,
        clearance: float,
        *,
        fraction: float = NLP.limit_fraction,
        near: float = 1.0,
    ) -> None:
        self.problem, self.room = problem, clearance
        self.discrete = problem.scenario.integration.truth == "discrete"
        self._bare = CollisionConstraints(problem, 0.0)
        self._obstacles = CollisionConstraints(problem, clearance * self._bare.size, near)
        reserve = NLP.amplified_tolerance if self.discrete else fraction * clearance
        self._demands = [
            PathConstraints(problem, reserve, begins=begins) for begins in (False, True)
        ]
        self._reserve = reserve

    def of(self, problem: Problem) -> TrajectoryProblem:
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
        pieces = self._pieces(knots)
        return MultipleShooting(
            self.problem, self._derived(knots, times), knots.x[-1], parts, pieces
        )

    def refined(self, knots: Knots, times: int) -> Knots:
        """Return the motion under the same inputs with so many times the steps."""
        short = Knots(knots.x, knots.u, knots.h / times)
        step, parts = self._map(short), [knots.x[:-1]]
        for _ in range(times - 1):
            parts.append(step.after(parts[-1], knots.u, short.h))
        x = np.stack(parts, axis=1).reshape(-1, knots.x.shape[1])
        return Knots(np.vstack([x, knots.x[-1:]]), np.repeat(knots.u, times, axis=0), short.h)

    def trajectory(self, knots: Knots) -> Trajectory | None:
        """Return the true motion under the inputs of knots; None where it cannot be followed."""
        problem, model = self.problem, self.problem.model
        u = np.clip(knots.u, *model.control_bounds.T)
        t = knots.h * np.arange(len(u) + 1.0)
        if self.discrete:
            x = states_under(problem, u)
            if not np.isfinite(x).all():
                return None
            return trajectory_under(model, t, x, u)
        try:
            return resimulate(problem, t, u)
        except DivergedError:
            return None

    def satisfies_all(self, trajectory: Trajectory) -> bool:
        """Say whether a true motion ends in the goal and breaks nothing, as far as samples show."""
        return (
            self.problem.goal_excess(trajectory.x[-1]) <= 1.0
            and self._breaks_nothing(self._on_the_way(trajectory))
            and self._begins_well(trajectory)
            and self._stays_free(trajectory)
            and self.repeatable(trajectory)
        )

    def satisfies_all_at_knots(self, trajectory: Trajectory) -> bool:
        """Say the same of a motion whose steps have been judged one by one."""
        return (
            self.problem.goal_excess(trajectory.x[-1]) <= 1.0
            and self._breaks_nothing(samples(Knots(trajectory.x, trajectory.inputs, 1.0), 1))
            and self._begins_well(trajectory)
            and self.repeatable(trajectory)
        )

    def _breaks_nothing(self, at: Samples) -> bool:
        lower, upper = self.problem.bounds.T
        if not ((at.x >= lower - LIMIT_TOLERANCE) & (at.x <= upper + LIMIT_TOLERANCE)).all():
            return False
        margins = PathConstraints(self.problem, 0.0).margins(at.x, at.u)
        return bool(margins.min(initial=0.0) >= -LIMIT_TOLERANCE) and self._bare.free(at.x)

    def _begins_well(self, trajectory: Trajectory) -> bool:
        """Say whether what inputs decide is as it must be where each step begins."""
        at = beginnings(Knots(trajectory.x, trajectory.inputs, 1.0))
        margins = PathConstraints(self.problem, 0.0, begins=True).margins(at.x, at.u)
        return bool(margins.min(initial=0.0) >= -LIMIT_TOLERANCE)

    def defect(self, trajectory: Trajectory) -> float:
        """Return the largest distance of a state from where the step before leads, in scales."""
        spans = np.round(np.diff(trajectory.t), NLP.duration_digits)
        step = self._map(Knots(trajectory.x, trajectory.inputs, float(spans.max(initial=0.0))))
        largest = 0.0
        for span in np.unique(spans):
            own = np.flatnonzero(spans == span)
            after = step.after(trajectory.x[own], trajectory.inputs[own], float(span))
            largest = max(largest, _apart(after, trajectory.x[own + 1], self.problem.scales))
        return largest

    def _stays_free(self, trajectory: Trajectory) -> bool:
        """Say whether every step is free between its ends too, as planners judge it."""
        judge, spans = self._judge, np.diff(trajectory.t).tolist()
        steps = zip(trajectory.x.tolist(), trajectory.inputs.tolist(), spans, strict=False)
        return all(judge.touches_nothing(x, u, span) for x, u, span in steps)

    @cached_property
    def _judge(self) -> Propagator:
        return Propagator(self.problem)

    def _on_the_way(self, trajectory: Trajectory) -> Samples:
        """Return states of the motion between knots, not of the straight lines between them.

        A discrete motion is those lines.
        """
        spans = np.round(np.diff(trajectory.t), NLP.duration_digits)
        knots = Knots(trajectory.x, trajectory.inputs, float(spans.max(initial=0.0)))
        at = samples(knots, NLP.check_factor * self._pieces(knots))
        if self.discrete:
            return at
        step, looks = self._map(knots), len(at.x) // max(len(knots.u), 1)
        x = at.x.copy().reshape(-1, looks, at.x.shape[1])
        for span in np.unique(spans):
            own = np.flatnonzero(spans == span)
            before, held = knots.x[own], knots.u[own]
            for k, fraction in enumerate(at.share[:looks].tolist()):
                x[own, k] = step.after(before, held, fraction * float(span))
        return replace(at, x=x.reshape(at.x.shape))

    def repeatable(self, trajectory: Trajectory) -> bool:
        """Say whether errors do not grow too much to follow the motion without feedback."""
        problem = self.problem
        start = perturbed_start(problem, problem.start)
        h = float(np.diff(trajectory.t).max(initial=0.0)) or 1.0
        x = np.vstack([start, np.empty((len(trajectory.inputs), len(start)))])
        step = self._map(Knots(trajectory.x, trajectory.inputs, h))
        for k in range(len(trajectory.inputs)):
            span = float(trajectory.t[k + 1] - trajectory.t[k])
            x[k + 1] = step.after(x[k : k + 1], trajectory.inputs[k : k + 1], span)[0]
        return error_amplification(problem, trajectory.x, x) <= MAX_ERROR_AMPLIFICATION

    def _map(self, knots: Knots) -> StepSensitivities:
        return StepSensitivities(self.problem.model, *self._steps_of(knots))

    def _steps_of(self, knots: Knots, acts: int = 1) -> tuple[str, int]:
        """Return the method and the number of substeps that are true enough."""
        settings, model = self.problem.scenario.integration, self.problem.model
        if self.discrete:
            return settings.method, settings.substeps
        substeps, step = 1, partial(StepSensitivities, model, "rk4", acts=acts)
        coarse = step(1).after(knots.x, knots.u, knots.h)
        while substeps < NLP.max_substeps:
            fine = step(2 * substeps).after(knots.x, knots.u, knots.h)
            if _apart(coarse, fine, self.problem.scales) <= NLP.step_tolerance:
                break
            substeps, coarse = 2 * substeps, fine
        if np.isfinite(coarse).all():
            return "rk4", substeps
        return settings.accurate_method, substeps  # so stiff that only implicit steps stay bounded

    def _derived(self, knots: Knots, times: int) -> StepSensitivities:
        """Return the map with derivatives that are good enough for a direction."""
        model = self.problem.model
        acts = 1 if model.plant is model else times
        method, substeps = self._steps_of(knots, acts)
        if self.discrete:
            return StepSensitivities(model, method, times * substeps // acts, acts=acts)
        step = partial(StepSensitivities, model, method, acts=acts)
        x, u = knots.x[:-1][:: NLP.sampled_step_stride], knots.u[:: NLP.sampled_step_stride]
        few, coarse = 1, step(1).linearized(x, u, knots.h)[1]
        while few < substeps:
            fine = step(2 * few).linearized(x, u, knots.h)[1]
            if self._wrong(coarse, fine) <= NLP.derivative_tolerance:
                break
            few, coarse = 2 * few, fine
        return step(substeps, few)

    def _wrong(self, coarse: Array, fine: Array) -> float:
        """Return the largest difference of derivatives, in what counts as large."""
        scales = self.problem.scales
        large = np.repeat(scales[:, None], coarse.shape[2], axis=1)
        large[:, : len(scales)] /= scales
        return _apart(coarse, fine, large)

    def _pieces(self, knots: Knots) -> int:
        """Return how many looks per step show everything of importance."""
        model = self.problem.model
        speed = np.max(model.point_speed(knots.x[:-1], knots.u), initial=0.0)
        if self.problem.cables:
            speed = np.max(model.cable_speed(knots.x[:-1], knots.u), initial=speed)
        if not self._size:
            return 1
        return min(
            max(1, math.ceil(float(speed) * knots.h / (NLP.check_resolution * self._size))),
            NLP.max_samples_per_step,
        )

    @cached_property
    def _size(self) -> float:
        return self._bare.size


def _apart(coarse: Array, fine: Array, scales: Array) -> float:
    """Return the largest difference in scales; NaN or infinite where a long step runs away."""
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.abs((coarse - fine) / scales).max(initial=0.0))
