"""The largest ball about a point inside a body."""

from __future__ import annotations

import numpy as np

from kinolab.dynamics.language.shapes import Shape
from kinolab.dynamics.machine_facts import BodyGeometry
from kinolab.numerics.arrays import Array
from kinolab.world.geometry import ShapeKind, placement, sizes


def inscribed_radius(body: BodyGeometry, at: Array) -> float:
    """Return the radius in [m] of the ball about a body-frame point, shape (3,); 0 outside.

    It is that of the best single shape: the union of overlapping shapes might contain a larger one.
    """
    return max((_depth(shape, at) for shape in body.shapes), default=0.0)


def _depth(shape: Shape, at: Array) -> float:
    kind, half = sizes(shape)
    own = placement(shape)
    p = np.abs(own[:, :3].T @ (at - own[:, 3]))
    across = float(np.hypot(p[0], p[1]))
    if kind is ShapeKind.BOX:
        depth = float((half - p).min())
    elif kind is ShapeKind.SPHERE:
        depth = half[0] - float(np.linalg.norm(p))
    elif kind is ShapeKind.CYLINDER:
        depth = min(half[0] - across, half[2] - p[2])
    else:
        depth = half[0] - float(np.hypot(across, max(p[2] - half[2], 0.0)))
    return max(float(depth), 0.0)
