"""Cells of a binary space partition, and the motions within them by their scores.

The edge to a node of the tree is a motion, and lies within one cell. A cell that is divided divides
its motions, too, where they pass from one half into the other. The motion to grow is the one of the
least priority in units of its cell's volume: a heap has it on top.

Source: Ladd, Kavraki, Motion planning in the presence of drift, underactuation and discrete system
changes, RSS 2005.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array, Integers, allocate
from kinolab.numerics.jit import kernel
from kinolab.problem import PlanningTask
from kinolab.problem.metric import projected_coordinates
from kinolab.search.tree.flat_arrays import copy

LEAF, NOTHING = -1, -1
MOTIONS, CELLS, ROUNDS = range(3)  # entries of ``Subdivision.counts``


class Subdivision(NamedTuple):
    """Cells and motions in flat arrays, for compiled kernels; cell 0 is everything."""

    entry: Annotated[Integers, "k"]  # divided entries of the state
    around: Annotated[Array, "k"]  # period of an angle on the circle; infinite on a line
    axis: Annotated[NDArray[np.int32], "cells"]  # which of them divides a cell; LEAF for none
    middle: Annotated[Array, "cells"]  # where
    half: Annotated[NDArray[np.int32], "cells"]  # its lower half; the upper one is the next
    divisions: Annotated[NDArray[np.int32], "cells"]  # that led to it
    lower: Annotated[Array, "cells", "k"]
    upper: Annotated[Array, "cells", "k"]
    first: Annotated[NDArray[np.int32], "cells"]  # a motion in it
    following: Annotated[NDArray[np.int32], "capacity"]  # the next one in the same cell
    cell: Annotated[NDArray[np.int32], "capacity"]  # which it lies in
    priority: Annotated[Array, "capacity"]
    heap: Annotated[NDArray[np.int32], "capacity"]  # that of the least score first
    place: Annotated[NDArray[np.int32], "capacity"]  # of a motion in the heap
    counts: Annotated[Integers, 3]  # motions in the heap, cells, rounds
    at: Annotated[Array, "nx"]  # scratch
    then: Annotated[Array, "nx"]  # scratch


def subdivision(problem: PlanningTask, capacity: int) -> Subdivision:
    """Allocate cells over the projection of a problem's states.

    Args:
        capacity: Maximum number of motions; there are as many cells.
    """
    entries = projected_coordinates(problem)
    bounds, cells = problem.sampling_bounds[entries], capacity + 2
    spans = bounds[:, 1] - bounds[:, 0]
    boxes = np.zeros((2, cells, len(entries)))
    boxes[:, 0] = bounds.T
    return allocate(
        Subdivision,
        {"capacity": capacity, "cells": cells, "nx": problem.model.nx},
        entry=np.array(entries, dtype=np.int64),
        around=np.where(problem.circular[entries], spans, np.inf),
        axis=np.full(cells, LEAF, np.int32),
        lower=boxes[0],
        upper=boxes[1],
        first=np.full(cells, NOTHING, np.int32),
    )


@kernel
def clear_motions(cells):  # type: ignore[no-untyped-def]
    """Remove all motions; one cell is left."""
    cells.axis[0], cells.first[0] = LEAF, NOTHING
    cells.counts[MOTIONS], cells.counts[CELLS], cells.counts[ROUNDS] = 0, 1, 0


@kernel
def coordinate(cells, x, k):  # type: ignore[no-untyped-def]
    """Return divided coordinate k of a state x (nx,) as ``cells`` count; angles within one turn."""
    value = x[cells.entry[k]]
    if cells.around[k] != np.inf:
        value -= cells.around[k] * np.floor((value - cells.lower[0, k]) / cells.around[k])
    return value


@kernel
def cell_of(cells, x):  # type: ignore[no-untyped-def]
    """Return the cell in which a state x (nx,) lies."""
    cell = 0
    while cells.axis[cell] != LEAF:
        above = coordinate(cells, x, cells.axis[cell]) >= cells.middle[cell]
        cell = cells.half[cell] + (1 if above else 0)
    return cell


@kernel
def score(cells, motion):  # type: ignore[no-untyped-def]
    """Return a motion's priority in units of its cell's volume; the least is grown first."""
    return cells.priority[motion] * 2.0 ** cells.divisions[cells.cell[motion]]


@kernel
def add_motion(cells, motion, cell, priority):  # type: ignore[no-untyped-def]
    """Add a motion to a cell and to the heap."""
    cells.priority[motion] = priority
    put_into(cells, motion, cell)
    last = cells.counts[MOTIONS]
    cells.heap[last], cells.place[motion] = motion, last
    cells.counts[MOTIONS] = last + 1
    settle(cells, motion)


@kernel
def put_into(cells, motion, cell):  # type: ignore[no-untyped-def]
    """Add a motion to the list of a cell."""
    cells.cell[motion], cells.following[motion] = cell, cells.first[cell]
    cells.first[cell] = motion


@kernel
def settle(cells, motion):  # type: ignore[no-untyped-def]
    """Move a motion to where its score belongs in the heap."""
    heap, place, size = cells.heap, cells.place, cells.counts[MOTIONS]
    at, own = np.int64(place[motion]), score(cells, motion)
    while at > 0 and score(cells, heap[(at - 1) // 2]) > own:
        above = (at - 1) // 2
        heap[at] = heap[above]
        place[heap[at]] = at
        at = above
    while 2 * at + 1 < size:
        below = 2 * at + 1
        if below + 1 < size and score(cells, heap[below + 1]) < score(cells, heap[below]):
            below += 1
        if score(cells, heap[below]) >= own:
            break
        heap[at] = heap[below]
        place[heap[at]] = at
        at = below
    heap[at], place[motion] = motion, at


@kernel
def halved(cells, cell):  # type: ignore[no-untyped-def]
    """Divide a cell across the coordinates in turn; return its lower half. Its motions stay."""
    k = cells.divisions[cell] % cells.entry.shape[0]
    low = np.int64(cells.counts[CELLS])
    cells.axis[cell], cells.half[cell] = k, low
    cells.middle[cell] = 0.5 * (cells.lower[cell, k] + cells.upper[cell, k])
    for half in (low, low + 1):
        cells.axis[half], cells.first[half] = LEAF, NOTHING
        cells.divisions[half] = cells.divisions[cell] + 1
        copy(cells.lower[cell], cells.lower[half])
        copy(cells.upper[cell], cells.upper[half])
    cells.upper[low, k] = cells.lower[low + 1, k] = cells.middle[cell]
    cells.counts[CELLS] = low + 2
    return low
