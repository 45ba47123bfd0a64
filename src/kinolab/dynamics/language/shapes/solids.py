"""The shapes of bodies: boxes, balls, cylinders, capsules and disks.

A shape is plain data and the laws of ``Shape``. Its dimensions may contain parameters of the
machine until ``System`` resolves them to numbers. Every shape is convex, is centred at ``at`` in
its body's frame, and has its axis of symmetry, if any, along a named axis of that frame.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics.language.shapes.shape import (
    ORIGIN,
    AxisName,
    Point,
    Scalar,
    Shape,
    ShapeKind,
    Span,
    hull_of,
)
from kinolab.numerics.arrays import Array

if TYPE_CHECKING:
    from typing import Self


class _Swept(Shape):
    """A box, or a cylinder about z, that is swept by a ball; what it is follows from its span."""

    kind: ShapeKind

    def kept(self) -> Shape:
        """Return itself, but of a class from outside."""
        return self if type(self) in SHAPES else hull_of(self)

    def lowered(self) -> tuple[ShapeKind, tuple[float, ...]]:
        """Return its kind and half sizes, as ``Shape`` says."""
        edges, rounding = self.span()
        x, y, z = (0.5 * float(edge) for edge in edges)
        radius = float(rounding) or y
        if self.kind is ShapeKind.BOX:
            return self.kind, (x, y, z)
        return self.kind, (radius, radius, radius if self.kind is ShapeKind.SPHERE else z)

    def support(self, directions: Array) -> Array:
        """Return the farthest points (n, 3) along unit vectors (n, 3) of its own frame, in [m]."""
        half, radius = self._core()
        found: Array = np.copysign(half, directions)
        if self.kind is ShapeKind.CYLINDER:
            across = np.linalg.norm(directions[:, :2], axis=1, keepdims=True)
            found[:, :2] = half[1] * directions[:, :2] / np.where(across > 0.0, across, 1.0)
        return found + radius * directions

    def depths(self, points: Array) -> Array:
        """Return how deep points (..., 3) of its own frame are in it, in [m]."""
        half, radius = self._core()
        out = np.abs(points) - half
        if self.kind is ShapeKind.CYLINDER:
            out[..., 0] = out[..., 1] = np.hypot(points[..., 0], points[..., 1]) - half[1]
        if radius:
            return np.asarray(radius - np.linalg.norm(np.maximum(out, 0.0), axis=-1))
        return np.asarray(-out.max(axis=-1))

    def shrunk(self, left: Callable[[Any], float]) -> Self:
        """Return a slimmer shape, given what is left of a width; a capsule keeps its axis."""
        kept = {name: left(getattr(self, name)) for name in self.lengths()}
        if self.kind is not ShapeKind.BOX:
            radius = left(2 * self.radius) / 2  # type: ignore[attr-defined]
            kept = (kept if self.kind is ShapeKind.CYLINDER else {}) | {"radius": radius}
        return replace(self, **kept)

    def _core(self) -> tuple[Array, float]:
        edges, rounding = self.span()
        return 0.5 * np.array(edges, dtype=float), float(rounding)


@checked
@dataclass(frozen=True)
class Box(_Swept):
    """A cuboid with full edge lengths ``x``, ``y`` and ``z`` in [m].

    ``at`` is its centre in the body's frame, in [m].
    """

    x: Scalar
    y: Scalar
    z: Scalar
    at: Point = ORIGIN

    kind = ShapeKind.BOX

    def span(self) -> Span:
        """Return its edges."""
        return (self.x, self.y, self.z), 0


@checked
@dataclass(frozen=True)
class Sphere(_Swept):
    """A sphere of the given radius in [m], centred ``at`` a point of the body's frame, in [m]."""

    radius: Scalar
    at: Point = ORIGIN

    kind, symmetric = ShapeKind.SPHERE, "xyz"

    def span(self) -> Span:
        """Return a point, and its radius."""
        return (0, 0, 0), self.radius


@checked
@dataclass(frozen=True)
class Cylinder(_Swept):
    """A cylinder: radius and full length in [m], symmetric about ``axis``, centred ``at`` [m]."""

    radius: Scalar
    length: Scalar
    axis: AxisName = "z"
    at: Point = ORIGIN

    kind, symmetric = ShapeKind.CYLINDER, "z"

    def span(self) -> Span:
        """Return its section."""
        return (0, 2 * self.radius, self.length), 0


@checked
@dataclass(frozen=True)
class Capsule(_Swept):
    """A cylinder of ``length`` in [m] with a hemisphere of the same radius on both ends.

    It is symmetric about ``axis`` and centred ``at`` a point of the body's frame, in [m].
    """

    radius: Scalar
    length: Scalar
    axis: AxisName = "z"
    at: Point = ORIGIN

    kind, symmetric = ShapeKind.CAPSULE, "z"

    def span(self) -> Span:
        """Return its axis, and its radius."""
        return (0, 0, self.length), self.radius


@checked
@dataclass(frozen=True)
class Disk(_Swept):
    """A flat cylinder drawn with sectors, so that its rotation is visible.

    ``radius`` and ``thickness`` are in [m]; it is symmetric about ``axis`` and centred ``at`` a
    point of the body's frame, in [m].
    """

    radius: Scalar
    thickness: Scalar
    axis: AxisName = "z"
    at: Point = ORIGIN

    kind, symmetric, rotor = ShapeKind.CYLINDER, "z", True

    def span(self) -> Span:
        """Return its section."""
        return (0, 2 * self.radius, self.thickness), 0


SHAPES: tuple[type, ...] = (Box, Capsule, Cylinder, Disk, Sphere)
