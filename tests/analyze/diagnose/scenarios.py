"""Small scenarios, each with one thing wrong."""

from __future__ import annotations

from tests.support import OPEN

PENDULUM = """\
schema = 1
title = "A pendulum"

[system]
name = "pendulum"

[goal]
theta = 1.5707963267948966
at_rest = true
tolerance = 0.01

[integration]
step = 0.05

[planner]
improve = 0
"""

ROOM = """\
schema = 1
title = "A room with a wall across it, and a door"

[system]
name = "diff_drive"

[world]
bounds = { x = [-2, 2], y = [-2, 2] }
ground = "plane"

[start]
x = -1.0
y = 0.5

[goal]
x = 1.0
y = 0.3
tolerance = 0.2

[planner]
improve = 0
"""

ROBOT, COIN = 0.37, 0.05  # [m]: the widths of the robot, over its wheels, and of the coin


def door(width: float, machine: str = "diff_drive") -> str:
    """Return the room with a door of some width in [m] in the middle of its wall."""
    walls = [("left wall", 1), ("right wall", -1)]
    return ROOM.replace("diff_drive", machine) + "".join(
        box(name, (0.1, 2.0, 1.0), (0.0, side * (1.0 + width / 2), 0.5)) for name, side in walls
    )


def box(name: str, edges: tuple[float, float, float], position: tuple[float, float, float]) -> str:
    """Return an obstacle."""
    return (
        f'\n[[world.obstacle]]\nname = "{name}"\nbox = {list(edges)}\nposition = {list(position)}\n'
    )


def ring(half: float) -> str:
    """Return the table with walls all around its goal, their inner sides so far from it in [m]."""
    at, long = half + 0.05, 2 * half + 0.2
    sides = [((at, 0.0), (0.1, long)), ((-at, 0.0), (0.1, long))]
    sides += [((0.0, at), (long, 0.1)), ((0.0, -at), (long, 0.1))]
    return OPEN + "".join(
        box(f"wall {k}", (*edges, 1.0), (*place, 0.5)) for k, (place, edges) in enumerate(sides, 1)
    )
