"""What moves, number by number: places and turns of bodies, ends of cables, and their rates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics import Model
from kinolab.numerics.arrays import Array
from kinolab.show.page.curves import quaternions, turn_rates

FD_STEP = 1e-5  # [s] over which rates are taken as differences


@dataclass(frozen=True, eq=False)
class Track:
    """One thing that moves, at several states.

    Attributes:
        values: Shape (n, d).
        rates: How they change with time, shape (n, d).
        turns: Whether the values are unit quaternions, of which q and -q are the same.
    """

    values: Array
    rates: Array
    turns: bool = False

    @property
    def turning(self) -> Array:
        """How fast it turns in [rad/s], shape (n,); 0 for what does not turn."""
        return np.asarray(2.0 * self.turns * np.linalg.norm(self.rates, axis=1))

    def toward(self, other: Track) -> Track:
        """The same, each quaternion the one of two that is nearer to another channel's."""
        if not self.turns:
            return self
        sign = np.where(np.sum(self.values * other.values, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
        return Track(sign * self.values, sign * self.rates, turns=True)

    def apart(self, values: Array) -> Array:
        """How far other values (n, d) are from these, shape (n,), in [m] or [rad]."""
        if not self.turns:
            return np.asarray(np.abs(values - self.values).max(axis=1))
        unit = values / np.linalg.norm(values, axis=1, keepdims=True)
        nearer = np.minimum(
            np.linalg.norm(unit - self.values, axis=1), np.linalg.norm(unit + self.values, axis=1)
        )
        return np.asarray(2.0 * nearer)


def tracks(model: Model, x: Array, rate: Array) -> list[Track]:
    """Return what moves at states (n, nx) that change at a rate (n, nx).

    First the places of all bodies, then their turns, then all cables together if there are any.
    """
    poses, slopes = model.frames(x), _slope(model.frames, x, rate)
    q = quaternions(poses)
    w = turn_rates(q, poses, slopes)
    bodies = range(poses.shape[1])
    found = [Track(poses[:, i, 3::4], slopes[:, i, 3::4]) for i in bodies]
    found += [Track(q[:, i], w[:, i], turns=True) for i in bodies]
    if model.system.cables:
        ends, pulls = model.cables(x), _slope(model.cables, x, rate)
        found.append(Track(ends.reshape(len(x), -1), pulls.reshape(len(x), -1)))
    return found


def _slope(function: Callable[[Array], Array], x: Array, rate: Array) -> Array:
    """Return the rate of change of a function of the state, as a central difference."""
    nudge = FD_STEP * rate
    return (function(x + nudge) - function(x - nudge)) / (2.0 * FD_STEP)
