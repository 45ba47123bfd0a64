"""What a shape is: a convex solid, which owns its laws. A new one is one class below ``Shape``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal, TypeAlias

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics.language.shapes.hulls import (
    STANDS_OUT,
    hull_around,
    hull_surface,
    require_round,
)
from kinolab.dynamics.language.shapes.packed_rows import packed, unpacked
from kinolab.dynamics.symbols.words import Word
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array

if TYPE_CHECKING:  # a machine that is in the cache needs no expressions
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


class Shape(Word):
    """A convex solid, in a frame of its own about its centre.

    A shape from outside is a frozen dataclass below this class: dimensions, positive numbers, then
    ``at`` and, if it has one, ``axis``. ``support`` alone has to be written. What counts as the
    shape, and stands in files, is a polytope around it, which stands out by 0.5 % of its size.

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

    @property
    def called(self) -> str:
        """What messages call it."""
        return type(self).__name__

    def support(self, directions: Array) -> Array:
        """Return the farthest points (n, 3) along unit vectors (n, 3) of its own frame, in [m]."""
        raise NotImplementedError("write it")

    def kept(self) -> Shape:
        """Return what counts as it, and what files keep: one of kinolab's own shapes.

        Raises:
            InputError: If the support function is not one of a solid, or a dimension not a number.
        """
        return hull_of(self)

    def lowered(self) -> tuple[ShapeKind, tuple[float, ...]]:
        """Return its kind and its half sizes along x, y, z of its own frame, in [m].

        Round shapes have their radius in x and y and half their length in z; a capsule's caps come
        on top of that. The coordinates of the corners of a hull follow.

        Raises:
            InputError: As ``kept``.
        """
        return self.kept().lowered()

    def span(self) -> Span:
        """Return the edges of a box in [m], and the radius in [m] of a ball that is swept over it.

        The farthest point of both, and of the solid, is half the diagonal and the radius away from
        the centre. For what is round about z, the box is a section: its first edge is 0.

        Raises:
            InputError: As ``kept``.
        """
        return (2.0 * float(np.linalg.norm(self._corners(), axis=1).max()), 0, 0), 0

    def depths(self, points: Array) -> Array:
        """Return the radii (...) in [m] of the balls about points (..., 3) of its own frame in it.

        They are negative outside.
        """
        planes = hull_surface(self._corners())[2]
        return np.asarray(-(points @ planes[:, :3].T + planes[:, 3]).max(axis=-1))

    def shrunk(self, left: Callable[[Any], float]) -> Shape:
        """Return a slimmer shape, given what is left of a width in [m]."""
        width = 2.0 * float(self.depths(np.zeros(3)))
        share = left(width) / width  # it holds the ball, so it is slimmer by as much at least
        return replace(self.kept(), **{"points": packed(share * self._corners(), "<f8")})

    def lengths(self) -> list[str]:
        """Return the names of its dimensions."""
        return [entry.name for entry in fields(self) if entry.name not in ("axis", "at")]

    def _corners(self) -> Array:
        return np.reshape(self.lowered()[1][3:], (-1, 3))


@checked
@dataclass(frozen=True)
class Hull(Shape):
    """The convex hull of points about its centre, as which files keep a shape from outside.

    Attributes:
        name: Of the shape's class, for messages.
        points: In its own frame in [m], rows of three little-endian numbers of 8 bytes, in base64.
        made_for: Parameters on which its dimensions depended, with their values then.

    Raises:
        InputError: If these are not the corners of a solid that holds its centre, or it is not
            symmetric as it says.
    """

    name: str
    points: str
    symmetric: str = ""
    rotor: bool = False
    made_for: tuple[tuple[sympy.Symbol, float], ...] = ()
    axis: AxisName = "z"
    at: Point = ORIGIN

    def __post_init__(self) -> None:
        """Validate the corners."""
        self.lowered()

    @property
    def called(self) -> str:
        """What messages call it."""
        return self.name

    def kept(self) -> Shape:
        """Return itself, as numbers alone."""
        return replace(self, made_for=()) if self.made_for else self

    def lowered(self) -> tuple[ShapeKind, tuple[float, ...]]:
        """Return its kind, half sizes and corners, as ``Shape`` says."""
        with _refusing(self):
            return ShapeKind.HULL, _numbers_of(self.points, self.symmetric)

    def lengths(self) -> list[str]:
        """Return nothing: its dimensions have become points."""
        return []


@lru_cache(maxsize=256)
def hull_of(shape: Shape) -> Hull:
    """Return the polytope around a shape of which only the support function is known.

    Raises:
        InputError: If there is none.
    """
    with _refusing(shape):
        corners = hull_around(shape.support, shape.symmetric)
    facts = (shape.called, packed(corners, "<f8"), shape.symmetric, shape.rotor)
    return Hull(*facts, axis=shape.axis, at=shape.at)


@contextmanager
def _refusing(shape: Shape) -> Iterator[None]:
    """Say of which shape a support function or corners are wrong."""
    try:
        yield
    except (ValueError, RuntimeError) as error:  # the latter are Qhull's
        what = f"no hull around it can be made: {error}."
        remedy = "Let support(…) return, for each unit vector n, the point p with the largest n.p."
        raise InputError([Mistake(f"shape {shape.called}", what, remedy)]) from error


@lru_cache(maxsize=256)
def _numbers_of(points: str, symmetric: str) -> tuple[float, ...]:
    """Return the half sizes and the corners of a hull, all of it validated."""
    corners = unpacked(points, "<f8")
    size = float(np.abs(corners).max(initial=0.0))
    if not size <= MAX_COORDINATE:
        raise ValueError(f"a corner is {size:g} m away")
    planes = hull_surface(corners)[2]
    if not planes[:, 3].max() < 0.0:
        raise ValueError("it does not hold its centre")
    support = partial(_farthest_corners, corners)
    require_round(support, planes[:, :3], symmetric, 2 * STANDS_OUT * size)
    return (*np.abs(corners).max(axis=0).tolist(), *corners.ravel().tolist())


def _farthest_corners(corners: Array, directions: Array) -> Array:
    return np.array([corners[(corners @ n).argmax()] for n in directions])
