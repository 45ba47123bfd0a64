"""Detours left out: direct ways between two states of a motion, the largest gain first.

Source: Geraerts, Overmars, Creating high-quality paths for motion planning, IJRR 26(8), 2007.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations, cycle

import numpy as np

from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.segments import Segments
from kinolab.trajopt.shortening.connection_guesses import ConnectionGuesses
from kinolab.trajopt.variable_step_motion import VariableStepMotion

MAX_SAMPLES = (24, 31, 27)  # of a motion between which ways are tried, in turn
MAX_SLOW_PATHS = 20  # ways that take longer than what they replace, after which no more are tried
MAX_FAILURES = 5  # in a row, after which no more are
PROMISED_FRACTION = 0.7  # times the duration of a piece: how quick a way must promise to be
MAX_KNOTS = 20  # of a guess, at most
SMALL_GAIN = 0.05  # share of the duration of a gain after which other things may gain more


class Shortcuts:
    """Looks for direct ways.

    Args:
        task: The problem that the whole motion solves.
        pieces: Makes motions of them.
        cancelled: Whether to stop.
    """

    def __init__(
        self, task: TrajectoryProblem, pieces: Segments, cancelled: Callable[[], bool]
    ) -> None:
        self._pieces, self._late = pieces, cancelled
        self._bridges, self._places = ConnectionGuesses(task.problem), cycle(MAX_SAMPLES)

    def with_shortcuts(self, course: VariableStepMotion) -> VariableStepMotion:
        """Return a motion that is shorter or the same."""
        while not self._late():
            shorter = self._once(course)
            if shorter is None:
                break
            little = shorter.duration > (1 - SMALL_GAIN) * course.duration
            course = shorter
            if little:
                break
        return course

    def _once(self, course: VariableStepMotion) -> VariableStepMotion | None:
        """Return a motion with one detour less."""
        failures, slow, places = 0, 0, next(self._places)
        for begin, end in self._pairs(course, places):
            if failures == MAX_FAILURES or slow == MAX_SLOW_PATHS or self._late():
                break
            given, last = course.piece(begin, end), end == len(course.spans)
            for guess in self._bridges.between(given.x[0], given.x[-1], MAX_KNOTS):
                if not guess.duration < given.duration:
                    slow += 1
                    continue
                piece = self._pieces.along(guess, given, last=last)
                if piece is not None:
                    return course.with_piece(begin, end, piece, self._pieces.space)
                failures += 1
        return None

    def _pairs(self, course: VariableStepMotion, places: int) -> Iterator[tuple[int, int]]:
        """Yield the ends of pieces that a direct way may make shorter, the largest gain first."""
        t = course.times
        even = np.searchsorted(t, np.linspace(0, t[-1], places + 1))
        knots = np.unique(np.minimum(even, len(t) - 1)).tolist()
        gains = []
        for begin, end in combinations(knots, 2):
            least = self._bridges.least(course.x[begin], course.x[end])
            duration = float(t[end] - t[begin])
            if least < PROMISED_FRACTION * duration:
                gains.append((least - duration, begin, end))
        for _, begin, end in sorted(gains):
            yield begin, end
