"""Meshes of goal cones and keep-out cones of axes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, weld

WANTED, FORBIDDEN = (0.0, 0.48, 0.25), (0.835, 0.369, 0.0)
STRIPE = (0.99, 0.80, 0.55)
SEGMENTS = 48


@dataclass(frozen=True, eq=False)
class Cone:
    """A cone of directions that an axis must reach at the goal, or must avoid.

    Args:
        apex: Position of the apex, in [m].
        direction: Of its axis, a unit vector.
        half_angle: In [rad].
        length: In [m].
        forbidden: Whether the axis must keep out of it.
    """

    apex: tuple[float, float, float]
    direction: tuple[float, float, float]
    half_angle: float
    length: float
    forbidden: bool


def cone_mesh(cone: Cone) -> SurfaceMesh:
    """The cone from its apex to a cap that is part of a ball, in its colour."""
    # 0.02 [rad] half angle below which a cone would be invisible
    half = float(np.clip(cone.half_angle, 0.02, np.pi))
    rings = np.linspace(0.0, half, 9)[1:]
    turn = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    across = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1)
    ahead = np.array([0.0, 0.0, 1.0])
    cap = [np.sin(angle) * across + np.cos(angle) * ahead for angle in rings]
    points = np.concatenate([*cap, [ahead], [np.zeros(3)]])
    placed = np.asarray(cone.apex) + cone.length * points @ _frame(np.asarray(cone.direction)).T
    faces = _faces(len(rings))
    if not cone.forbidden:
        return weld(placed, faces, WANTED)
    segment = np.tile(np.arange(SEGMENTS), len(faces) // SEGMENTS)
    # 4 segments of a stripe of what is forbidden: it is told by more than its colour
    striped = (segment // 4) % 2 == 0
    return weld(placed, faces, np.where(striped[:, None], FORBIDDEN, STRIPE))


def _faces(rings: int) -> NDArray[np.int64]:
    a = np.arange(SEGMENTS)
    b = (a + 1) % SEGMENTS
    top, apex = np.full(SEGMENTS, rings * SEGMENTS), np.full(SEGMENTS, rings * SEGMENTS + 1)
    outer = (rings - 1) * SEGMENTS
    faces = [np.stack([top, a, b], axis=1), np.stack([apex, b + outer, a + outer], axis=1)]
    for k in range(rings - 1):
        near, far = k * SEGMENTS, (k + 1) * SEGMENTS
        faces += [np.stack([a + near, a + far, b + far], axis=1)]
        faces += [np.stack([a + near, b + far, b + near], axis=1)]
    return np.concatenate(faces)


def _frame(direction: Array) -> Array:
    """A rotation matrix whose last column is a unit direction."""
    aside = np.eye(3)[np.argmin(np.abs(direction))]
    x = np.cross(aside, direction)
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(direction, x), direction])
