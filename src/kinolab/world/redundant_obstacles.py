"""Which obstacles can be met at all: none that repeats another one, or lies inside of it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.world.geometry import frame_in_world, sizes
from kinolab.world.obstacle import Obstacle

CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


def without_redundant(obstacles: Sequence[Obstacle]) -> tuple[Obstacle, ...]:
    """Leave out what repeats an earlier box, ball or cylinder, or lies inside a larger one.

    Nothing can come near to it without being as near to the other one. Meshes stay, and hide
    nothing; so does a shape of which only the corners of a box around it stick out.
    """
    first: dict[object, int] = {}
    for k, obstacle in enumerate(obstacles):
        first.setdefault(_key(obstacle), k)
    left = [obstacles[k] for k in first.values()]
    shapes = [obstacle for obstacle in left if obstacle.primitive is not None]
    if len(shapes) < 2:
        return tuple(left)
    corners = np.stack([_corners(obstacle) for obstacle in shapes])  # (shapes, 8, 3)
    volumes = np.array([np.prod(sizes(o.primitive[0])[1]) for o in shapes if o.primitive])
    hidden = np.zeros(len(shapes), dtype=bool)
    for obstacle, volume in zip(shapes, volumes, strict=True):
        smaller = np.flatnonzero((volumes < volume) & ~hidden)
        hidden[smaller] = _inside(obstacle, corners[smaller]).all(axis=1)
    inner = {id(obstacle) for obstacle, is_in in zip(shapes, hidden, strict=True) if is_in}
    return tuple(obstacle for obstacle in left if id(obstacle) not in inner)


def _key(obstacle: Obstacle) -> object:
    """Return what two obstacles have in common that are the same."""
    if obstacle.primitive is None:
        return id(obstacle)
    shape, pose = obstacle.primitive
    return shape, pose.tobytes()


def _corners(obstacle: Obstacle) -> Array:
    """Return the corners (8, 3) of a box around a shape, along its own axes."""
    assert obstacle.primitive is not None
    turn, at = frame_in_world(*obstacle.primitive)
    corners: Array = (CORNERS * sizes(obstacle.primitive[0])[1]) @ turn.T + at
    return corners


def _inside(obstacle: Obstacle, points: Array) -> NDArray[np.bool_]:
    """Say which points (..., 3) a shape holds."""
    assert obstacle.primitive is not None
    turn, at = frame_in_world(*obstacle.primitive)
    return obstacle.primitive[0].depths((points - at) @ turn) >= 0.0
