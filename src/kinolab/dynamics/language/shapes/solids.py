"""Convex shapes of bodies, for rendering and collision checking.

A shape is plain data. Its dimensions may contain parameters of the machine until ``System``
resolves them to numbers. Every shape is convex, is centred at ``at`` in its body's frame, and has
its axis of symmetry, if any, along a named axis of that frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

from kinolab.arguments import checked

if TYPE_CHECKING:  # a machine that is in the cache needs no expressions
    import sympy

Scalar: TypeAlias = "float | sympy.Expr"
AxisName: TypeAlias = Literal["x", "y", "z"]
Point: TypeAlias = tuple[Scalar, Scalar, Scalar]

ORIGIN: Point = (0.0, 0.0, 0.0)
MAX_COORDINATE = 1e9  # [m] of what collides; farther away rounding is no longer small beside it


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


Shape: TypeAlias = Box | Sphere | Cylinder | Capsule | Disk
SHAPES: tuple[type, ...] = (Box, Sphere, Cylinder, Capsule, Disk)
