"""The world: everything around the machine."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from kinolab.world.meshes.mesh_hints import MAX_EXTENT, misfits
from kinolab.world.obstacles.obstacle import Obstacle


@dataclass(frozen=True)
class World:
    """What stands around the machine, and what clearance plans leave beside it.

    Attributes:
        obstacles: What must not be touched.
        ground: Whether there is the plane z = 0.
        bounds: Limits of the workspace in [m], by axis.
        clearance: Distance in [m] that plans keep from every obstacle.
        floors: What the ground covers of meshes: to be seen, and never met.
    """

    obstacles: tuple[Obstacle, ...] = ()
    ground: bool = False
    bounds: dict[str, tuple[float, float]] = field(default_factory=dict)
    clearance: float = 0.0
    floors: tuple[Obstacle, ...] = ()

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences about what is usable but suspicious."""
        found = [text for obstacle in self.obstacles for text in obstacle.warnings]
        found += [text for floor in self.floors for text in floor.warnings]
        for obstacle in (*self.obstacles, *self.floors):
            if obstacle.primitive is None and (obstacle.ball or not obstacle.told):
                found += misfits(obstacle.name, np.ptp(obstacle.vertices, axis=0), self.bounds)
        for axis, (low, high) in self.bounds.items():
            if high - low > MAX_EXTENT:
                found.append(f"[world] bounds {axis}: {high - low:.4g} m wide. Millimetres?")
        return tuple(found)

    @property
    def notes(self) -> tuple[str, ...]:
        """Sentences about what is normal, and good to know."""
        return (*self.sensed, *map(_covered, self.floors))

    @property
    def sensed(self) -> tuple[str, ...]:
        """What obstacles are that stand for what a sensor saw: walls on cells, balls on points."""
        return tuple(str(obstacle) for obstacle in self.obstacles if obstacle.told)

    def describe(self) -> tuple[str, ...]:
        """Say in one line per obstacle what it is."""
        lines = [*map(str, self.obstacles)]
        lines += map(_covered, self.floors)
        return (*lines, "ground: the plane z = 0") if self.ground else tuple(lines)


def _covered(floor: Obstacle) -> str:
    count, low = len(floor.faces), float(floor.vertices[:, 2].min())
    depth = "at z = 0" if low > -1e-6 else f"down to {-1000.0 * low:.3g} mm below z = 0"
    what = "point" if floor.ball else "triangle"
    several = f"1 {what}" if count == 1 else f"{count} {what}s"
    return f"{floor.name}: {several} {depth}, which the ground covers: support, and no obstacle"
