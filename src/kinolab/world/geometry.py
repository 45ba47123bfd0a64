"""Body shapes as numbers: extents, triangles, and how far a motion can carry them.

Every shape has a frame of its own, whose z axis is the shape's axis of symmetry. In that frame a
shape is a kind and three half sizes; the compiled code and FCL both work from these.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.numerics.arrays import Array
from kinolab.world.shape_surfaces import (
    Faces,
    ball_surface,
    box_surface,
    capsule_surface,
    cylinder_surface,
)
from kinolab.world.support_functions import half_extent

# Columns: where the axes of a shape's own frame point in the body's frame.
TURN: dict[str, Array] = {
    "x": np.eye(3)[:, [1, 2, 0]],
    "y": np.eye(3)[:, [2, 0, 1]],
    "z": np.eye(3),
}
SECTIONS = 64  # corners of a drawn circle


class ShapeKind(IntEnum):
    """The families of shapes that the compiled code tells apart; a disk is a cylinder."""

    BOX = 0
    SPHERE = 1
    CYLINDER = 2
    CAPSULE = 3


def sizes(shape: Shape) -> tuple[ShapeKind, Array]:
    """Give the kind and the half sizes (3,) in [m], along x, y, z of the shape's own frame.

    Round shapes have their radius in x and y and half their ``length`` in z; a capsule's caps
    come on top of that.
    """
    kind, half = _sizes(shape)
    return kind, np.array(half, dtype=float)


def kinds_and_sizes(shapes: Sequence[Shape]) -> tuple[NDArray[np.int64], Array]:
    """Give ``sizes`` of several shapes, (n,) and (n, 3)."""
    kinds, halves = zip(*map(_sizes, shapes), strict=True)
    return np.array(kinds, dtype=np.int64), np.array(halves, dtype=float)


def _sizes(shape: Shape) -> tuple[ShapeKind, tuple[float, float, float]]:
    match shape:
        case Box():
            return ShapeKind.BOX, (0.5 * float(shape.x), 0.5 * float(shape.y), 0.5 * float(shape.z))
        case Sphere():
            return ShapeKind.SPHERE, 3 * (float(shape.radius),)
        case Capsule():
            return ShapeKind.CAPSULE, _round(shape.radius, shape.length)
        case Cylinder():
            return ShapeKind.CYLINDER, _round(shape.radius, shape.length)
        case Disk():
            return ShapeKind.CYLINDER, _round(shape.radius, shape.thickness)
    raise TypeError(f"not a shape: {shape!r}")


def _round(radius: Any, length: Any) -> tuple[float, float, float]:
    return float(radius), float(radius), 0.5 * float(length)


def placement(shape: Shape) -> Array:
    """Give the shape's own frame in its body's frame, (3, 4), [R | p]."""
    own = np.empty((3, 4))
    own[:, :3], own[:, 3] = TURN[getattr(shape, "axis", "z")], shape.at
    return own


def frame_in_world(shape: Shape, pose: Array) -> tuple[Array, Array]:
    """Give the axes (..., 3, 3) and centre (..., 3) in [m] of a shape's own frame.

    Args:
        shape: Of a body.
        pose: Of that body, shape (..., 3, 4).
    """
    return _carried(placement(shape), pose)


def frames_in_world(shapes: Sequence[Shape], poses: Array) -> tuple[Array, Array]:
    """Give ``frame_in_world`` of shapes at poses (n, 3, 4), in shapes (n, 3, 3) and (n, 3)."""
    own = np.empty((len(shapes), 3, 4))
    own[..., :3] = [TURN[getattr(shape, "axis", "z")] for shape in shapes]
    own[..., 3] = [shape.at for shape in shapes]
    return _carried(own, poses)


def _carried(own: Array, pose: Array) -> tuple[Array, Array]:
    """Give the axes and origins of frames (..., 3, 4) that poses (..., 3, 4) carry along."""
    turn = pose[..., :3]
    return turn @ own[..., :3], (turn @ own[..., 3:])[..., 0] + pose[..., 3]


def lowest_z(shape: Shape, pose: Array) -> float:
    """Give the lowest world z of a shape in [m], in closed form; ``pose`` of its body is (3, 4)."""
    kind, half = sizes(shape)
    own = placement(shape)
    center = pose[2, :3] @ own[:, 3] + pose[2, 3]
    down = pose[2, :3] @ own[:, :3]
    return float(center - half_extent(int(kind), half, *down))


def triangles(shape: Shape, corners: int = SECTIONS) -> tuple[Array, Faces]:
    """Triangulate the surface in the body's frame, for drawing.

    Args:
        shape: What is drawn.
        corners: Of a circle around a cylinder, twice as many as of one around a capsule.

    Returns:
        Vertices (n, 3) in [m], on the surface; faces (m, 3), seen anticlockwise from outside.
    """
    kind, half = sizes(shape)
    vertices, faces = _own_triangles(kind, *half.tolist(), corners)
    frame = placement(shape)
    return vertices @ frame[:, :3].T + frame[:, 3], faces.copy()


@lru_cache(maxsize=64)
def _own_triangles(
    kind: ShapeKind, x: float, y: float, z: float, corners: int
) -> tuple[Array, Faces]:
    """Triangulate a shape in its own frame; worlds of many have few sizes of them."""
    if kind is ShapeKind.BOX:
        return box_surface(np.array([x, y, z]))
    if kind is ShapeKind.SPHERE:
        return ball_surface(x)
    if kind is ShapeKind.CYLINDER:
        return cylinder_surface(x, z, corners)
    return capsule_surface(x, z, corners)


def feature_points(shape: Shape) -> Array:
    """Return points in the body's frame, in [m], that stay where the shape stays; (points, 3).

    They lie as far out as the shape does. Points of a round shape are on its axis: its spin about
    it is no motion. A ball has its centre alone.
    """
    kind, half = sizes(shape)
    if kind is ShapeKind.SPHERE:
        own = np.zeros((1, 3))
    elif kind is ShapeKind.BOX:
        own = half * np.array(list(product((-1.0, 1.0), repeat=3)))
    else:
        far = max(half) + (half[0] if kind is ShapeKind.CAPSULE else 0.0)
        own = np.array([[0.0, 0.0, far], [0.0, 0.0, -far]])
    frame = placement(shape)
    points: Array = own @ frame[:, :3].T + frame[:, 3]
    return points
