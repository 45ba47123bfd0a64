"""Result of one certificate check, and the context that checks work on."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from kinolab.dynamics import Model
from kinolab.errors import LONGEST_QUOTE, InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goals_reached import goals_reached, in_legs
from kinolab.simulation.reference import (
    DivergedError,
    ReferenceMotion,
    error_amplification,
    perturbed_start,
    reference_motion,
)
from kinolab.trajectory import Trajectory
from kinolab.verification.between_samples.clearance_search import ClearanceSearch, Told
from kinolab.verification.between_samples.dense_motion import DenseMotion, TooFastError

LIMIT_TOLERANCE = 1e-9  # allowed violation of a limit, in its own unit: rounding only


@dataclass(frozen=True)
class Check:
    """Result of one check.

    Attributes:
        name: What was checked.
        value: The worst value found.
        limit: The largest value that passes.
        passed: Whether it passed.
        detail: When, where and by how much, in words; may be empty.
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
    """Return a check that passes if value <= limit (NaN fails); detail is kept on failure only."""
    passed = bool(value <= limit)
    return Check(name, value, limit, passed, "" if passed else detail)


def worst_entry(name: str, errors: Array, limit: float, words: Callable[[int, int], str]) -> Check:
    """Check the largest of errors (m, n), 0 if empty; ``words(row, column)`` describes it."""
    if not errors.size:
        return judged(name, 0.0, limit, "")
    k, i = map(int, np.unravel_index(int(errors.argmax()), errors.shape))
    return judged(name, float(errors[k, i]), limit, words(k, i))


def worst_along(name: str, violations: Iterable[tuple[float, str]]) -> Check:
    """Check the largest of violations along a motion, each with its description."""
    worst, detail = 0.0, ""
    try:
        for violation, words in violations:
            if violation > worst:
                worst, detail = violation, words
    except TooFastError as error:
        worst, detail = math.inf, str(error)
    return judged(name, worst, LIMIT_TOLERANCE, detail)


def require_motion_of(model: Model, trajectory: Trajectory, where: str) -> None:
    """Require that a trajectory is of a machine.

    Raises:
        InputError: If its columns are of another one; ``where`` says whose argument it is.
    """
    plant = model.plant
    references = () if plant is model else model.control_names
    wanted = (*model.state_names, *plant.control_names, *references)
    found = (*trajectory.state_names, *trajectory.control_names, *trajectory.reference_names)
    if found != wanted:
        what = f"its columns are {', '.join(found)[:LONGEST_QUOTE]}, of another machine."
        raise InputError([Mistake(where, what, f"Give one with the columns {', '.join(wanted)}.")])


@dataclass(frozen=True, eq=False)
class CheckContext:
    """Data that checks share, computed on first use.

    Attributes:
        problem: The problem to be solved.
        stored: The trajectory as given.
        known_motion: Motion to check instead of the re-simulated one, such as a planner's own.
        told: Called now and then with what is being done, in words.
        thorough: Whether the equations of motion are compared along the whole motion.
    """

    problem: PlanningTask
    stored: Trajectory
    known_motion: ReferenceMotion | None = None
    told: Told | None = None
    thorough: bool = False

    @classmethod
    def of(
        cls,
        problem: PlanningTask,
        trajectory: Trajectory,
        told: Told | None = None,
        *,
        thorough: bool = False,
    ) -> CheckContext:
        """Return what is needed to check a trajectory, with scales of the size of its states."""
        sizes = np.maximum(np.abs(trajectory.x).max(axis=0), 1.0)
        sizes = np.where(problem.circular, np.pi, sizes)  # however many turns are added
        with np.errstate(over="ignore"):  # infinite, and then the problem's own are smaller
            # a scale that is larger than an entry of the state, and than 1, by more than this makes
            # no tolerance larger: a description cannot switch checks off
            scales = np.fmin(problem.scales, 20.0 * sizes)
        if (scales < problem.scales).any():
            problem = replace(problem, scales=scales)
        return cls(problem, trajectory, told=told, thorough=thorough)

    @property
    def trajectory(self) -> Trajectory:
        """Stored knots, in the representation nearest to the re-simulated motion.

        A state may be stored with additional whole turns, and a quaternion with either sign:
        neither a linear feedback law nor the error growth may depend on that.
        """
        return self._followed[0]

    @property
    def motion(self) -> ReferenceMotion:
        """Re-simulated motion from the start under the stored inputs.

        Raises:
            DivergedError: If it cannot be integrated to its end.
        """
        motion = self._followed[1]
        if isinstance(motion, DivergedError):
            raise motion
        return motion

    @cached_property
    def dense_motion(self) -> DenseMotion:
        """The motion with dense output between the knots."""
        return DenseMotion(self.problem, self.trajectory, self.motion)

    @cached_property
    def clearance_search(self) -> ClearanceSearch:
        """What is known of the clearance along the motion.

        Raises:
            TooFastError: If the motion is too fast to be sampled.
        """
        return ClearanceSearch(self.dense_motion, self.problem.checker(), self.told)

    @cached_property
    def reached(self) -> tuple[float, ...]:
        """When each of several goals is reached, in [s], NaN if never; empty where there is one.

        Also between the rows, where the machine must not leave a goal in which it stays.

        Raises:
            TooFastError: If the motion is too fast to be sampled.
        """
        if not in_legs(self.problem):
            return ()
        batches = [(t, x) for t, x, _ in self.dense_motion.samples()]
        times, states = map(np.concatenate, zip(*batches, strict=True))
        return tuple(goals_reached(self.problem, times, states))

    @cached_property
    def error_growth(self) -> tuple[float, str]:
        """Growth factor of a perturbation of the start, and a message if it is too large."""
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
