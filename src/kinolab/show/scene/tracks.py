"""Animated quantities and rates: positions and rotations of bodies and joints, ends of cables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics import Model
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import of_poses
from kinolab.show.scene.curves import turn_rates

FD_STEP = 1e-5  # [s] of finite differences


@dataclass(frozen=True, eq=False)
class Track:
    """One animated quantity, at several states.

    Attributes:
        values: Shape (n, d).
        rates: Their rates of change, shape (n, d).
        turns: Whether the values are unit quaternions; q and -q are equivalent.
    """

    values: Array
    rates: Array
    turns: bool = False

    @property
    def turning(self) -> Array:
        """Angular speed in [rad/s], shape (n,); 0 if not a rotation."""
        return np.asarray(2.0 * self.turns * np.linalg.norm(self.rates, axis=1))

    def toward(self, other: Track) -> Track:
        """The same track, with quaternion signs nearest to another track's."""
        if not self.turns:
            return self
        sign = np.where(np.sum(self.values * other.values, axis=1, keepdims=True) < 0.0, -1.0, 1.0)
        return Track(sign * self.values, sign * self.rates, turns=True)

    def apart(self, values: Array) -> Array:
        """Distance of other values (n, d) from these, shape (n,), in [m] or [rad]."""
        if not self.turns:
            return np.asarray(np.abs(values - self.values).max(axis=1))
        unit = values / np.linalg.norm(values, axis=1, keepdims=True)
        nearer = np.minimum(
            np.linalg.norm(unit - self.values, axis=1), np.linalg.norm(unit + self.values, axis=1)
        )
        return np.asarray(2.0 * nearer)


def tracks(model: Model, x: Array, rate: Array) -> list[Track]:
    """Return the tracks at states (n, nx) with rates (n, nx).

    First the positions of all bodies and joints, then their rotations, then all cables together if
    any.
    """

    def frames(states: Array) -> Array:
        joints = model.machine.joints.at(states, model.coordinate_names)
        return np.concatenate([model.frames(states), joints], axis=1)

    poses, slopes = frames(x), _slope(frames, x, rate)
    q = of_poses(poses)
    w = turn_rates(q, poses, slopes)
    count = range(poses.shape[1])
    found = [Track(poses[:, i, 3::4], slopes[:, i, 3::4]) for i in count]
    found += [Track(q[:, i], w[:, i], turns=True) for i in count]
    if model.machine.cables:
        ends, pulls = model.cables(x), _slope(model.cables, x, rate)
        found.append(Track(ends.reshape(len(x), -1), pulls.reshape(len(x), -1)))
    return found


def _slope(function: Callable[[Array], Array], x: Array, rate: Array) -> Array:
    """Return the rate of change of a function of the state, as a central difference."""
    nudge = FD_STEP * rate
    return (function(x + nudge) - function(x - nudge)) / (2.0 * FD_STEP)
