"""Dense samples of a re-simulated motion, with bounds on point speeds, for the verifier."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.model.enclosures import Enclosures
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.motion_pieces import MotionPieces
from kinolab.simulation.reference import OdeMotion, ReferenceMotion
from kinolab.trajectory import Trajectory
from kinolab.verification.between_samples.speed_bounds import bounded_speeds

MAX_SPACING = 0.01  # [m] largest motion between two samples of limits and requirements
MAX_SAMPLES = 100_000  # per integrator step; a motion that needs more fails unchecked
MAX_SHORT_STEPS, MAX_SHORT_STEPS_EACH = 1_000_000, 100_000  # of the integrator in all, in a row
SPEED_PROBES = 5  # speed samples within one integrator step
SAFETY_FACTOR = 1.2  # factor on the fastest sample
STATES_PER_BATCH = 20_000  # approximate number of states per batch


class TooFastError(Exception):
    """A motion that cannot be sampled finely enough to be checked."""

    def __init__(self, begin: float, end: float, speed: float) -> None:
        what = "the motion is too fast, or too close to something, to be checked"
        super().__init__(f"from t = {begin:.6g} s {what}: {speed:.3g} m/s for {end - begin:.3g} s")


@dataclass(frozen=True, eq=False)
class Steps:
    """Integrator steps, with a bound on the speed of all points in each.

    Attributes:
        knots: Knot interval of each step, shape (m,), ascending.
        begin: Start times in [s], shape (m,).
        end: End times in [s], shape (m,).
        speed: Speed bounds in [m/s], shape (m,).
    """

    knots: NDArray[np.intp]
    begin: Array
    end: Array
    speed: Array


@dataclass(frozen=True, eq=False)
class DenseMotion:
    """Re-simulated motion of a trajectory, to be sampled along its whole length.

    Attributes:
        problem: The problem that the trajectory solves.
        trajectory: Provides the inputs.
        motion: The motion under these inputs.
    """

    problem: PlanningTask
    trajectory: Trajectory
    motion: ReferenceMotion

    @cached_property
    def enclosures(self) -> Enclosures:
        """Bounds of what the machine does over boxes of states."""
        return Enclosures(self.problem.model)

    @property
    def pieces(self) -> MotionPieces | None:
        """The motion as polynomials; None of a discrete one."""
        return self.motion.pieces if isinstance(self.motion, OdeMotion) else None

    @cached_property
    def steps(self) -> Steps:
        """The integrator steps, in parts where only a part of them is bounded closely.

        The speeds of a solution of the equations of motion are enclosed. Those of a discrete motion
        are sampled: its steps are short, and straight.

        Raises:
            TooFastError: If samples ``MAX_SPACING`` apart would be too many.
        """
        knots, begin, end = self.motion.steps
        if not len(knots):
            return Steps(knots, begin, end, np.zeros(0))
        size = STATES_PER_BATCH // SPEED_PROBES
        parts = [slice(first, first + size) for first in range(0, len(knots), size)]
        speed = np.concatenate([self._speed(knots[at], begin[at], end[at]) for at in parts])
        if self.pieces is not None:
            pieces, speed = bounded_speeds(
                self.enclosures, self.pieces, self.trajectory.u, speed, self._moved
            )
            knots, begin, end = pieces.knots, pieces.begin, pieces.end
        cancelled = np.flatnonzero(~(speed * (end - begin) <= MAX_SAMPLES * MAX_SPACING))
        if cancelled.size:
            k = cancelled[0]
            raise TooFastError(float(begin[k]), float(end[k]), float(speed[k]))
        if float((speed * (end - begin)).sum()) > 50_000.0:  # [m] of a motion: 5 million samples
            raise TooFastError(float(begin[0]), float(end[-1]), float(speed.max()))
        return Steps(knots, begin, end, speed)

    @property
    def longest_steps(self) -> Array:
        """In what time no point moves more than ``MAX_SPACING``, per interval in [s], (N,).

        Of a way of kilometres it is more than that: ``MAX_SHORT_STEPS`` are enough for all of it.

        Raises:
            TooFastError: As ``steps``.
        """
        spans, fastest = np.diff(self.motion.t), np.zeros(len(self.motion.t) - 1)
        np.maximum.at(fastest, self.steps.knots, self.steps.speed)
        way = fastest * spans
        spacing = max(MAX_SPACING, float(way.sum()) / MAX_SHORT_STEPS)
        spacing = max(spacing, float(way.max(initial=0.0)) / MAX_SHORT_STEPS_EACH)
        with np.errstate(divide="ignore"):
            return spacing / fastest

    def _moved(self, pieces: MotionPieces) -> Array:
        """Return how far bodies and cables are moved and turned between ends of pieces, (m,)."""
        (poses, cables), (others, after) = map(self.problem.placement, pieces.ends)
        moved = np.linalg.norm(others - poses, axis=-1).max(axis=-1, initial=0.0)
        if self.problem.cables:
            ends = np.linalg.norm(after - cables, axis=-1).reshape(len(moved), -1)
            moved = np.maximum(moved, ends.max(axis=1, initial=0.0))
        return np.asarray(moved)

    def samples(self) -> Iterator[tuple[Array, Array, Array]]:
        """Yield batches of (times, states, zero-order-hold inputs), in order.

        No point moves more than ``MAX_SPACING`` between two samples; the ends of all integrator
        steps are included.
        """
        steps = self.steps
        counts = np.ceil(steps.speed * (steps.end - steps.begin) / MAX_SPACING).astype(int) + 1
        if self.pieces is not None:  # polynomials of degree 7, which may turn between two samples
            counts = np.maximum(counts, 6)  # of each piece between samples at least
        group = np.cumsum(counts + 1) // STATES_PER_BATCH
        for rows in np.split(np.arange(len(counts)), np.flatnonzero(np.diff(group)) + 1):
            k = np.repeat(rows, counts[rows] + 1)
            last = np.cumsum(counts[rows] + 1)
            number = np.arange(len(k)) - np.repeat(last - counts[rows] - 1, counts[rows] + 1)
            span = steps.end[k] - steps.begin[k]
            times = np.minimum(steps.begin[k] + span * (number / counts[k]), steps.end[k])
            knots = steps.knots[k]
            if len(k):
                yield times, self.motion.along(knots, times), self.trajectory.u[knots]

    def _speed(self, knots: NDArray[np.intp], begin: Array, end: Array) -> Array:
        """Return a bound on the speed of all points in each step, shape (m,), by sampling it."""
        model, fraction = self.problem.model.plant, np.linspace(0.0, 1.0, SPEED_PROBES)
        times = np.minimum(begin[:, None] + (end - begin)[:, None] * fraction, end[:, None])
        each = np.repeat(knots, SPEED_PROBES)
        states, held = self.motion.along(each, times.ravel()), self.trajectory.u[each]
        fastest = np.max(model.point_speed(states, held), axis=1, initial=0.0)
        if self.problem.cables:
            fastest = np.maximum(fastest, model.cable_speed(states, held).max(axis=1, initial=0.0))
        speed: Array = SAFETY_FACTOR * fastest.reshape(-1, SPEED_PROBES).max(axis=1)
        return speed
