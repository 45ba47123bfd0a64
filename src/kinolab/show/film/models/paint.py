"""Coloured meshes of bodies: round ones in sectors, so that rotation is visible."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.numerics.arrays import Array
from kinolab.show.film.models.ball import Color, ball, pale
from kinolab.show.film.models.painted_body import DEGREES, PaintedBody, PaintedShape, fineness
from kinolab.show.film.models.rotor import rotor
from kinolab.show.film.models.surface_mesh import SurfaceMesh, weld
from kinolab.world.geometry import SECTIONS, triangles

if TYPE_CHECKING:
    from kinolab.dynamics.machine_facts import BodyGeometry

# Okabe and Ito, Color Universal Design, 2008; ordered so that a machine starts with its strongest.
COLORS: tuple[Color, ...] = (
    (0.835, 0.369, 0.000),
    (0.000, 0.447, 0.698),
    (0.800, 0.475, 0.655),
    (0.902, 0.624, 0.000),
    (0.337, 0.706, 0.914),
    (0.000, 0.620, 0.451),
)
MARK: Color = (0.13, 0.16, 0.22)  # one sector, to count full turns by

SECTORS = 8
SEGMENTS = (8, 16, 48)  # of a circle, multiples of SECTORS: their borders coincide
CORNERS = (16, 32, SECTIONS)  # of a circle, half as many on a capsule
AXES = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}  # cyclic, so orientation is kept


def paint_machine(bodies: Sequence[BodyGeometry]) -> tuple[SurfaceMesh, ...]:
    """One mesh per body in the body's frame, in its own colour or in the next free one."""
    return tuple(body.mesh() for body in painted_bodies(bodies))


def painted_bodies(bodies: Sequence[BodyGeometry]) -> tuple[PaintedBody, ...]:
    """The surfaces of bodies, in their own colours or in the next free ones."""
    return tuple(
        PaintedBody(
            body.name, tuple(_surfaces(body, body.color or COLORS[i % len(COLORS)])), body.whirl
        )
        for i, body in enumerate(bodies)
    )


def _surfaces(body: BodyGeometry, color: Color) -> Iterator[PaintedShape]:
    if body.drawn is None:
        yield from (_painted(shape, body, color) for shape in body.shapes)
        return
    for mesh in body.drawn:
        yield PaintedShape((weld(mesh.vertices, mesh.faces, mesh.color),))


def _painted(shape: Shape, body: BodyGeometry, color: Color) -> PaintedShape:
    if body.whirl and isinstance(shape, Disk) and shape.axis == "z":
        return PaintedShape((rotor(shape, np.asarray(color)),))
    if isinstance(shape, Box):
        return PaintedShape((paint(shape, color),))
    radius = float(shape.radius)
    return PaintedShape(tuple(paint(shape, color, radius / size) for size in DEGREES), radius)


def paint(shape: Shape, color: ArrayLike, pixel: float = 0.0) -> SurfaceMesh:
    """The surface of a shape in its body's frame, with a pattern that makes rotation visible."""
    tint = np.asarray(color, dtype=np.float64)
    if isinstance(shape, Disk):
        return _round(shape.radius, shape.thickness, shape.axis, shape.at, tint, pixel)
    if isinstance(shape, Cylinder):
        return _round(shape.radius, shape.length, shape.axis, shape.at, tint, pixel)
    if isinstance(shape, Sphere):
        return ball(np.asarray(shape.at, dtype=np.float64), float(shape.radius), tint, pixel)
    corners = CORNERS[fineness(shape.radius, pixel)] if isinstance(shape, Capsule) else SECTIONS
    return weld(*triangles(shape, corners), tint)


def _round(
    radius: object, length: object, axis: str, at: ArrayLike, color: Array, pixel: float
) -> SurfaceMesh:
    """A cylinder with alternating sectors on both caps and along the rim."""
    r, h = float(radius), 0.5 * float(length)  # type: ignore[arg-type]
    segments = SEGMENTS[fineness(r, pixel)]
    angle = 2.0 * np.pi * np.arange(segments) / segments
    ring = np.stack([r * np.cos(angle), r * np.sin(angle), np.full(segments, h)], axis=1)
    vertices = np.concatenate([ring, ring * (1.0, 1.0, -1.0), [[0, 0, h], [0, 0, -h]]])
    faces, segment = _round_faces(segments)
    sector = segment * SECTORS // segments
    colors = np.where((sector % 2 == 0)[:, None], color, pale(color))
    colors[sector == 0] = MARK
    return weld(vertices[:, AXES[axis]] + np.asarray(at, dtype=np.float64), faces, colors)


def _round_faces(segments: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Caps and rim over an upper ring, a lower ring and two centres, and each face's segment."""
    a = np.arange(segments)
    b, top, bottom = (a + 1) % segments, np.full(segments, 2 * segments), a + segments
    upper = np.stack([top, a, b], axis=1)
    lower = np.stack([top + 1, b + segments, bottom], axis=1)
    left = np.stack([bottom, b + segments, b], axis=1)
    right = np.stack([bottom, b, a], axis=1)
    return np.concatenate([upper, lower, left, right]), np.tile(a, 4)
