"""Slimmer machines, to see by how much a way is too narrow."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from kinolab.dynamics.facts.machine_facts import BodyGeometry, CableGeometry
from kinolab.dynamics.language.shapes import Shape

# [m] that is left of every edge and diameter, so that nothing slips through walls
MIN_THICKNESS = 1e-3


def shrunk_body(body: BodyGeometry, by: float) -> BodyGeometry:
    """Return a body whose shapes are slimmer by a length in [m] on every side.

    What it takes off a body that rests on the ground is missing below it too.
    """
    return replace(body, shapes=tuple(shrunk_shape(shape, by) for shape in body.shapes))


def shrunk_cable(cable: CableGeometry, by: float) -> CableGeometry:
    """Return a cable whose radius is smaller by a length in [m]; its ends stay."""
    return replace(cable, radius=max(cable.radius - by, MIN_THICKNESS / 2))


def shrunk_shape(shape: Shape, by: float) -> Shape:
    """Return a shape slimmer by a length in [m] on every side; a capsule keeps its axis.

    Of an edge or a diameter ``MIN_THICKNESS`` is left, or all of it where it is thinner than that.
    """

    def left(width: Any) -> float:
        return max(float(width) - 2 * by, min(float(width), MIN_THICKNESS))

    return shape.shrunk(left)
