"""What a machine does over whole boxes of states, enclosed by interval arithmetic.

Formulas of a machine are kept on disk as data since it was compiled, so that this needs no symbols.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.mode_formulas import MOST_OPERATIONS, ModeFormulas
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.dynamics.model.model import Model
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray


class Enclosures:
    """Bounds of what a machine does over boxes of states.

    Args:
        model: The machine; without its feedback.
    """

    def __init__(self, model: Model) -> None:
        self._model = model.plant
        self._modes = self._model.formulas

    def speed(self, x: IntervalArray, u: Array) -> Array:
        """Return bounds on the speed of all points, in [m/s], shape (m,); infinite at a jump.

        Args:
            x: Boxes of states, shape (m, nx); a box lies within one mode.
            u: Inputs of each, shape (m, nu).
        """
        bounds = self._enclosed(lambda mode: mode.speeds, x, u).high
        signs = self._enclosed(lambda mode: mode.signs, x, u)
        jumps = np.any(np.sign(signs.low) != np.sign(signs.high), axis=1)
        return np.where(jumps, np.inf, bounds.max(axis=1, initial=0.0))

    def requirements(self, x: IntervalArray, u: Array) -> tuple[IntervalArray, Array]:
        """Return the machine's requirements over boxes, and how large their terms are at least.

        Args:
            x: As ``speed``.
            u: As ``speed``.

        Returns:
            Enclosures, from minus infinity where one may be undefined, and sizes, each of shape
            (m, number of requirements).
        """
        shape = len(u), len(self._modes[0].requirements.ends)
        low, high, sizes = (np.zeros(shape) for _ in range(3))
        for mode, rows in self._by_mode(x.low):
            found = mode.requirements.enclose_with_sizes(self._values(mode, x, u, rows))
            for i, (one, size) in enumerate(zip(*found, strict=True)):
                low[rows, i], high[rows, i], sizes[rows, i] = one.low, one.high, size
        return IntervalArray(low, high), sizes

    @property
    def encloses_requirements(self) -> bool:
        """Whether the requirements are short enough for their bounds to mean anything."""
        longest = max(len(mode.requirements.operations) for mode in self._modes)
        return longest <= MOST_OPERATIONS

    def frames(self, x: IntervalArray, u: Array) -> IntervalArray:
        """Return the rows of [R | p] of all bodies over boxes, shape (m, bodies, 12).

        Args:
            x: As ``speed``.
            u: As ``speed``.
        """
        found = self._enclosed(lambda mode: mode.frames, x, u)
        return IntervalArray(found.low.reshape(len(u), -1, 12), found.high.reshape(len(u), -1, 12))

    def velocities(self, x: IntervalArray, u: Array) -> IntervalArray:
        """Return all velocities over boxes, shape (m, number of velocities).

        Args:
            x: As ``speed``.
            u: As ``speed``.
        """
        return self._enclosed(lambda mode: mode.velocities, x, u)

    def _enclosed(
        self, which: Callable[[ModeFormulas], Formulas], x: IntervalArray, u: Array
    ) -> IntervalArray:
        """Enclose formulas over boxes."""
        count = max(len(which(mode).ends) for mode in self._modes)
        low, high = np.zeros((len(u), count)), np.zeros((len(u), count))
        for mode, rows in self._by_mode(x.low):
            for i, one in enumerate(which(mode).enclose(self._values(mode, x, u, rows))):
                low[rows, i], high[rows, i] = one.low, one.high
        return IntervalArray(low, high)

    def _by_mode(self, x: Array) -> Iterator[tuple[ModeFormulas, NDArray[np.intp]]]:
        """Yield the modes that states (m, nx) are in, with their rows."""
        of = np.round(x[:, -1]) if len(self._modes) > 1 else np.zeros(len(x))
        for k in np.unique(of):
            yield self._modes[int(k)], np.flatnonzero(of == k)

    def _values(
        self, mode: ModeFormulas, x: IntervalArray, u: Array, rows: NDArray[np.intp]
    ) -> dict[str, IntervalArray]:
        parameters = map(intervals.point, self._model.parameter_vector())
        values = dict(zip(mode.parameters, parameters, strict=True))
        values |= zip(mode.inputs, map(intervals.point, u[rows].T), strict=True)
        ends = zip(x.low[rows].T, x.high[rows].T, strict=True)
        return values | dict(zip(mode.state, (IntervalArray(*pair) for pair in ends), strict=False))
