"""An ellipsoid, by its support function alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics import Shape
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.shapes import ORIGIN, Point
from kinolab.numerics.arrays import Array


@checked
@dataclass(frozen=True)
class Ellipsoid(Shape):
    """An ellipsoid with semi-axes ``x``, ``y`` and ``z`` in [m], centred ``at`` a point in [m]."""

    x: Number
    y: Number
    z: Number
    at: Point = ORIGIN

    def support(self, directions: Array) -> Array:
        """Return D^2 n / |D n| for directions n, with the semi-axes on the diagonal of D."""
        axes = np.array([self.x, self.y, self.z], dtype=float)
        stretched: Array = directions * axes
        return axes * stretched / np.linalg.norm(stretched, axis=1, keepdims=True)
