"""A long motion made shorter piece by piece, from its beginning to its end.

Each piece is a small problem between two states of the motion, so that going through all of it
takes time in proportion to its length. Pieces overlap by half from one sweep to the next. They get
longer as long as that works, and shorter where inputs that are held for so long follow nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.segments import Segments
from kinolab.trajopt.variable_step_motion import VariableStepMotion

WINDOW_KNOTS = (20, 40)  # of a piece in the first sweep and in later ones, when motions are quick
STEPS_PER_KNOT = 16.0  # steps of the problem between two knots of a piece at first
SHORTEST, LONGEST = 2.0, 32.0  # the same, at least and at most
LONGER, SHORTER = 1.3, 0.5  # times as long pieces after one that worked, and after one that did not
MIN_REMAINDER = 1 / 3  # share of a piece that is no piece of its own at the end of a motion


class SlidingWindow:
    """Sweeps along a motion.

    Args:
        task: The problem that the whole motion solves.
        pieces: Gives quicker ones.
        cancelled: Whether to stop.
    """

    def __init__(
        self, task: TrajectoryProblem, pieces: Segments, cancelled: Callable[[], bool]
    ) -> None:
        self._step, self._pieces, self._late = task.problem.step, pieces, cancelled
        self._held, self._sweeps = STEPS_PER_KNOT, 0

    def sweep(self, course: VariableStepMotion) -> VariableStepMotion:
        """Return a motion that is shorter or the same."""
        begin, fraction = 0, 0.5 if self._sweeps % 2 else 1.0
        knots = WINDOW_KNOTS[min(self._sweeps, len(WINDOW_KNOTS) - 1)]
        self._sweeps += 1
        while begin < len(course.spans) and not self._late():
            end = self._end(course, begin, fraction * knots * self._held * self._step)
            given, last = course.piece(begin, end), end == len(course.spans)
            piece = self._pieces.quicker(given, knots, last=last)
            if piece is not None:
                course = course.with_piece(begin, end, piece, self._pieces.space)
                begin, fraction = begin + len(piece.spans), 1.0
                self._held = min(LONGER * self._held, LONGEST)
            elif self._held > SHORTEST:
                self._held = max(SHORTER * self._held, SHORTEST)
            else:
                begin, fraction = end, 1.0
        return course

    def _end(self, course: VariableStepMotion, begin: int, length: float) -> int:
        """Return where a piece of about a length in [s] ends."""
        t = course.times
        end = min(int(np.searchsorted(t, t[begin] + length)), len(t) - 1)
        return len(t) - 1 if t[-1] - t[end] < MIN_REMAINDER * length else end
