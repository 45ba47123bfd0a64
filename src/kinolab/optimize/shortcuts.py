"""Detours left out: straight ways between two states of a motion, the largest gain first.

Source: Geraerts, Overmars, Creating high-quality paths for motion planning, IJRR 26(8), 2007.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations

import numpy as np

from kinolab.optimize.course import Course
from kinolab.optimize.free_ways import FreeWays
from kinolab.optimize.pieces import Pieces
from kinolab.optimize.task import Task

PLACES = 24  # of a motion between which straight ways are tried
FAILURES = 4  # in a row, after which no more are
GAIN = 0.5  # times the duration of a piece: how quick a straight way must promise to be


class Shortcuts:
    """Looks for straight ways.

    Args:
        task: The problem that the whole motion solves.
        pieces: Makes motions of them.
        late: Whether to stop.
    """

    def __init__(self, task: Task, pieces: Pieces, late: Callable[[], bool]) -> None:
        self._pieces, self._late = pieces, late
        self._ways = FreeWays(task.problem, np.random.default_rng(0))

    def taken(self, course: Course) -> Course:
        """Return a motion that is shorter or the same."""
        while not self._late():
            shorter = self._once(course)
            if shorter is None:
                break
            course = shorter
        return course

    def _once(self, course: Course) -> Course | None:
        """Return a motion with one detour less."""
        failures = 0
        for begin, end in self._pairs(course):
            if failures == FAILURES or self._late():
                break
            given = course.piece(begin, end)
            if not self._ways.is_free(*self._pieces.way(given)):
                continue
            piece = self._pieces.direct(given, last=end == len(course.spans))
            if piece is not None:
                return course.with_piece(begin, end, piece, self._pieces.attitudes)
            failures += 1
        return None

    def _pairs(self, course: Course) -> Iterator[tuple[int, int]]:
        """Yield the ends of pieces that a straight way makes shorter, the largest gain first."""
        t = course.times
        even = np.searchsorted(t, np.linspace(0, t[-1], PLACES + 1))
        places = np.unique(np.minimum(even, len(t) - 1)).tolist()
        gains = []
        for begin, end in combinations(places, 2):
            least = self._pieces.least(self._pieces.way(course.piece(begin, end)))
            duration = float(t[end] - t[begin])
            if least < GAIN * duration:
                gains.append((least - duration, begin, end))
        for _, begin, end in sorted(gains):
            yield begin, end
