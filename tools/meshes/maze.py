"""The walls of a maze for a rolling coin, on a floor of 10 m by 10 m.

rolling_disk_maze.stl, z up, [m]. ``DISK_MAZE`` lists the walls.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import trimesh
from solids import Solid, join

Segment = tuple[float, float, float, float]

THICKNESS, HEIGHT = 0.2, 1.0  # of a wall, in [m]

DISK_MAZE: Sequence[Segment] = (
    # the hall
    (0.0, 0.0, 10.0, 0.0),
    (0.0, 10.0, 10.0, 10.0),
    (0.0, 0.0, 0.0, 10.0),
    (10.0, 0.0, 10.0, 10.0),
    # two long walls: the way is an S
    (3.3, 0.0, 3.3, 6.6),
    (6.6, 3.4, 6.6, 10.0),
    # a doorway 0.8 m wide, less than two diameters of the coin
    (3.3, 5.0, 4.4, 5.0),
    (5.4, 5.0, 6.6, 5.0),
    # a corridor that points at the goal and ends blind
    (1.2, 8.3, 5.2, 8.3),
    (5.2, 8.3, 5.2, 10.0),
    # stubs
    (1.7, 3.3, 3.3, 3.3),
    (0.0, 5.6, 1.5, 5.6),
    (8.4, 6.6, 10.0, 6.6),
)


def wall(segment: Segment) -> Solid:
    """Return a box along an axis-parallel segment (x0, y0, x1, y1), standing on the ground."""
    x0, y0, x1, y1 = segment
    edges = (abs(x1 - x0) + THICKNESS, abs(y1 - y0) + THICKNESS, HEIGHT)
    box = trimesh.creation.box(edges)
    middle = ((x0 + x1) / 2, (y0 + y1) / 2, HEIGHT / 2)
    return Solid(np.array(box.vertices) + middle, np.array(box.faces))


def rolling_disk_maze() -> Solid:
    """Return walls 1 m high on a floor of 10 m by 10 m."""
    return join([wall(segment) for segment in DISK_MAZE])


MESHES = {"rolling_disk_maze.stl": rolling_disk_maze}
