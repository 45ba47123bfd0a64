"""Write the meshes of the built-in scenarios; run it after changing a world.

python scenarios/meshes/write_meshes.py
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import trimesh

HERE = Path(__file__).parent
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


def wall(segment: Segment) -> trimesh.Trimesh:
    """Return a box along an axis-parallel segment (x0, y0, x1, y1), standing on the ground."""
    x0, y0, x1, y1 = segment
    edges = (abs(x1 - x0) + THICKNESS, abs(y1 - y0) + THICKNESS, HEIGHT)
    box = trimesh.creation.box(edges)
    box.apply_translation(((x0 + x1) / 2, (y0 + y1) / 2, HEIGHT / 2))
    return box


def rolling_disk_maze() -> trimesh.Trimesh:
    """Return walls 1 m high on a floor of 10 m by 10 m."""
    return trimesh.util.concatenate([wall(segment) for segment in DISK_MAZE])


MESHES: dict[str, Callable[[], trimesh.Trimesh]] = {"rolling_disk_maze.stl": rolling_disk_maze}


def main() -> None:
    """Write every mesh beside this script."""
    for name, make in MESHES.items():
        mesh = make()
        mesh.export(HERE / name)
        print(f"{name}: {len(mesh.faces)} triangles")


if __name__ == "__main__":
    main()
