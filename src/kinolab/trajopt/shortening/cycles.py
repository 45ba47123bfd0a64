"""Loops left out: where a motion comes back to about the same state, what lies between goes.

Guesses keep the motion before and after a loop and spread the gap between its ends over both, so
that machines too are served that nobody knows how to steer: they go on as they did.

Source: Frazzoli, Dahleh, Feron, Maneuver-based motion planning for nonlinear systems with
symmetries, IEEE Transactions on Robotics 21(6), 2005 (the idea that pieces of motions fit together
where their ends are alike).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.options import SHORT
from kinolab.trajopt.segments import Segments, straight
from kinolab.trajopt.variable_step_motion import VariableStepMotion

Array: TypeAlias = NDArray[np.float64]


class CycleRemoval:
    """Looks for loops.

    Args:
        task: The problem that the whole motion solves.
        pieces: Makes motions of guesses.
        cancelled: Whether to stop.
    """

    def __init__(
        self, task: TrajectoryProblem, pieces: Segments, cancelled: Callable[[], bool]
    ) -> None:
        self._problem, self._pieces, self._late = task.problem, pieces, cancelled
        self._matters = ~cyclic_coordinates(task.problem)

    def without_cycles(self, course: VariableStepMotion) -> VariableStepMotion:
        """Return a motion that is shorter or the same."""
        while not self._late():
            shorter = self._once(course)
            if shorter is None:
                break
            course = shorter
        return course

    def _once(self, course: VariableStepMotion) -> VariableStepMotion | None:
        """Return a motion with one loop less."""
        t, margin = course.times, SHORT.blend_steps * self._problem.step
        for tried, (begin, end) in enumerate(self._cycles(course)):
            if tried == SHORT.max_failed_cycles or self._late():
                break
            before = int(np.searchsorted(t, t[begin] - margin))
            after = min(int(np.searchsorted(t, t[end] + margin)), len(t) - 1)
            if begin - before + after - end < SHORT.min_steps:
                continue  # too few steps are left to take up the gap
            given, last = course.piece(before, after), after == len(course.spans)
            guess = self._closed_gap(given, begin - before, end - before)
            piece = self._pieces.along(guess, given, last=last)
            if piece is not None:
                return course.with_piece(before, after, piece, self._pieces.space)
        return None

    def _closed_gap(self, course: VariableStepMotion, begin: int, end: int) -> Knots:
        """Return a motion that leaves a loop out, its gap spread over all that is left."""
        before, after = course.piece(0, begin), course.piece(end, len(course.spans))
        spans = np.concatenate([before.spans, after.spans])
        times = np.concatenate([[0.0], np.cumsum(spans)])
        fraction = (times / times[-1])[:, None]
        here = before.x[-1]
        there = straight(self._problem, here, after.x[0])[1]
        second = self._pieces.space.carried(after.x, there)
        x = np.vstack([before.x, second[1:]])
        x[: begin + 1] += fraction[: begin + 1] * (there - here)
        x[begin + 1 :] -= (1 - fraction[begin + 1 :]) * (there - here)
        u = np.vstack([before.u, after.u])
        return resampled(times, x, u, min(SHORT.cycle_knots, len(spans)), self._pieces.space)

    def _cycles(self, course: VariableStepMotion) -> Iterator[tuple[int, int]]:
        """Yield the ends of loops, those that take long and end near where they begin first."""
        t, step = course.times, self._problem.step
        apart = max(SHORT.min_cycle_spacing * step, t[-1] / SHORT.cycle_samples)
        places = np.unique(np.minimum(np.searchsorted(t, np.arange(0, t[-1], apart)), len(t) - 1))
        gap, taken = self._gaps(course.x[places]), t[places] - t[places][:, None]
        path = np.concatenate([[0.0], np.cumsum(np.diagonal(gap, 1))])
        length = path - path[:, None]
        alike = SHORT.negligible_gap * SHORT.blend_steps * step * path[-1] / t[-1]
        loops = (taken >= SHORT.min_cycle_steps * step) & (gap <= SHORT.max_cycle_gap * length)
        worth = np.where(loops, taken / (gap + alike) ** SHORT.gap_exponent, 0.0)
        while worth.any():
            i, j = np.unravel_index(int(worth.argmax()), worth.shape)
            yield int(places[i]), int(places[j])
            near = slice(max(0, i - SHORT.same_cycle_samples), i + SHORT.same_cycle_samples + 1)
            worth[near, max(0, j - SHORT.same_cycle_samples) : j + SHORT.same_cycle_samples + 1] = (
                0.0
            )

    def _gaps(self, x: Array) -> Array:
        """Return the weighted distance of each state from each other one, shape (m, m)."""
        problem = self._problem
        counted = np.where(self._matters, problem.weights, 0.0)
        return self._pieces.space.distance(x[:, None], x[None], counted)
