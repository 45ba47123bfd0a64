"""Body shapes as numbers: extents, triangles, and how far a motion can carry them.

Every shape has a frame of its own, whose z axis is the shape's axis of symmetry. In that frame it
lowers itself to a kind, three half sizes and the corners of a hull; the compiled code and FCL both
work from these.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import product

import numpy as np

from kinolab.dynamics.facts.machine_facts import BodyGeometry
from kinolab.dynamics.language.shapes import Shape, ShapeKind
from kinolab.dynamics.language.shapes.hulls import hull_surface
from kinolab.numerics.arrays import Array
from kinolab.world.shapes.shape_surfaces import (
    Faces,
    ball_surface,
    box_surface,
    capsule_surface,
    cylinder_surface,
)
from kinolab.world.shapes.support_functions import half_extent, reach_along

# Columns: where the axes of a shape's own frame point in the body's frame.
TURN: dict[str, Array] = {
    "x": np.eye(3)[:, [1, 2, 0]],
    "y": np.eye(3)[:, [2, 0, 1]],
    "z": np.eye(3),
}
SECTIONS = 64  # corners of a drawn circle


def sizes(shape: Shape) -> tuple[ShapeKind, Array]:
    """Give the kind and half sizes in [m] to which a shape lowers itself; (3,) but of a hull."""
    kind, half = shape.lowered()
    return kind, np.array(half, dtype=float)


def sizes_of(halves: Sequence[Sequence[float] | Array]) -> Array:
    """Gather half sizes (k,) in a table, (n, 3) or wider; hulls repeat their last corner in it."""
    widest = max(map(len, halves), default=3)
    rows = [[*half, *[*half[-3:]] * ((widest - len(half)) // 3)] for half in halves]
    return np.array(rows, dtype=float).reshape(-1, widest)


def half_extents(shape: Shape, directions: Array) -> Array:
    """Give its reach (n,) in [m] from its centre along unit vectors (n, 3) of its own frame."""
    kind, half = sizes(shape)
    return np.array([half_extent(int(kind), half, *direction) for direction in directions])


def core_radius_of(shape: Shape) -> float:
    """Give the radius in [m] of the ball about the centre that holds the box of the half sizes."""
    return float(np.linalg.norm(sizes(shape)[1][:3]))


def reach_of(body: BodyGeometry) -> float:
    """Give the radius in [m] of the ball about a body's origin that holds those balls."""
    distances = (np.linalg.norm(s.at) + core_radius_of(s) for s in body.shapes)
    return float(max(distances, default=0.0))


def placement(shape: Shape) -> Array:
    """Give the shape's own frame in its body's frame, (3, 4), [R | p]."""
    own = np.empty((3, 4))
    own[:, :3], own[:, 3] = TURN[shape.axis], shape.at
    return own


def frame_in_world(shape: Shape, pose: Array) -> tuple[Array, Array]:
    """Give the axes (..., 3, 3) and centre (..., 3) in [m] of a shape's own frame.

    Args:
        pose: Of that body, shape (..., 3, 4).
    """
    return carried(placement(shape), pose)


def carried(own: Array, pose: Array) -> tuple[Array, Array]:
    """Give the axes and origins of frames (..., 3, 4) that poses (..., 3, 4) carry along."""
    turn = pose[..., :3]
    return turn @ own[..., :3], (turn @ own[..., 3:])[..., 0] + pose[..., 3]


def lowest_z(shape: Shape, pose: Array) -> float:
    """Give the lowest world z of a shape in [m], in closed form; ``pose`` of its body is (3, 4)."""
    own = placement(shape)
    center = pose[2, :3] @ own[:, 3] + pose[2, 3]
    down = pose[2, :3] @ own[:, :3]
    return float(center - half_extents(shape, -down[None])[0])


def triangles(shape: Shape, corners: int = SECTIONS) -> tuple[Array, Faces]:
    """Triangulate the surface in the body's frame, for drawing.

    Args:
        shape: What is drawn.
        corners: Of a circle around a cylinder, twice as many as of one around a capsule.

    Returns:
        Vertices (n, 3) in [m], on the surface; faces (m, 3), seen anticlockwise from outside.
    """
    kind, half = shape.lowered()
    vertices, faces = _own_triangles(kind, half, corners)
    frame = placement(shape)
    return vertices @ frame[:, :3].T + frame[:, 3], faces.copy()


@lru_cache(maxsize=64)
def _own_triangles(kind: ShapeKind, half: tuple[float, ...], corners: int) -> tuple[Array, Faces]:
    """Triangulate a shape in its own frame; worlds of many have few sizes of them."""
    radius, _, length = half[:3]
    surfaces: dict[ShapeKind, Callable[[], tuple[Array, Faces]]] = {
        ShapeKind.BOX: lambda: box_surface(np.array(half)),
        ShapeKind.SPHERE: lambda: ball_surface(radius),
        ShapeKind.CYLINDER: lambda: cylinder_surface(radius, length, corners),
        ShapeKind.CAPSULE: lambda: capsule_surface(radius, length, corners),
        ShapeKind.HULL: lambda: hull_surface(np.reshape(half[3:], (-1, 3)))[:2],
    }
    return surfaces[kind]()


def feature_points(shape: Shape) -> Array:
    """Return points in the body's frame, in [m], that stay where the shape stays; (points, 3).

    They lie as far out as the shape does. Points of a round shape are on its axis: its spin about
    it is no motion. A ball has its centre alone.
    """
    frame = placement(shape)
    kind, half = sizes(shape)
    reach = np.array([reach_along(int(kind), half, axis) for axis in range(3)])
    own = {
        "": reach * np.array(list(product((-1.0, 1.0), repeat=3))),
        "z": max(reach) * np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]),
        "xyz": np.zeros((1, 3)),
    }[shape.symmetric]
    points: Array = own @ frame[:, :3].T + frame[:, 3]
    return points
