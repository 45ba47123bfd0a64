"""One check of a certificate: what came of it, and all that it may look at."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import (
    DivergedError,
    ReferenceMotion,
    error_amplification,
    perturbed_start,
    reference_motion,
)
from kinolab.trajectory import Trajectory
from kinolab.verification.dense_motion import DenseMotion, TooFastError

LIMIT_TOLERANCE = 1e-9  # by how much a limit may be passed, in its own unit: rounding only


@dataclass(frozen=True)
class Check:
    """One thing that was checked.

    Attributes:
        name: What was checked.
        value: The worst that was found.
        limit: The largest value that passes.
        passed: Whether it passed.
        detail: When, where and by how much, in words; empty where there is nothing to say.
    """

    name: str
    value: float
    limit: float
    passed: bool
    detail: str = ""

    def __str__(self) -> str:
        verdict = "passed" if self.passed else "FAILED"
        note = f": {self.detail}" if self.detail else ""
        return f"{verdict} {self.name} ({self.value:.3g}, limit {self.limit:.3g}){note}"


def judged(name: str, value: float, limit: float, detail: str) -> Check:
    """Return a check that passes up to a limit; NaN does not. What passes needs no detail."""
    passed = bool(value <= limit)
    return Check(name, value, limit, passed, "" if passed else detail)


def worst_entry(name: str, errors: Array, limit: float, words: Callable[[int, int], str]) -> Check:
    """Judge the largest of errors of shape (m, n), none being 0; words tell of (row, column)."""
    if not errors.size:
        return judged(name, 0.0, limit, "")
    k, i = map(int, np.unravel_index(int(errors.argmax()), errors.shape))
    return judged(name, float(errors[k, i]), limit, words(k, i))


def worst_along(name: str, violations: Iterable[tuple[float, str]]) -> Check:
    """Judge the largest of violations along a motion, each with words for it."""
    worst, detail = 0.0, ""
    try:
        for violation, words in violations:
            if violation > worst:
                worst, detail = violation, words
    except TooFastError as error:
        worst, detail = math.inf, str(error)
    return judged(name, worst, LIMIT_TOLERANCE, detail)


@dataclass(frozen=True, eq=False)
class CheckContext:
    """What checks look at, each made when it is first asked for.

    Attributes:
        problem: That the trajectory shall solve.
        stored: The trajectory as it was handed over.
        known_motion: What to judge instead of the true motion, such as a planner's own.
    """

    problem: PlanningTask
    stored: Trajectory
    known_motion: ReferenceMotion | None = None

    @property
    def trajectory(self) -> Trajectory:
        """The stored knots in the numbers nearest to the true motion.

        A state may be stored with whole turns more or less, and a quaternion with either sign:
        neither what is linear in it, such as a law of feedback, nor the growth of errors shall
        depend on that.
        """
        return self._followed[0]

    @property
    def motion(self) -> ReferenceMotion:
        """The true motion from the start under the stored inputs.

        Raises:
            DivergedError: If it cannot be followed to its end.
        """
        motion = self._followed[1]
        if isinstance(motion, DivergedError):
            raise motion
        return motion

    @cached_property
    def dense_motion(self) -> DenseMotion:
        """The true motion between the knots too."""
        return DenseMotion(self.problem, self.trajectory, self.motion)

    @cached_property
    def error_growth(self) -> tuple[float, str]:
        """Factor by which a perturbation of the start has grown, and what to say if it is large."""
        start, t, inputs = self.trajectory.x[0], self.trajectory.t, self.trajectory.inputs
        motion, beside = self.motion, perturbed_start(self.problem, start)
        try:
            far = reference_motion(self.problem, beside, t, inputs, between=False)
        except DivergedError as error:
            return math.inf, str(error)
        grown = error_amplification(self.problem, motion.x, far.x)
        return grown, "too sensitive to be replayed without feedback"

    @cached_property
    def _followed(self) -> tuple[Trajectory, ReferenceMotion | DivergedError]:
        problem, stored = self.problem, self.stored
        if self.known_motion is not None:
            return stored, self.known_motion
        x = np.array(stored.x, dtype=float)
        x[0] = problem.space.nearest(problem.start, x[0])
        try:
            motion = reference_motion(problem, x[0], stored.t, stored.inputs)
        except DivergedError as error:
            return replace(stored, x=x), error
        return replace(stored, x=problem.space.nearest(motion.x, x)), motion
