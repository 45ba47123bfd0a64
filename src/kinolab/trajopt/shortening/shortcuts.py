"""Detours left out: direct ways between two states of a motion, the largest gain first.

Source: Geraerts, Overmars, Creating high-quality paths for motion planning, IJRR 26(8), 2007.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations, cycle

import numpy as np

from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.options import SHORT
from kinolab.trajopt.segments import Segments
from kinolab.trajopt.shortening.connection_guesses import ConnectionGuesses
from kinolab.trajopt.variable_step_motion import VariableStepMotion


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
        self._bridges, self._places = ConnectionGuesses(task.problem), cycle(SHORT.shortcut_samples)

    def with_shortcuts(self, course: VariableStepMotion) -> VariableStepMotion:
        """Return a motion that is shorter or the same."""
        while not self._late():
            shorter = self._once(course)
            if shorter is None:
                break
            little = shorter.duration > (1 - SHORT.small_gain) * course.duration
            course = shorter
            if little:
                break
        return course

    def _once(self, course: VariableStepMotion) -> VariableStepMotion | None:
        """Return a motion with one detour less."""
        failures, slow, places = 0, 0, next(self._places)
        for begin, end in self._pairs(course, places):
            if (
                failures == SHORT.max_failed_shortcuts
                or slow == SHORT.max_slow_shortcuts
                or self._late()
            ):
                break
            given, last = course.piece(begin, end), end == len(course.spans)
            for guess in self._bridges.between(given.x[0], given.x[-1], SHORT.shortcut_knots):
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
            if least < SHORT.promised_duration * duration:
                gains.append((least - duration, begin, end))
        for _, begin, end in sorted(gains):
            yield begin, end
