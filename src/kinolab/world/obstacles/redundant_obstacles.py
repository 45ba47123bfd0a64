"""Which obstacles can be met at all: none that repeats another one, or lies inside of it."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
import scipy

from kinolab.world.obstacles.obstacle import Obstacle
from kinolab.world.shapes.geometry import frame_in_world, half_extents

CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


def without_redundant(obstacles: Sequence[Obstacle]) -> tuple[Obstacle, ...]:
    """Leave out what repeats an earlier shape that is no mesh, or lies inside a larger one.

    Nothing can come near to it without being as near to the other one. Meshes stay, and hide
    nothing; so does a shape of which only the corners of a box around it stick out.
    """
    first: dict[object, int] = {}
    for k, obstacle in enumerate(obstacles):
        first.setdefault(_key(obstacle), k)
    left = [obstacles[k] for k in first.values()]
    solids = [(obstacle, *obstacle.primitive) for obstacle in left if obstacle.primitive]
    if len(solids) < 2:
        return tuple(left)
    places = [frame_in_world(shape, pose) for _, shape, pose in solids]
    halves = [half_extents(shape, np.eye(3)) for _, shape, _ in solids]
    around = zip(halves, places, strict=True)  # boxes along the shapes' own axes
    corners = np.stack([(CORNERS * half) @ turn.T + at for half, (turn, at) in around])
    volumes, hidden = np.array([*map(np.prod, halves)]), np.zeros(len(solids), dtype=bool)
    middles = np.array([at for _, at in places])
    # the middle of what is inside of a shape is no farther from the shape's own than its corners
    reach = np.array([np.linalg.norm(half[:3]) + half[0] for half in halves])
    near = scipy.spatial.cKDTree(middles).query_ball_point(middles, reach, return_sorted=True)
    for k, ((_, shape, _), (turn, at)) in enumerate(zip(solids, places, strict=True)):
        if len(near[k]) == 1:
            continue  # nothing but itself
        others = np.array(near[k])
        smaller = others[(volumes[others] < volumes[k]) & ~hidden[others]]
        inside = shape.depths((corners[smaller] - at) @ turn) >= 0.0
        hidden[smaller] = inside.all(axis=1)
    inner = {id(obstacle) for (obstacle, *_), is_in in zip(solids, hidden, strict=True) if is_in}
    return tuple(obstacle for obstacle in left if id(obstacle) not in inner)


def _key(obstacle: Obstacle) -> object:
    """Return what two obstacles have in common that are the same."""
    if obstacle.primitive is None:
        return id(obstacle)
    shape, pose = obstacle.primitive
    return shape, pose.tobytes()
