"""Distance grids on disk and in memory, by content: of which obstacles, how fine, by which code.

An entry that does not match its own checksum is built anew; it is never trusted. An entry takes at
most 20 MB, all of them 1 GB: those that were used last stay.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.cache import code_in, folder
from kinolab.files import discard, keep_last_used, read_sealed, touch, write_sealed
from kinolab.world.collision.distance_field import DistanceField, digest, distance_field
from kinolab.world.obstacle import Obstacle

MAGIC = b"kinolab distance grid 1\n"
SUFFIX = ".distances"
MAX_BYTES = 2**30  # [bytes] of all entries
MIN_CELLS = 2**18  # cells, below which building a grid takes hardly longer than reading it
MAX_SHARED = 4  # grids in memory
HEADER = np.dtype([("low", "<f8", 3), ("width", "<f8"), ("shape", "<i8", 3)])

_shared: dict[tuple[str, float], DistanceField] = {}  # that was used last comes last
_one_at_a_time = Lock()


def cached_distance_field(
    obstacles: Sequence[Obstacle], finest: float = 0.0, name: str | None = None
) -> DistanceField:
    """Return the grid of some obstacles as ``distance_field`` does, from disk where it is there.

    Args:
        obstacles: Of a world.
        finest: Edge of a cell in [m] below which nothing is gained.
        name: Their ``digest``, where it is known.
    """
    if not obstacles:
        return distance_field(obstacles, finest)
    path = folder() / f"{_key(name or digest(obstacles), finest)}{SUFFIX}"
    grid = _read(path)
    if grid is None:
        grid = distance_field(obstacles, finest)
        if grid.distance.size >= MIN_CELLS:
            _write(path, grid)
            keep_last_used(path, MAX_BYTES)
    return grid


def shared_distance_field(obstacles: Sequence[Obstacle], finest: float) -> DistanceField:
    """Return ``cached_distance_field``, the same one for worlds that were asked for just before."""
    with _one_at_a_time:  # threads that begin together want the same one
        key = digest(obstacles), finest
        grid = _shared.pop(key, None) or cached_distance_field(obstacles, finest, key[0])
        _shared[key] = grid
        if len(_shared) > MAX_SHARED:
            del _shared[next(iter(_shared))]
        return grid


def _key(name: str, finest: float) -> str:
    return hashlib.sha256("\0".join([name, repr(finest), _own_code()]).encode()).hexdigest()


@cache
def _own_code() -> str:
    return code_in(Path(__file__).parents[1])


def _read(path: Path) -> DistanceField | None:
    """Return an entry, None where there is none or it is damaged."""
    content = read_sealed(path, MAGIC)
    if content is None:
        return None
    touch(path)
    try:
        head = np.frombuffer(content, HEADER, 1)[0]
        distance = np.frombuffer(content, np.float32, offset=HEADER.itemsize)
        distance = distance.reshape(_sound_shape(head["shape"]))
    except ValueError:
        discard(path, "was damaged")
        return None
    aligned = np.require(distance, requirements=["ALIGNED", "WRITEABLE"])
    return DistanceField(head["low"].copy(), float(head["width"]), aligned)


def _sound_shape(shape: NDArray[np.int64]) -> tuple[int, ...]:
    """Return counts of cells, none of which is to be guessed.

    Raises:
        ValueError: If one is negative.
    """
    if shape.min() < 0:
        raise ValueError("it has a negative count")
    return tuple(shape.tolist())


def _write(path: Path, grid: DistanceField) -> None:
    head = np.zeros(1, HEADER)
    head["low"], head["width"], head["shape"] = grid.low, grid.width, grid.distance.shape
    write_sealed(path, MAGIC, head.tobytes() + grid.distance.tobytes())
