"""The unknowns: states at knots, inputs between them, and one step length for all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.state_space import StateSpace

Array: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Knots:
    """States and inputs that need not belong together yet.

    Attributes:
        x: States, shape (N+1, nx).
        u: Inputs held between them, shape (N, nu).
        h: Length of every step in [s].
    """

    x: Array
    u: Array
    h: float

    @property
    def duration(self) -> float:
        """Length in time, in [s]."""
        return len(self.u) * self.h

    def moved(self, dx: Array, du: Array, dh: float) -> Knots:
        """Return knots that differ by so much."""
        return Knots(self.x + dx, self.u + du, self.h + dh)

    def in_steps(self, count: int, space: StateSpace) -> Knots:
        """Return as many steps of the same duration, by ``resampled``."""
        times = self.h * np.arange(len(self.u) + 1.0)
        return resampled(times, self.x, self.u, count, space)


def resampled(t: Array, x: Array, u: Array, count: int, space: StateSpace) -> Knots:
    """Return as many even steps along a motion, stretched in time so that it has its duration.

    States are interpolated on the straight line, inputs are averaged over each step.

    Args:
        t: Times in [s], shape (N+1,).
        x: States, shape (N+1, nx).
        u: Inputs, shape (N, nu).
        count: Number of steps.
        space: Of the states; quaternions come out of unit length.
    """
    times = np.linspace(t[0], t[-1], count + 1)
    states = space.unit(np.column_stack([np.interp(times, t, column) for column in x.T]))
    impulse = np.vstack([np.zeros(u.shape[1]), np.cumsum(u * np.diff(t)[:, None], axis=0)])
    total = np.column_stack([np.interp(times, t, column) for column in impulse.T])
    h = float(t[-1] - t[0]) / count
    held = np.diff(total, axis=0).reshape(count, u.shape[1]) / h
    return Knots(states, held, h)
