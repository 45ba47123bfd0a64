"""How bodies are coloured: round ones in sectors, so that one sees them turn."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinolab.dynamics.shapes import Cylinder, Disk, Shape, Sphere
from kinolab.render.mesh import Mesh, join, weld
from kinolab.render.rotor import rotor
from kinolab.world.geometry import triangles

if TYPE_CHECKING:
    from kinolab.world.geometry import BodyGeometry

Array: TypeAlias = NDArray[np.float64]
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
MARK: Color = (0.13, 0.16, 0.22)  # the one sector by which a full turn is counted

SECTORS, SEGMENTS = 8, 48  # SEGMENTS is a multiple of SECTORS: their borders coincide
AXES = {"x": [2, 0, 1], "y": [1, 2, 0], "z": [0, 1, 2]}  # cyclic, so orientation is kept


def paint_machine(bodies: Sequence[BodyGeometry]) -> tuple[Mesh, ...]:
    """One mesh per body in the body's frame, in its own colour or in the next free one."""
    return tuple(
        join(
            [_painted(shape, body, body.color or COLORS[i % len(COLORS)]) for shape in body.shapes]
        )
        for i, body in enumerate(bodies)
    )


def _painted(shape: Shape, body: BodyGeometry, color: Color) -> Mesh:
    if body.whirl and isinstance(shape, Disk) and shape.axis == "z":
        return rotor(shape, np.asarray(color))
    return paint(shape, color)


def paint(shape: Shape, color: ArrayLike) -> Mesh:
    """The surface of a shape in its body's frame, with a pattern where a turn would go unseen."""
    tint = np.asarray(color, dtype=np.float64)
    if isinstance(shape, Disk):
        return _round(shape.radius, shape.thickness, shape.axis, shape.at, tint)
    if isinstance(shape, Cylinder):
        return _round(shape.radius, shape.length, shape.axis, shape.at, tint)
    if isinstance(shape, Sphere):
        return ball(np.asarray(shape.at, dtype=np.float64), float(shape.radius), tint)
    return weld(*triangles(shape), tint)


def ball(centre: Array, radius: float, color: Array) -> Mesh:
    """A sphere whose eight octants alternate between a colour and a pale tint of it."""
    corners = _octahedron()
    for _ in range(3):
        corners = _quartered(corners)
    parity = np.prod(corners.mean(axis=1), axis=1) > 0.0
    faces = np.arange(3 * len(corners)).reshape(-1, 3)
    colors = np.where(parity[:, None], color, pale(color))
    return weld(centre + radius * corners.reshape(-1, 3), faces, colors)


def pale(color: Array) -> Array:
    """A light tint of a colour."""
    return np.asarray(0.2 * color + 0.8 * np.asarray(PALE), dtype=np.float64)


def _round(radius: object, length: object, axis: str, at: ArrayLike, color: Array) -> Mesh:
    """A cylinder with alternating sectors on both caps and along the rim."""
    r, h = float(radius), 0.5 * float(length)  # type: ignore[arg-type]
    angle = 2.0 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    ring = np.stack([r * np.cos(angle), r * np.sin(angle), np.full(SEGMENTS, h)], axis=1)
    vertices = np.concatenate([ring, ring * (1.0, 1.0, -1.0), [[0, 0, h], [0, 0, -h]]])
    faces, segment = _round_faces()
    sector = segment * SECTORS // SEGMENTS
    colors = np.where((sector % 2 == 0)[:, None], color, pale(color))
    colors[sector == 0] = MARK
    return weld(vertices[:, AXES[axis]] + np.asarray(at, dtype=np.float64), faces, colors)


def _round_faces() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Caps and rim over an upper ring, a lower ring and two centres, and each face's segment."""
    a = np.arange(SEGMENTS)
    b, top, bottom = (a + 1) % SEGMENTS, np.full(SEGMENTS, 2 * SEGMENTS), a + SEGMENTS
    upper = np.stack([top, a, b], axis=1)
    lower = np.stack([top + 1, b + SEGMENTS, bottom], axis=1)
    left = np.stack([bottom, b + SEGMENTS, b], axis=1)
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
