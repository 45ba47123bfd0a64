"""Switching-time optimisation: motions of arcs under constant extreme inputs.

What takes least time goes from one extreme of its inputs to another, or leaves one out (arcs of
Reeds and Shepp's car: full speed, the wheels turned to a side or straight). A random word of such
inputs, longer than is needed, has most optimal ones among its parts; the least sum of its arcs'
durations, none of them negative, leaves the needless ones out. Unlike knots at equal times its arcs
end when they should, and unlike motions near a given one it goes forward and backward as it likes.

Source: Kaya, Noakes, Computational method for time-optimal switching control, J. Optimization
Theory and Applications 117(1), 2003; Sussmann, Tang, Shortest paths for the Reeds-Shepp car, Report
SYCON-91-10, 1991 (extremals of driftless systems).
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import scipy

from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.simulation.dop853_coefficients import DOP853
from kinolab.simulation.reference import DivergedError, resimulate
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.feasibility_check import satisfies_all
from kinolab.trajopt.nlp.goal_constraint import GoalConstraint, meets_centre
from kinolab.trajopt.nlp.options import GUESS
from kinolab.trajopt.nlp.problem import TrajectoryProblem

# [s] of work for an arc with derivatives, on an idle computer: the call, and for each operation of
# the equations of motion, each evaluation of them and each entry of a state
ARC_SECONDS, OPERATION_SECONDS = 5e-5, 6e-10


class SwitchingTimes:
    """Words of extreme inputs, each made as short as it can be.

    Obstacles and limits of states are looked at in the end: words that break them are dropped.

    Args:
        problem: The planning problem, of a driftless machine.
        generator: Draws words and first durations.
        cancelled: Whether to give up.
        below: Duration in [s] that motions must be shorter than, finite.
    """

    def __init__(
        self,
        problem: PlanningTask,
        generator: np.random.Generator,
        cancelled: Callable[[], bool],
        below: float,
    ) -> None:
        self._problem, self._generator = problem, generator
        self._cancelled, self._below = cancelled, below
        self._task = TrajectoryProblem(problem, 0.0, cancelled=cancelled)

    def next(self) -> Trajectory | None:
        """Return the shortest motion of some words into the goal's centre, None if there is none.

        Its steps are as long as those of the problem at most, and differ from arc to arc.
        """
        best: Trajectory | None = None
        for _ in range(GUESS.words):
            if self._cancelled():
                break
            word = self._word()
            durations = self._shortest(word)
            if durations is None or not durations.sum() < (best.duration if best else self._below):
                continue
            motion = motion_along(self._task, word, durations)
            if motion is not None:
                best = motion
        return best

    def _word(self) -> Array:
        """Draw inputs at a limit or at rest, none twice in a row, shape (arcs, nu)."""
        model, generator = self._problem.model, self._generator
        kinds = np.column_stack([model.control_bounds, model.null_control()])
        word: list[Array] = []
        while len(word) < GUESS.arcs:
            letter = kinds[np.arange(model.nu), generator.integers(3, size=model.nu)]
            idle = not model.f(self._problem.start, letter).any()
            if not idle and not (word and np.array_equal(letter, word[-1])):
                word.append(letter)
        return np.array(word)

    def _shortest(self, word: Array) -> Array | None:
        """Return durations (arcs,) of the least sum, in [s], that end in the goal's centre."""
        first = self._generator.dirichlet(np.ones(len(word))) * self._below
        arcs = _Arcs(self._problem, word, covering_steps(self._below, self._problem.step))
        ends = GoalConstraint(self._problem, arcs.end(first)[0])

        def missed(d: Array) -> Array:
            return ends.residual(arcs.end(d)[0])

        def slope(d: Array) -> Array:
            x, by_duration = arcs.end(d)
            return np.asarray(ends.jacobian(x) @ by_duration)

        found = scipy.optimize.minimize(
            np.sum, first, jac=np.ones_like, method="SLSQP",
            bounds=[(0.0, self._below)] * len(word),
            constraints={"type": "eq", "fun": missed, "jac": slope},
            options={"maxiter": GUESS.word_iterations},
        )  # fmt: skip
        exact = np.abs(missed(found.x)).max() < GUESS.few_knots_tolerance
        return np.maximum(found.x, 0.0) if exact else None


def motion_along(task: TrajectoryProblem, word: Array, durations: Array) -> Trajectory | None:
    """Return the true motion under constant inputs in turn, if it breaks nothing.

    Args:
        task: What must not be broken; the motion must end in the goal's centre.
        word: The inputs, shape (arcs, nu).
        durations: Of each, in [s], shape (arcs,); arcs of no time are left out.
    """
    problem, spans, inputs = task.problem, [], []
    for u, seconds in zip(word, durations.tolist(), strict=True):
        if seconds > GUESS.few_knots_tolerance * problem.step:
            count = max(covering_steps(seconds, problem.step), 1)
            spans += [seconds / count] * count
            inputs += [u] * count
    if not spans:
        return None
    t = np.concatenate([[0.0], np.cumsum(spans)])
    try:
        made = resimulate(problem, t, np.array(inputs))
    except DivergedError:
        return None
    fine = meets_centre(problem, made.x[-1]) and satisfies_all(task, made)
    return made if fine else None


class _Arcs:
    """Where a word leads, and how that depends on the durations of its arcs.

    Args:
        word: Inputs, shape (arcs, nu).
        substeps: Steps of the problem that all arcs last together, about.
    """

    def __init__(self, problem: PlanningTask, word: Array, substeps: int) -> None:
        substeps = math.ceil(substeps / len(word))  # of order 8, since one arc may last longest
        self._step = StepSensitivities(problem.model, DOP853, substeps)
        self._start, self._word = problem.start, word
        each = self._step.evaluations * problem.model.nx
        self._seconds = ARC_SECONDS + each * problem.model.operations * OPERATION_SECONDS
        self._known: tuple[Array, Array, Array] | None = None

    def end(self, durations: Array) -> tuple[Array, Array]:
        """Return the last state (nx,) and its derivatives by the durations (nx, arcs)."""
        if self._known is not None and np.array_equal(self._known[0], durations):
            return self._known[1:]
        x, count = self._start, len(self._word)
        charge(count * self._seconds)
        by_duration = np.zeros((len(x), count))
        for k, seconds in enumerate(durations.tolist()):
            after, tangents = self._step.linearized(
                x[None], self._word[k : k + 1], max(seconds, 0.0)
            )
            x = after[0]
            by_duration[:, :k] = tangents[0, :, : len(x)] @ by_duration[:, :k]
            by_duration[:, k] = tangents[0, :, -1]
        self._known = durations.copy(), x, by_duration
        return x, by_duration
