"""The bodies of a machine: what they weigh, and how large their shapes are."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.dynamics import Body, System
from kinolab.world.shapes.geometry import half_extents, placement


@dataclass(frozen=True)
class BodySize:
    """A body's mass and size.

    Attributes:
        name: Name of the body.
        mass: In [kg].
        inertia: The largest moment about the centre of mass, in [kg m^2].
        extent: Edges of the box around its shapes, along the axes of its frame, in [m]; None if it
            has no shape.
    """

    name: str
    mass: float
    inertia: float
    extent: tuple[float, float, float] | None


def body_sizes(system: System) -> tuple[BodySize, ...]:
    """Return masses and sizes of a machine's bodies, in its order."""
    return tuple(
        BodySize(
            body.name,
            system.number(body.mass),
            float(np.linalg.eigvalsh(system.inertia_of(body))[-1]),
            _extent(system, body),
        )
        for body in system.bodies
    )


def _extent(system: System, body: Body) -> tuple[float, float, float] | None:
    corners = []
    for shape in system.resolved_shapes(body):
        frame = placement(shape)
        corners += [
            frame[:, 3] + sign * half_extents(shape, sign * frame[:, :3]) for sign in (-1.0, 1.0)
        ]
    if not corners:
        return None
    x, y, z = np.ptp(corners, axis=0).tolist()
    return x, y, z
