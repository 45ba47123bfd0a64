"""What a shape is: a convex solid, which owns its laws. A new one is one class below ``Shape``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from enum import IntEnum
from functools import lru_cache
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import numpy as np

from kinolab.dynamics.language.shapes.hulls import hull_around, hull_surface
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array

if TYPE_CHECKING:  # a machine that is in the cache needs no expressions
    from typing import Self

    import sympy

Scalar: TypeAlias = "float | sympy.Expr"
AxisName: TypeAlias = Literal["x", "y", "z"]
Point: TypeAlias = tuple[Scalar, Scalar, Scalar]
Span: TypeAlias = tuple[Point, Scalar]

ORIGIN: Point = (0.0, 0.0, 0.0)
MAX_COORDINATE = 1e9  # [m] of what collides; farther away rounding is no longer small beside it


class ShapeKind(IntEnum):
    """The solids that the compiled code tells apart, to which shapes lower themselves."""

    BOX = 0
    SPHERE = 1
    CYLINDER = 2
    CAPSULE = 3
    HULL = 4


class Shape:
    """A convex solid, in a frame of its own about its centre.

    A shape from outside is a frozen dataclass below this class. Its fields are lengths in [m] that
    make it so many times as large where all of them are, then ``at`` and, if it has one, ``axis``.
    ``support`` alone has to be written. The rest is worked out from a polytope around it, which
    stands out by 0.5 % of its size: that counts as the shape in all that collides and is drawn.

    Attributes:
        at: Its centre in the body's frame, in [m]; the solid holds it.
        axis: The axis of the body's frame along which the z axis of its own one lies.
        symmetric: Axes of its own frame about which it may turn unnoticed: "", "z" or "xyz".
        rotor: Whether it is drawn as a rotor where its body whirls about the shape's axis.
    """

    __dataclass_fields__: ClassVar[dict[str, Any]]  # of those below
    at: Point
    axis: AxisName = "z"
    symmetric: str = ""
    rotor: bool = False

    def support(self, directions: Array) -> Array:
        """Return the farthest points (n, 3) along unit vectors (n, 3) of its own frame, in [m]."""
        raise NotImplementedError(f"{type(self).__name__} says neither its support nor its kind")

    def lowered(self) -> tuple[ShapeKind, tuple[float, ...]]:
        """Return its kind and its half sizes along x, y, z of its own frame, in [m].

        Round shapes have their radius in x and y and half their length in z; a capsule's caps come
        on top of that. The coordinates of the corners of a hull follow.

        Raises:
            InputError: If the support function is none of a solid.
        """
        return ShapeKind.HULL, _hull(self)

    def span(self) -> Span:
        """Return the edges of a box in [m], and the radius in [m] of a ball that is swept over it.

        The farthest point of both, and of the solid, is half the diagonal and the radius away from
        the centre. For what is round about z, the box is a section: its first edge is 0.

        Raises:
            InputError: If it is to be worked out, and a dimension is an expression.
        """
        return (2.0 * float(np.linalg.norm(self._corners(), axis=1).max()), 0, 0), 0

    def depths(self, points: Array) -> Array:
        """Return the radii (...) in [m] of the balls about points (..., 3) of its own frame in it.

        They are negative outside.
        """
        planes = hull_surface(self._corners())[2]
        return np.asarray(-(points @ planes[:, :3].T + planes[:, 3]).max(axis=-1))

    def shrunk(self, left: Callable[[Any], float]) -> Self:
        """Return a slimmer shape, given what is left of a width in [m]."""
        width = 2.0 * float(self.depths(np.zeros(3)))
        share = (
            left(width) / width
        )  # the solid holds the ball, so it is slimmer by as much at least
        return replace(
            self, **{name: share * float(getattr(self, name)) for name in self.lengths()}
        )

    def lengths(self) -> list[str]:
        """Return the names of its dimensions."""
        return [entry.name for entry in fields(self) if entry.name not in ("axis", "at")]

    def _corners(self) -> Array:
        return np.reshape(self.lowered()[1][3:], (-1, 3))


@lru_cache(maxsize=256)
def _hull(shape: Shape) -> tuple[float, ...]:
    """Return the half sizes and corners of the polytope around a shape, in its own frame."""
    where = f"shape {type(shape).__name__}"
    try:
        corners = hull_around(shape.support)
    except (TypeError, ValueError) as error:
        what = f"no hull around it can be made: {error}."
        remedy = "Let support(…) return the farthest points, of numbers; or write span(), too."
        raise InputError([Mistake(where, what, remedy)]) from error
    return (*np.abs(corners).max(axis=0).tolist(), *corners.ravel().tolist())
