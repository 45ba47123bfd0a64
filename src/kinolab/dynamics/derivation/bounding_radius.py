"""Bounding radii of shapes about their body's origin, and their axes of symmetry."""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from kinolab.dynamics.language.expressions import exact, is_zero
from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Disk, Scalar, Shape, Sphere


@dataclass(frozen=True)
class BoundingRadius:
    """The bounding ball of a shape about its body's origin.

    Attributes:
        radius: In [m].
        symmetric_about: Names of the body axes about which the shape is rotationally symmetric.
    """

    radius: sympy.Expr
    symmetric_about: str


def bounding_radius(shape: Shape) -> BoundingRadius:
    """Return the bounding radius of a shape."""
    match shape:
        case Sphere():
            return BoundingRadius(shape.radius + _norm(shape.at), _axes_through(shape.at))
        case Box():
            half = tuple(edge / sympy.Integer(2) for edge in (shape.x, shape.y, shape.z))
            return BoundingRadius(_norm(half) + _norm(shape.at), "")
        case Cylinder():
            half = _norm((shape.radius, shape.length / sympy.Integer(2)))
            return BoundingRadius(half + _norm(shape.at), _own_axis(shape))
        case Disk():
            half = _norm((shape.radius, shape.thickness / sympy.Integer(2)))
            return BoundingRadius(half + _norm(shape.at), _own_axis(shape))
        case Capsule():
            half = shape.length / sympy.Integer(2) + shape.radius
            return BoundingRadius(half + _norm(shape.at), _own_axis(shape))


def _norm(vector: tuple[Scalar, ...]) -> sympy.Expr:
    return sympy.sqrt(sum(exact(component) ** 2 for component in vector))


def _axes_through(at: tuple[Scalar, Scalar, Scalar]) -> str:
    """Return the body axes that pass through a point."""
    return "".join(
        axis
        for axis in "xyz"
        if all(is_zero(c) for name, c in zip("xyz", at, strict=True) if name != axis)
    )


def _own_axis(shape: Cylinder | Capsule | Disk) -> str:
    return shape.axis if shape.axis in _axes_through(shape.at) else ""
