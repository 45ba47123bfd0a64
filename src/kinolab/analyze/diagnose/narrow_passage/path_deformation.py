"""Smooth random deformations of a configuration path, measured in metres of motion."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

SIZES = (2e-4, 0.3)  # [m] of deformations, across it
CONSTANT_ANGLE_PROBABILITY = 0.2  # probability that it makes an angle constant, at any value


class PathDeformation:
    """Deforms configuration paths of one machine.

    Args:
        reach: Displacement of the machine per unit of each coordinate, in [m], shape (nx,).

    Attributes:
        entries: Indices of the coordinates that move it.
    """

    def __init__(self, problem: PlanningTask, reach: Array) -> None:
        self._reach, self._circular = reach, problem.circular
        self._space = problem.space
        self.entries = np.flatnonzero(reach)
        self._angles = [j for j, i in enumerate(self.entries) if problem.circular[i]]

    def filled(self, path: Array, spacing: float) -> Array:
        """Return a path resampled evenly, at a spacing in [m] or a little less."""
        marks = self.marks(path)
        count = max(int(np.ceil(marks[-1] / spacing)), 1)
        steps = np.array([self.step(a, b) for a, b in pairwise(path)])
        along = np.linspace(0.0, marks[-1], count + 1)
        k = np.clip(np.searchsorted(marks, along, side="right") - 1, 0, len(steps) - 1)
        fraction = (along - marks[k]) / np.maximum(marks[k + 1] - marks[k], 1e-12)
        return self._space.retract(path[k], fraction[:, None] * steps[k])

    def marks(self, path: Array) -> Array:
        """Return the arc lengths of a path's states, in [m], shape (n,)."""
        steps = [self.step(a, b) * self._reach for a, b in pairwise(path)]
        return np.concatenate([[0.0], np.cumsum(np.linalg.norm(steps, axis=1))])

    def step(self, a: Array, b: Array) -> Array:
        """Return the difference of two states, shape (nx,), angles wrapped."""
        return self._space.difference(a, b)

    def shifted(self, states: Array, shift: Array) -> Array:
        """Return states displaced in each coordinate by lengths in [m], shape (n, entries)."""
        moved = states.copy()
        moved[:, self.entries] += shift / self._reach[self.entries]
        return self._space.unit(moved)

    def deform(self, band: Array, marks: Array, k: int, draw: np.random.Generator) -> Array:
        """Return a random deformation around state k, in [m], shape (n, entries)."""
        width = 10 ** draw.uniform(*np.log10((0.03, 2.0)))  # [m] of deformations, along the path
        size = 10 ** draw.uniform(*np.log10((SIZES[0], min(SIZES[1], width))))
        push = draw.normal(size=len(self.entries)) * size
        kind = draw.random()
        if kind < CONSTANT_ANGLE_PROBABILITY and self._angles:
            j, value = int(draw.choice(self._angles)), draw.uniform(-np.pi, np.pi)
            # [m] along the path over which it stays
            return self._flat(band, marks, k, 10 ** draw.uniform(*np.log10((0.2, 2.0))), j, value)
        # 0.2: probability that it makes a coordinate constant instead
        if kind < CONSTANT_ANGLE_PROBABILITY + 0.2:
            j = int(draw.integers(len(self.entries)))
            value = band[k, self.entries[j]] + push[j] / self._reach[self.entries[j]]
            return self._flat(band, marks, k, width, j, value)
        push *= draw.random(len(push)) < 0.6  # probability that a deformation involves a coordinate
        fraction = np.exp(-(((marks - marks[k]) / width) ** 2)) * _taper(marks)
        return np.asarray(fraction[:, None] * push)

    def _flat(self, band: Array, marks: Array, k: int, width: float, j: int, value: float) -> Array:
        """Return the deformation that makes one coordinate constant around a state.

        Args:
            band: States, shape (n, nx).
            marks: Arc lengths of the states, in [m], shape (n,).
            width: Extent in [m] on both sides of it.
            j: Index into ``entries``.
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
    """Return the fraction of a deformation kept at each mark, 0 at the ends, shape (n,)."""
    # 0.1 [m] from the path's ends over which deformations fade out
    taper: Array = np.clip(np.minimum(marks, marks[-1] - marks) / 0.1, 0.0, 1.0)
    return taper
