"""Bounding radii of shapes about their body's origin, and their axes of symmetry."""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from kinolab.dynamics.language.shapes import Scalar, Shape
from kinolab.dynamics.symbols.expressions import exact, is_zero


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
    edges, rounding = shape.span()
    half = tuple(exact(edge) / sympy.Integer(2) for edge in edges if edge != 0)
    own = shape.symmetric.replace("z", shape.axis) if shape.symmetric != "xyz" else "xyz"
    off = {axis for axis, entry in zip("xyz", shape.at, strict=True) if not is_zero(entry)}
    axes = "".join(axis for axis in "xyz" if axis in own and off <= {axis})  # through its centre
    core = half[0] if len(half) == 1 else _norm(half)
    return BoundingRadius(core + exact(rounding) + _norm(shape.at), axes)


def _norm(vector: tuple[Scalar, ...]) -> sympy.Expr:
    return sympy.sqrt(sum(exact(component) ** 2 for component in vector))
