"""Segments of a motion with zero-order-hold inputs, and states along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

SUBSTEPS = 8  # of the integrator per segment, or part of one


@dataclass(frozen=True, eq=False)
class Branches:
    """Segments of a motion, one per row.

    Attributes:
        begin: Times in [s], shape (n,).
        end: Times in [s], shape (n,).
        x: States at the beginning, shape (n, nx).
        y: States at the end, shape (n, nx).
        u: Inputs held between them, shape (n, nu).
    """

    begin: Array
    end: Array
    x: Array
    y: Array
    u: Array

    def __len__(self) -> int:
        return len(self.begin)

    @property
    def length(self) -> Array:
        """Durations in [s], shape (n,)."""
        return self.end - self.begin

    def chosen(self, rows: NDArray[np.bool_] | NDArray[np.intp]) -> Branches:
        """Return selected segments."""
        return Branches(*(getattr(self, field.name)[rows] for field in fields(self)))

    def halved(self, middle: Array) -> Branches:
        """Return all first halves, then all second ones; ``middle`` (n, nx) joins them."""
        time = 0.5 * (self.begin + self.end)
        first = Branches(self.begin, time, self.x, middle, self.u)
        return Branches.joined([first, Branches(time, self.end, middle, self.y, self.u)])

    @staticmethod
    def joined(parts: Sequence[Branches]) -> Branches:
        """Concatenate several collections of segments."""
        names = [field.name for field in fields(Branches)]
        return Branches(
            *(np.concatenate([getattr(part, name) for part in parts]) for name in names)
        )


class BranchPaths:
    """States of a machine along segments of its motion, according to [integration]."""

    def __init__(self, problem: PlanningTask) -> None:
        self.model, settings = problem.model.plant, problem.scenario.integration
        self._straight = settings.truth == "discrete"  # a discrete map is undefined between steps
        self._method = settings.accurate_method

    def state(self, pieces: Branches, fraction: float) -> Array:
        """Return the states at a fraction of each segment, shape (n, nx)."""
        if self._straight:
            return self._chord(pieces, fraction)
        spans = fraction * pieces.length
        return self.model.step(pieces.x, pieces.u, spans, method=self._method, substeps=SUBSTEPS)

    def rates(self, pieces: Branches) -> tuple[Array, Array]:
        """Return the state rates at the beginning and at the end, shape (n, nx) each."""
        if self._straight:
            slope = (pieces.y - pieces.x) / pieces.length[:, None]
            return slope, slope
        return self.model.f(pieces.x, pieces.u), self.model.f(pieces.y, pieces.u)

    def _chord(self, pieces: Branches, fraction: float) -> Array:
        return self.model.space.unit(pieces.x + fraction * (pieces.y - pieces.x))
