"""Pieces of a motion under inputs that are held, and the machine's way along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

SUBSTEPS = 8  # of the integrator along a piece, or along part of it


@dataclass(frozen=True, eq=False)
class Branches:
    """Pieces of a motion, one per row.

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
        """Return some of the pieces."""
        return Branches(*(getattr(self, field.name)[rows] for field in fields(self)))

    def halved(self, middle: Array) -> Branches:
        """Return all first halves, then all second ones; ``middle`` are the states between."""
        time = 0.5 * (self.begin + self.end)
        first = Branches(self.begin, time, self.x, middle, self.u)
        return Branches.joined([first, Branches(time, self.end, middle, self.y, self.u)])

    @staticmethod
    def joined(parts: Sequence[Branches]) -> Branches:
        """Return the pieces of several collections in one."""
        names = [field.name for field in fields(Branches)]
        return Branches(
            *(np.concatenate([getattr(part, name) for part in parts]) for name in names)
        )


class BranchPaths:
    """Where a machine is along pieces of its motion, as [integration] understands it."""

    def __init__(self, problem: PlanningTask) -> None:
        self.model, settings = problem.model.plant, problem.scenario.integration
        self._straight = settings.truth == "discrete"  # a map says nothing about between
        self._method = settings.accurate_method

    def state(self, pieces: Branches, fraction: float) -> Array:
        """Return the states at a share of each piece, shape (n, nx)."""
        if self._straight:
            return self._chord(pieces, fraction)
        out = np.empty_like(pieces.x)
        for k, (x, u, length) in enumerate(zip(pieces.x, pieces.u, pieces.length, strict=True)):
            span = fraction * float(length)
            out[k] = self.model.step(x, u, span, method=self._method, substeps=SUBSTEPS)
        return out

    def rates(self, pieces: Branches) -> tuple[Array, Array]:
        """Return how the state changes at the beginning and at the end, of shape (n, nx) each."""
        if self._straight:
            slope = (pieces.y - pieces.x) / pieces.length[:, None]
            return slope, slope
        return self.model.f(pieces.x, pieces.u), self.model.f(pieces.y, pieces.u)

    def _chord(self, pieces: Branches, fraction: float) -> Array:
        return self.model.space.unit(pieces.x + fraction * (pieces.y - pieces.x))
