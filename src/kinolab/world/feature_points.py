"""Points of a shape that move exactly where the shape does."""

from __future__ import annotations

import itertools

import numpy as np

from kinolab.dynamics.language.shapes import Shape
from kinolab.world.geometry import Array, ShapeKind, placement, sizes


def feature_points(shape: Shape) -> Array:
    """Return points in the body's frame, in [m], that stay where the shape stays; (points, 3).

    They lie as far out as the shape does. Points of a round shape are on its axis: its spin about
    it is no motion. A ball has its centre alone.
    """
    kind, half = sizes(shape)
    if kind is ShapeKind.SPHERE:
        own = np.zeros((1, 3))
    elif kind is ShapeKind.BOX:
        own = half * np.array(list(itertools.product((-1.0, 1.0), repeat=3)))
    else:
        far = max(half) + (half[0] if kind is ShapeKind.CAPSULE else 0.0)
        own = np.array([[0.0, 0.0, far], [0.0, 0.0, -far]])
    frame = placement(shape)
    points: Array = own @ frame[:, :3].T + frame[:, 3]
    return points
