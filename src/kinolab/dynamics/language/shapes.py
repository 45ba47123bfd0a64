"""Convex shapes of bodies, for rendering and collision checking.

A shape is plain data. Its dimensions may contain parameters of the machine until ``System``
resolves them to numbers. Every shape is convex, is centred at ``at`` in its body's frame, and has
its axis of symmetry, if any, along a named axis of that frame.
"""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.arguments import checked
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array

if TYPE_CHECKING:  # a machine that is in the cache needs no expressions
    import sympy

Scalar: TypeAlias = "float | sympy.Expr"
AxisName: TypeAlias = Literal["x", "y", "z"]
Point: TypeAlias = tuple[Scalar, Scalar, Scalar]

ORIGIN: Point = (0.0, 0.0, 0.0)
MAX_COORDINATE = 1e9  # [m] of what collides; farther away rounding is no longer small beside it
MOST_DRAWN = 50_000  # triangles of a mesh that is drawn


@checked
@dataclass(frozen=True)
class Box:
    """A cuboid with full edge lengths ``x``, ``y`` and ``z`` in [m].

    ``at`` is its centre in the body's frame, in [m].
    """

    x: Scalar
    y: Scalar
    z: Scalar
    at: Point = ORIGIN


@checked
@dataclass(frozen=True)
class Sphere:
    """A sphere of the given radius in [m], centred ``at`` a point of the body's frame, in [m]."""

    radius: Scalar
    at: Point = ORIGIN


@checked
@dataclass(frozen=True)
class Cylinder:
    """A cylinder: radius and full length in [m], symmetric about ``axis``, centred ``at`` [m]."""

    radius: Scalar
    length: Scalar
    axis: AxisName = "z"
    at: Point = ORIGIN


@checked
@dataclass(frozen=True)
class Capsule:
    """A cylinder of ``length`` in [m] with a hemisphere of the same radius on both ends.

    It is symmetric about ``axis`` and centred ``at`` a point of the body's frame, in [m].
    """

    radius: Scalar
    length: Scalar
    axis: AxisName = "z"
    at: Point = ORIGIN


@checked
@dataclass(frozen=True)
class Disk:
    """A flat cylinder drawn with sectors, so that its rotation is visible.

    ``radius`` and ``thickness`` are in [m]; it is symmetric about ``axis`` and centred ``at`` a
    point of the body's frame, in [m].
    """

    radius: Scalar
    thickness: Scalar
    axis: AxisName = "z"
    at: Point = ORIGIN


@checked
@dataclass(frozen=True)
class DrawnMesh:
    """Triangles in a body's frame that are drawn and touch nothing; ``of`` makes one of arrays.

    Attributes:
        points: Corners in [m], rows of three little-endian numbers of 4 bytes, in base64.
        corners: Of each triangle three rows of ``points``, as integers of 2 bytes, likewise.
        color: Red, green and blue in [0, 1].
    """

    points: str
    corners: str
    color: tuple[float, float, float]

    def __post_init__(self) -> None:
        """Validate that all corners are there.

        Raises:
            InputError: If they are not, or there are too many triangles.
        """
        if len(self.corners) > 8 * MOST_DRAWN:  # 6 bytes of a triangle are 8 characters
            what = f"it has more than {MOST_DRAWN} triangles."
            raise InputError([Mistake("DrawnMesh corners", what, "Take fewer.")])
        try:
            points, faces = self.vertices, self.faces
            sound = bool(np.isfinite(points).all()) and faces.max(initial=-1) < len(points)
        except ValueError:
            sound = False
        if not sound:
            what = "its corners and points do not fit each other, or are no numbers."
            raise InputError([Mistake("DrawnMesh", what, "Make it with DrawnMesh.of(…).")])

    @classmethod
    def of(
        cls, vertices: Array, faces: NDArray[np.int64], color: tuple[float, float, float]
    ) -> DrawnMesh:
        """Pack vertices (n, 3) in [m] and faces (m, 3); n is 65 535 at most."""
        points, corners = np.asarray(vertices, "<f4"), np.asarray(faces)
        if len(points) > np.iinfo(np.uint16).max:
            what = f"it has {len(points)} vertices."
            raise InputError([Mistake("DrawnMesh vertices", what, "Take at most 65535.")])
        return cls(_base64(points.tobytes()), _base64(corners.astype("<u2").tobytes()), color)

    @property
    def vertices(self) -> Array:
        """Corners in [m], shape (n, 3)."""
        content = base64.b64decode(self.points, validate=True)
        return np.frombuffer(content, "<f4").reshape(-1, 3).astype(np.float64)

    @property
    def faces(self) -> NDArray[np.int64]:
        """Three rows of ``vertices`` each, shape (m, 3)."""
        content = base64.b64decode(self.corners, validate=True)
        return np.frombuffer(content, "<u2").reshape(-1, 3).astype(np.int64)


def _base64(content: bytes) -> str:
    return base64.b64encode(content).decode()


Shape: TypeAlias = Box | Sphere | Cylinder | Capsule | Disk
SHAPES: tuple[type, ...] = (Box, Sphere, Cylinder, Capsule, Disk)
