"""Coloured meshes of bodies: round ones in sectors, so that rotation is visible."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from kinolab.dynamics.language.shapes import Shape, ShapeKind
from kinolab.numerics.arrays import Array
from kinolab.show.scene.models.ball import Color, Pattern, ball, pale
from kinolab.show.scene.models.painted_body import DEGREES, PaintedBody, fineness
from kinolab.show.scene.models.rotor import rotor
from kinolab.show.scene.models.surface_mesh import SurfaceMesh, weld
from kinolab.world.shapes.geometry import SECTIONS, placement, triangles
from kinolab.world.shapes.shape_surfaces import cylinder_surface

if TYPE_CHECKING:
    from kinolab.dynamics.facts.machine_facts import BodyGeometry

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


def painted_bodies(bodies: Sequence[BodyGeometry]) -> tuple[PaintedBody, ...]:
    """The surfaces of bodies, in their own colours or in the next free ones."""
    return tuple(
        PaintedBody(
            body.name,
            tuple(_surfaces(body, body.color or COLORS[i % len(COLORS)])),
            body.whirl,
            body.prescribed,
        )
        for i, body in enumerate(bodies)
    )


def _surfaces(body: BodyGeometry, color: Color) -> Iterator[tuple[float, Sequence[SurfaceMesh]]]:
    for mesh in body.drawn or ():
        yield 0.0, [weld(mesh.vertices, mesh.faces, mesh.color)]
    for shape in body.shapes if body.drawn is None else ():
        if body.whirl and shape.rotor and shape.axis == "z":
            yield 0.0, [rotor(shape, np.asarray(color))]
        elif shape.symmetric:
            radius = shape.lowered()[1][0]
            yield radius, [paint(shape, color, radius / size) for size in DEGREES]
        else:
            yield 0.0, [paint(shape, color)]


def paint(shape: Shape, color: ArrayLike, pixel: float = 0.0) -> SurfaceMesh:
    """The surface of a shape in its body's frame, with a pattern that makes rotation visible."""
    kind, (radius, _, length, *_) = shape.lowered()
    tint, detail = np.asarray(color, dtype=np.float64), fineness(radius, pixel)
    if kind in PATTERNS:
        own, frame = PATTERNS[kind](radius, length, tint, detail), placement(shape)
        return weld(own[0] @ frame[:, :3].T + frame[:, 3], *own[1:])
    # Corners of a circle, half as many on a capsule.
    return weld(*triangles(shape, (16, 32, SECTIONS)[detail]), tint)


def _round(radius: float, half: float, color: Array, detail: int) -> Pattern:
    """Return a cylinder along z with alternating sectors on both caps and along the rim."""
    # Segments of a circle, multiples of SECTORS: their borders coincide
    vertices, faces = cylinder_surface(radius, half, (8, 16, 48)[detail])
    sector = np.arange(len(faces)) * SECTORS // len(faces)
    colors = np.where((sector % 2 == 0)[:, None], color, pale(color))
    colors[sector == 0] = MARK
    return vertices, faces, colors


# Of a radius and half a length in [m], a colour and a degree of detail: the surface about z.
PATTERNS: dict[ShapeKind, Callable[[float, float, Array, int], Pattern]] = {
    ShapeKind.SPHERE: lambda radius, _, color, detail: ball(radius, color, detail),
    ShapeKind.CYLINDER: _round,
}
