"""A long motion made shorter piece by piece, from its beginning to its end.

Each piece is a small problem between two states of the motion, so that going through all of it
takes time in proportion to its length. Pieces overlap by half from one sweep to the next. They get
longer as long as that works, and shorter where inputs that are held for so long follow nothing.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.options import SHORT
from kinolab.trajopt.segments import Segments
from kinolab.trajopt.variable_step_motion import VariableStepMotion


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
        self._held, self._sweeps = SHORT.steps_per_knot, 0

    def sweep(self, course: VariableStepMotion) -> VariableStepMotion:
        """Return a motion that is shorter or the same."""
        begin, fraction = 0, 0.5 if self._sweeps % 2 else 1.0
        knots = SHORT.window_knots[min(self._sweeps, len(SHORT.window_knots) - 1)]
        self._sweeps += 1
        while begin < len(course.spans) and not self._late():
            end = self._end(course, begin, fraction * knots * self._held * self._step)
            given, last = course.piece(begin, end), end == len(course.spans)
            piece = self._pieces.quicker(given, knots, last=last)
            if piece is not None:
                course = course.with_piece(begin, end, piece, self._pieces.space)
                begin, fraction = begin + len(piece.spans), 1.0
                self._held = min(SHORT.window_growth * self._held, SHORT.max_steps_per_knot)
            elif self._held > SHORT.min_steps_per_knot:
                self._held = max(SHORT.window_shrinkage * self._held, SHORT.min_steps_per_knot)
            else:
                begin, fraction = end, 1.0
        return course

    def _end(self, course: VariableStepMotion, begin: int, length: float) -> int:
        """Return where a piece of about a length in [s] ends."""
        t = course.times
        end = min(int(np.searchsorted(t, t[begin] + length)), len(t) - 1)
        return len(t) - 1 if t[-1] - t[end] < SHORT.min_remainder * length else end
