"""Distance grids on disk and in memory, by content: of which obstacles, how fine, by which code.

An entry takes at most 20 MB, all of them 1 GB: those that were used last stay.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from threading import Lock

import numpy as np

from kinolab.store import Kind, pack_arrays, unpack_arrays
from kinolab.world.distances.distance_field import DistanceField, digest, distance_field
from kinolab.world.obstacles.obstacle import Obstacle

MIN_CELLS = 2**18  # cells, below which building a grid takes hardly longer than reading it


def _pack(grid: DistanceField) -> bytes:
    return pack_arrays((grid.low, np.float64(grid.width), grid.distance))


def _unpack(content: memoryview) -> DistanceField:
    low, width, distance = unpack_arrays(content, np.float64, np.float64, np.float32)
    if low.shape != (3,) or distance.ndim != 3:
        raise ValueError("it is not a grid")
    return DistanceField(low, float(width), distance)


GRIDS = Kind("distances", _pack, _unpack, (Path(__file__).parents[1],), most=2**30)

_shared: dict[tuple[str, float], DistanceField] = {}  # that was used last comes last
_one_at_a_time = Lock()


def cached_distance_field(
    obstacles: Sequence[Obstacle], finest: float = 0.0, name: str | None = None
) -> DistanceField:
    """Return the grid of some obstacles as ``distance_field`` does, from disk where it is there.

    Args:
        finest: Edge of a cell in [m] below which nothing is gained.
        name: Their ``digest``, where it is known.
    """
    if not obstacles:
        return distance_field(obstacles, finest)
    content = name or digest(obstacles), repr(finest)
    grid = GRIDS.find(content)
    if grid is None:
        grid = distance_field(obstacles, finest)
        if grid.distance.size >= MIN_CELLS:
            GRIDS.keep(content, grid)
    return grid


def shared_distance_field(obstacles: Sequence[Obstacle], finest: float) -> DistanceField:
    """Return ``cached_distance_field``, the same one for worlds that were asked for just before."""
    with _one_at_a_time:  # threads that begin together want the same one
        key = digest(obstacles), finest
        grid = _shared.pop(key, None) or cached_distance_field(obstacles, finest, key[0])
        _shared[key] = grid
        if len(_shared) > 4:  # grids in memory
            del _shared[next(iter(_shared))]
        return grid
