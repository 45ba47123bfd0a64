"""A way as a band: states in a row that bend smoothly, measured in metres of motion."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

TAPER_LENGTH = 0.1  # [m] from its ends in which a band bends less and less
WIDTHS = (0.03, 2.0)  # [m] of bends, along the band
SIZES = (2e-4, 0.3)  # [m] of bends, across it
COORDINATE_PROBABILITY = 0.6  # probability that a bend involves a coordinate
CONSTANT_PROBABILITY = 0.2  # probability that a bend makes a coordinate constant instead
CONSTANT_ANGLE_PROBABILITY = 0.2  # probability that it makes an angle constant, at any value
TURNS = (0.2, 2.0)  # [m] along the band in which that is so


class PathDeformation:
    """What one machine's bands have in common.

    Args:
        problem: The machine.
        reach: Metres that each coordinate moves the machine by, per unit, shape (nx,).

    Attributes:
        entries: The coordinates that move it.
    """

    def __init__(self, problem: PlanningTask, reach: Array) -> None:
        self._reach, self._circular = reach, problem.circular
        self._space = problem.space
        self.entries = np.flatnonzero(reach)
        self._angles = [j for j, i in enumerate(self.entries) if problem.circular[i]]

    def filled(self, path: Array, spacing: float) -> Array:
        """Return a way with states evenly apart, by a spacing in [m] or a little less."""
        marks = self.marks(path)
        count = max(int(np.ceil(marks[-1] / spacing)), 1)
        steps = np.array([self.step(a, b) for a, b in pairwise(path)])
        along = np.linspace(0.0, marks[-1], count + 1)
        k = np.clip(np.searchsorted(marks, along, side="right") - 1, 0, len(steps) - 1)
        fraction = (along - marks[k]) / np.maximum(marks[k + 1] - marks[k], 1e-12)
        return self._space.retract(path[k], fraction[:, None] * steps[k])

    def marks(self, path: Array) -> Array:
        """Return how far along the way its states are, in [m], shape (n,)."""
        steps = [self.step(a, b) * self._reach for a, b in pairwise(path)]
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])

    def step(self, a: Array, b: Array) -> Array:
        """Return the difference of two states, angles the short way round."""
        return self._space.difference(a, b)

    def shifted(self, states: Array, shift: Array) -> Array:
        """Return states moved in every coordinate by lengths in [m], shape (n, entries)."""
        moved = states.copy()
        moved[:, self.entries] += shift / self._reach[self.entries]
        return self._space.unit(moved)

    def deform(self, band: Array, marks: Array, k: int, draw: np.random.Generator) -> Array:
        """Return a random bend around a state, in [m], shape (n, entries)."""
        width = 10 ** draw.uniform(*np.log10(WIDTHS))
        size = 10 ** draw.uniform(*np.log10((SIZES[0], min(SIZES[1], width))))
        push = draw.normal(size=len(self.entries)) * size
        kind = draw.random()
        if kind < CONSTANT_ANGLE_PROBABILITY and self._angles:
            j, value = int(draw.choice(self._angles)), draw.uniform(-np.pi, np.pi)
            return self._flat(band, marks, k, 10 ** draw.uniform(*np.log10(TURNS)), j, value)
        if kind < CONSTANT_ANGLE_PROBABILITY + CONSTANT_PROBABILITY:
            j = int(draw.integers(len(self.entries)))
            value = band[k, self.entries[j]] + push[j] / self._reach[self.entries[j]]
            return self._flat(band, marks, k, width, j, value)
        push *= draw.random(len(push)) < COORDINATE_PROBABILITY
        fraction = np.exp(-(((marks - marks[k]) / width) ** 2)) * _taper(marks)
        return np.asarray(fraction[:, None] * push)

    def _flat(self, band: Array, marks: Array, k: int, width: float, j: int, value: float) -> Array:
        """Return the bend that makes one coordinate constant around a state.

        Args:
            band: States, shape (n, nx).
            marks: How far along the band they are, in [m].
            k: The state.
            width: In [m] on both sides of it.
            j: Which of ``entries``.
            value: Of the coordinate.
        """
        i = self.entries[j]
        values = np.unwrap(band[:, i]) if self._circular[i] else band[:, i]
        turn = value - values[k]
        if self._circular[i]:
            turn = wrapped(turn)
        fraction = np.exp(-(((marks - marks[k]) / width) ** 4)) * _taper(marks)
        shift = np.zeros((len(band), len(self.entries)))
        shift[:, j] = fraction * (values[k] + turn - values) * self._reach[i]
        return shift


def _taper(marks: Array) -> Array:
    """Return how much of a bend is left at each mark, so that the ends stay."""
    taper: Array = np.clip(np.minimum(marks, marks[-1] - marks) / TAPER_LENGTH, 0.0, 1.0)
    return taper
