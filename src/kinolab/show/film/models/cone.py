"""Meshes of goal cones and keep-out cones of axes."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.show.film.models.surface_mesh import SurfaceMesh, weld
from kinolab.show.film.picture import Cone
from kinolab.world.shape_surfaces import surface_of_revolution

Color: TypeAlias = tuple[float, float, float]

WANTED, FORBIDDEN = (0.0, 0.48, 0.25), (0.835, 0.369, 0.0)
STRIPES = 4  # segments of a stripe of what is forbidden: it is told by more than its colour
STRIPE = (0.99, 0.80, 0.55)
MIN_HALF_ANGLE = 0.02  # [rad] half angle below which a cone would be invisible
SEGMENTS = 48


def cone_mesh(cone: Cone) -> SurfaceMesh:
    """The cone from its apex to a cap that is part of a ball, in its colour."""
    half = float(np.clip(cone.half_angle, MIN_HALF_ANGLE, np.pi))
    angles = np.linspace(half, 0.0, 9)
    cap = np.stack([np.sin(angles), np.cos(angles)], axis=1)
    points, faces = surface_of_revolution([(0.0, 0.0), *cap], SEGMENTS)
    placed = np.asarray(cone.apex) + cone.length * points @ _frame(np.asarray(cone.direction)).T
    if not cone.forbidden:
        return weld(placed, faces, WANTED)
    segment = np.tile(np.arange(SEGMENTS), len(faces) // SEGMENTS)
    striped = (segment // STRIPES) % 2 == 0
    return weld(placed, faces, np.where(striped[:, None], FORBIDDEN, STRIPE))


def _frame(direction: Array) -> Array:
    """A rotation matrix whose last column is a unit direction."""
    aside = np.eye(3)[np.argmin(np.abs(direction))]
    x = np.cross(aside, direction)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(direction, x), direction])
