"""Slimmer machines, to see by how much a way is too narrow."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from kinolab.dynamics.language.shapes import Box, Cylinder, Disk, Shape
from kinolab.world.cable import CableGeometry
from kinolab.world.geometry import BodyGeometry

THINNEST = 1e-3  # [m] that is left of every edge and diameter, so that nothing slips through walls


def slimmer_body(body: BodyGeometry, by: float) -> BodyGeometry:
    """Return a body whose shapes are slimmer by a length in [m] on every side.

    What it takes off a body that rests on the ground is missing below it too.
    """
    return replace(body, shapes=tuple(slimmer_shape(shape, by) for shape in body.shapes))


def slimmer_cable(cable: CableGeometry, by: float) -> CableGeometry:
    """Return a cable whose radius is smaller by a length in [m]; its ends stay."""
    return replace(cable, radius=max(cable.radius - by, THINNEST / 2))


def slimmer_shape(shape: Shape, by: float) -> Shape:
    """Return a shape slimmer by a length in [m] on every side; a capsule keeps its axis.

    Of an edge or a diameter ``THINNEST`` is left, or all of it where it is thinner than that.
    """

    def left(width: Any) -> float:
        return max(float(width) - 2 * by, min(float(width), THINNEST))

    match shape:
        case Box():
            return replace(shape, x=left(shape.x), y=left(shape.y), z=left(shape.z))
        case Cylinder():
            radius, length = left(2 * shape.radius) / 2, left(shape.length)
            return replace(shape, radius=radius, length=length)
        case Disk():
            radius, thickness = left(2 * shape.radius) / 2, left(shape.thickness)
            return replace(shape, radius=radius, thickness=thickness)
    return replace(shape, radius=left(2 * shape.radius) / 2)
