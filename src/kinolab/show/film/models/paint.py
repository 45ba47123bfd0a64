"""Coloured meshes of bodies: round ones in sectors, so that rotation is visible."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.dynamics.language.shapes import Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.numerics.arrays import Array
from kinolab.show.film.models.rotor import rotor
from kinolab.show.film.models.surface_mesh import SurfaceMesh, join, weld
from kinolab.world.geometry import SECTIONS, triangles

if TYPE_CHECKING:
    from kinolab.world.geometry import BodyGeometry

Color: TypeAlias = tuple[float, float, float]

# Okabe and Ito, Color Universal Design, 2008; ordered so that a machine starts with its strongest.
COLORS: tuple[Color, ...] = (
    (0.835, 0.369, 0.000),
    (0.000, 0.447, 0.698),
    (0.800, 0.475, 0.655),
    (0.902, 0.624, 0.000),
    (0.337, 0.706, 0.914),
    (0.000, 0.620, 0.451),
)
PALE: Color = (0.99, 0.97, 0.93)
MARK: Color = (0.13, 0.16, 0.22)  # one sector, to count full turns by

SECTORS = 8
SEGMENTS = (8, 16, 48)  # of a circle, multiples of SECTORS: their borders coincide
CORNERS = (16, 32, SECTIONS)  # of a circle, half as many on a capsule
QUARTERED = (1, 2, 3)  # subdivisions of an octahedron, for a ball
COARSE = (2.0, 8.0)  # [pixel]: radii up to which the first, and the second, look round
AXES = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}  # cyclic, so orientation is kept


def paint_machine(bodies: Sequence[BodyGeometry], pixel: float = 0.0) -> tuple[SurfaceMesh, ...]:
    """One mesh per body in the body's frame, in its own colour or in the next free one.

    Args:
        bodies: The bodies.
        pixel: Size of a pixel in [m], where they are nearest; shapes small in the picture get fewer
            faces.
    """
    return tuple(
        join(
            [
                _painted(shape, body, body.color or COLORS[i % len(COLORS)], pixel)
                for shape in body.shapes
            ]
        )
        for i, body in enumerate(bodies)
    )


def _painted(shape: Shape, body: BodyGeometry, color: Color, pixel: float) -> SurfaceMesh:
    if body.whirl and isinstance(shape, Disk) and shape.axis == "z":
        return rotor(shape, np.asarray(color))
    return paint(shape, color, pixel)


def paint(shape: Shape, color: ArrayLike, pixel: float = 0.0) -> SurfaceMesh:
    """The surface of a shape in its body's frame, with a pattern that makes rotation visible."""
    tint = np.asarray(color, dtype=np.float64)
    if isinstance(shape, Disk):
        return _round(shape.radius, shape.thickness, shape.axis, shape.at, tint, pixel)
    if isinstance(shape, Cylinder):
        return _round(shape.radius, shape.length, shape.axis, shape.at, tint, pixel)
    if isinstance(shape, Sphere):
        return ball(np.asarray(shape.at, dtype=np.float64), float(shape.radius), tint, pixel)
    corners = CORNERS[_fineness(shape.radius, pixel)] if isinstance(shape, Capsule) else SECTIONS
    return weld(*triangles(shape, corners), tint)


def ball(centre: Array, radius: float, color: Array, pixel: float = 0.0) -> SurfaceMesh:
    """A sphere about (x, y, z) whose octants alternate between a colour and a pale tint of it."""
    corners = _octahedron()
    for _ in range(QUARTERED[_fineness(radius, pixel)]):
        corners = _quartered(corners)
    parity = np.prod(corners.mean(axis=1), axis=1) > 0.0
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    colors = np.where(parity[:, None], color, pale(color))
    return weld(centre + radius * corners.reshape(-1, 3), faces, colors)


def pale(color: Array) -> Array:
    """A light tint of a colour, shape (3,)."""
    return np.asarray(0.2 * color + 0.8 * np.asarray(PALE), dtype=np.float64)


def _fineness(radius: Any, pixel: float) -> int:
    """Return the level of detail that a radius in [m] needs: 0 is the coarsest."""
    return sum(float(radius) > most * pixel for most in COARSE)


def _round(
    radius: object, length: object, axis: str, at: ArrayLike, color: Array, pixel: float
) -> SurfaceMesh:
    """A cylinder with alternating sectors on both caps and along the rim."""
    r, h = float(radius), 0.5 * float(length)  # type: ignore[arg-type]
    segments = SEGMENTS[_fineness(r, pixel)]
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


def _octahedron() -> Array:
    """The eight faces of the regular octahedron, seen counterclockwise, shape (8, 3, 3)."""
    x, y, z = np.eye(3)
    signs = [(i, j, k) for i in (1, -1) for j in (1, -1) for k in (1, -1)]
    faces = [[i * x, j * y, k * z][:: i * j * k] for i, j, k in signs]
    return np.array(faces)


def _quartered(corners: Array) -> Array:
    """Split every triangle on the unit sphere into four."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    ab, bc, ca = ((p + q) / np.linalg.norm(p + q, axis=1)[:, None] for p, q in _pairs(a, b, c))
    split = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([np.stack(triangle, axis=1) for triangle in split])


def _pairs(a: Array, b: Array, c: Array) -> list[tuple[Array, Array]]:
    return [(a, b), (b, c), (c, a)]
