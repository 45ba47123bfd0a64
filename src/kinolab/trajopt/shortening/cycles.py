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

from kinolab.steering.cyclic_coordinates import ignorable
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.problem import Task
from kinolab.trajopt.segment_problem import straight
from kinolab.trajopt.segments import FEWEST, Pieces
from kinolab.trajopt.variable_step_motion import Course

Array: TypeAlias = NDArray[np.float64]

PLACES = 300  # of a motion that are compared, at most
APART = 5  # steps between two of them, at least
MARGIN = 50  # steps before and after a loop over which its gap is spread
SHORTEST = 20  # steps of a loop that is worth it
GAP = 0.16  # times the length of a loop: how far apart its ends may be
ALIKE = 0.1  # of the way that a margin takes on average: gaps below are as good as none
SMALL = 1.5  # power of a gap that counts against a loop, where its duration counts for it
NEIGHBOURS = 4  # places by which the ends of two loops differ in all that count as the same
KNOTS = 40  # of a guess, at most
FAILURES = 8  # in a row, after which no more are tried


class Splices:
    """Looks for loops.

    Args:
        task: The problem that the whole motion solves.
        pieces: Makes motions of guesses.
        late: Whether to stop.
    """

    def __init__(self, task: Task, pieces: Pieces, late: Callable[[], bool]) -> None:
        self._problem, self._pieces, self._late = task.problem, pieces, late
        self._matters = ~ignorable(task.problem)

    def taken(self, course: Course) -> Course:
        """Return a motion that is shorter or the same."""
        while not self._late():
            shorter = self._once(course)
            if shorter is None:
                break
            course = shorter
        return course

    def _once(self, course: Course) -> Course | None:
        """Return a motion with one loop less."""
        t, margin = course.times, MARGIN * self._problem.step
        for tried, (begin, end) in enumerate(self._loops(course)):
            if tried == FAILURES or self._late():
                break
            before = int(np.searchsorted(t, t[begin] - margin))
            after = min(int(np.searchsorted(t, t[end] + margin)), len(t) - 1)
            if begin - before + after - end < FEWEST:
                continue  # too few steps are left to take up the gap
            given, last = course.piece(before, after), after == len(course.spans)
            guess = self._spliced(given, begin - before, end - before)
            piece = self._pieces.along(guess, given, last=last)
            if piece is not None:
                return course.with_piece(before, after, piece, self._pieces.space)
        return None

    def _spliced(self, course: Course, begin: int, end: int) -> Knots:
        """Return a motion that leaves a loop out, its gap spread over all that is left."""
        before, after = course.piece(0, begin), course.piece(end, len(course.spans))
        spans = np.concatenate([before.spans, after.spans])
        times = np.concatenate([[0.0], np.cumsum(spans)])
        share = (times / times[-1])[:, None]
        here = before.x[-1]
        there = straight(self._problem, here, after.x[0])[1]
        second = self._pieces.space.carried(after.x, there)
        x = np.vstack([before.x, second[1:]])
        x[: begin + 1] += share[: begin + 1] * (there - here)
        x[begin + 1 :] -= (1 - share[begin + 1 :]) * (there - here)
        u = np.vstack([before.u, after.u])
        return resampled(times, x, u, min(KNOTS, len(spans)), self._pieces.space)

    def _loops(self, course: Course) -> Iterator[tuple[int, int]]:
        """Yield the ends of loops, those that take long and end near where they begin first."""
        t, step = course.times, self._problem.step
        apart = max(APART * step, t[-1] / PLACES)
        places = np.unique(np.minimum(np.searchsorted(t, np.arange(0, t[-1], apart)), len(t) - 1))
        gap, taken = self._gaps(course.x[places]), t[places] - t[places][:, None]
        way = np.concatenate([[0.0], np.cumsum(np.diagonal(gap, 1))])
        length = way - way[:, None]
        alike = ALIKE * MARGIN * step * way[-1] / t[-1]
        loops = (taken >= SHORTEST * step) & (gap <= GAP * length)
        worth = np.where(loops, taken / (gap + alike) ** SMALL, 0.0)
        while worth.any():
            i, j = np.unravel_index(int(worth.argmax()), worth.shape)
            yield int(places[i]), int(places[j])
            near = slice(max(0, i - NEIGHBOURS), i + NEIGHBOURS + 1)
            worth[near, max(0, j - NEIGHBOURS) : j + NEIGHBOURS + 1] = 0.0

    def _gaps(self, x: Array) -> Array:
        """Return the weighted distance of each state from each other one, shape (m, m)."""
        problem = self._problem
        counted = np.where(self._matters, problem.weights, 0.0)
        return self._pieces.space.distance(x[:, None], x[None], counted)
