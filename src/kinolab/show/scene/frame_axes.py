"""The axes of frames: how long they are, and where."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.surface_mesh import SurfaceMesh

LEAST = 1e-3  # [m] of a machine's reach: one without shapes has none


def reach_of(machine: Sequence[SurfaceMesh], motion: Array) -> float:
    """How far a machine reaches from the middle of its bodies on a motion (nt, nb, 12), in [m]."""
    if not machine:
        return LEAST
    origins = motion[..., 3::4]
    away = np.linalg.norm(origins - origins.mean(axis=1, keepdims=True), axis=-1).max(axis=0)
    sizes = [np.linalg.norm(mesh.vertices, axis=1).max(initial=0.0) for mesh in machine]
    return float(max(np.max(away + np.array(sizes), initial=0.0), LEAST))


def axis_length(reach: float, size: float, frames: int) -> float:
    """Return how long axes are in [m], between a machine and its world; those of many are shorter.

    Args:
        reach: Of the machine from its middle, in [m].
        size: Of all that is seen, in [m].
        frames: How many there are: the axes of all of them cover the same part of a picture.
    """
    # 0.4 of axes, in geometric means of the sizes of a machine and its world
    return 0.4 * math.sqrt(reach * size / max(frames, 1))


def axes_of(poses: Array, length: float) -> Array:
    """Return x, y and z axes of frames at poses (..., 12) as segments, shape (n, 3, 2, 3)."""
    g = poses.reshape(-1, 3, 4).swapaxes(1, 2)  # rows: the axes, then the origin
    origins = np.repeat(g[:, 3:], 3, axis=1)
    return np.stack([origins, origins + length * g[:, :3]], axis=2)
