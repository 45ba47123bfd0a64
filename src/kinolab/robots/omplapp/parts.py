"""Solids as the parts of a rigid body: along its axes, or turned in it."""

from __future__ import annotations

from collections.abc import Sequence

from kinolab.dynamics.language.frames import WORLD
from kinolab.robots.machine.robot_machine import along_the_axes
from kinolab.robots.tree.constant_frames import constant_frame
from kinolab.robots.tree.kinematic_tree import PlacedShape
from kinolab.systems._rigid_bodies import Part


def parts_of(solids: Sequence[PlacedShape]) -> list[Part]:
    """Return solids with their frames in a body; those along its axes come first, together."""
    placed = [(solid, along_the_axes(solid.shape, solid.pose)) for solid in solids]
    aligned = [shape for _, shape in placed if shape is not None]
    turned = [solid for solid, shape in placed if shape is None]
    return [
        (WORLD, aligned),
        *((constant_frame(solid.pose), [solid.shape]) for solid in turned),
    ]
