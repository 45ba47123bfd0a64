"""Inequalities along a trajectory, linearised: what must not become negative."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class LinearInequalities:
    """Margins that must be at least zero, each at a knot or on the way to the next one.

    Attributes:
        knot: Which knot, shape (m,).
        value: Of the margin as a share of what counts as large, shape (m,).
        dx: Derivative with respect to the state there, shape (m, nx).
        dx_next: With respect to the next knot's state, shape (m, nx).
        du: With respect to the inputs held there, shape (m, nu).
    """

    knot: NDArray[np.int64]
    value: Array
    dx: Array
    dx_next: Array
    du: Array

    @property
    def violation(self) -> float:
        """Sum of what is missing."""
        return float(np.maximum(-self.value, 0.0).sum())


def no_inequalities(nx: int, nu: int) -> LinearInequalities:
    """Return no inequality at all."""
    none = np.zeros((0, nx))
    return LinearInequalities(
        np.zeros(0, dtype=np.int64), np.zeros(0), none, none, np.zeros((0, nu))
    )


def stack(parts: Sequence[LinearInequalities]) -> LinearInequalities:
    """Return all inequalities of several kinds."""
    return LinearInequalities(
        np.concatenate([part.knot for part in parts]),
        np.concatenate([part.value for part in parts]),
        np.vstack([part.dx for part in parts]),
        np.vstack([part.dx_next for part in parts]),
        np.vstack([part.du for part in parts]),
    )
