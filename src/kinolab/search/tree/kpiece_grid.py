"""Cells of a grid over where a machine is, and which of them to grow from next.

Far from the goal a cell is one of the first coordinates. Near it, it is one of everything that the
goal names, rates included, and half as wide at half the distance: all that is on the way in has a
cell of its own. A cell is the more important the nearer it is to the goal, the fewer states it
holds and the more seldom it was chosen; what came of it counts too.

Source: Sucan, Kavraki, Kinodynamic motion planning by interior-exterior cell exploration, WAFR
2008.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.kd_forest import (
    Integers,
)
from kinolab.numerics.rng import uniform
from kinolab.problem import PlanningTask
from kinolab.problem.goal_kernel import normalized_error
from kinolab.problem.metric import CELLS_AROUND_GOAL, projected_coordinates
from kinolab.search.tree.problem_arrays import ProblemArrays

EMPTY = -1
BLOCK = 64  # cells whose most important one is known
NEAR_GOAL_STEPS = 2.0  # steps of a lead: what is near the goal behind a wall is not
# probability that an older state of a cell is chosen instead of a younger one
OLDER_STATE_PROBABILITY = 0.3
GOOD, BAD = 0.9, 0.45  # factors on the importance of a cell from which growth came to something
FIRST, NEXT = -3750763034362895579, 1099511628211  # FNV-1a, 64 bits


class KpieceGrid(NamedTuple):
    """Cells that hold nodes, for compiled code."""

    entry: Integers  # (k,) entries of the state that are divided
    lower: Array  # (k,)
    per_unit: Array  # (k,) cells per unit
    around: Array  # (k,) cells until the first one comes again; infinite on a line
    goal_region_scale: float  # what counts as near the goal, in its tolerances
    across: float  # cells over all of the goal's tolerances, at the finest
    table: NDArray[np.int32]  # (places,) cells by the hash of their key, EMPTY where there is none
    key: Integers  # (capacity,) of cells
    newest: NDArray[np.int32]  # (capacity,) node of a cell
    held: NDArray[np.int32]  # (capacity,) nodes of a cell
    chosen: NDArray[np.int32]  # (capacity,) how often a cell was
    score: Array  # (capacity,) of cells
    importance: Array  # (capacity,) of cells
    best: NDArray[np.int32]  # (blocks,) the most important cell of a block
    older: NDArray[np.int32]  # (capacity,) by node: the next older one in its cell
    size: Integers  # (1,) of cells


def kpiece_grid(
    problem: PlanningTask,
    arrays: ProblemArrays,
    capacity: int,
    goal_region_scale: float,
    across: int,
) -> KpieceGrid:
    """Return no cells, with room for as many nodes.

    Args:
        problem: Whose machine.
        arrays: Of the same problem.
        capacity: Nodes, and cells, at most.
        goal_region_scale: What counts as near the goal, in its tolerances.
        across: Cells along each coordinate that is divided.
    """
    entries = projected_coordinates(problem)
    lower, upper = problem.sampling_bounds[entries].T
    named = len(arrays.goal.entry)
    places = 1 << max(4, (2 * capacity).bit_length())
    return KpieceGrid(
        entry=np.array(entries, dtype=np.int64),
        lower=np.ascontiguousarray(lower),
        per_unit=across / (upper - lower),
        around=np.where(problem.circular[entries], float(across), np.inf),
        goal_region_scale=float(goal_region_scale) if named else 0.0,
        across=float(max(2, round(CELLS_AROUND_GOAL ** (1 / max(1, named))))),
        table=np.full(places, EMPTY, np.int32),
        key=np.zeros(capacity, np.int64),
        newest=np.zeros(capacity, np.int32),
        held=np.zeros(capacity, np.int32),
        chosen=np.zeros(capacity, np.int32),
        score=np.zeros(capacity),
        importance=np.zeros(capacity + BLOCK),
        best=np.zeros(capacity // BLOCK + 1, np.int32),
        older=np.zeros(capacity, np.int32),
        size=np.zeros(1, np.int64),
    )


@kernel
def clear_cells(cells):  # type: ignore[no-untyped-def]
    """Forget all cells."""
    cells.table[:] = EMPTY
    cells.importance[:] = 0.0
    cells.size[0] = 0


@kernel
def key_of(cells, goal, x, steps):  # type: ignore[no-untyped-def]
    """Return the key of the cell that a state lies in, some steps of a lead from the goal.

    A few of many millions share one.
    """
    farthest = 0.0
    for k in range(goal.entry.shape[0]):
        farthest = max(farthest, abs(normalized_error(goal, k, x)))
    key = FIRST
    if farthest >= cells.goal_region_scale or steps > NEAR_GOAL_STEPS:
        for k in range(cells.entry.shape[0]):
            place = math.floor((x[cells.entry[k]] - cells.lower[k]) * cells.per_unit[k])
            if cells.around[k] != math.inf:
                place -= cells.around[k] * math.floor(place / cells.around[k])
            key = (key ^ int(place)) * NEXT
        return key
    level = math.floor(math.log2(cells.goal_region_scale / max(1.0, farthest)))
    per_tolerance = 0.5 * cells.across * 2.0**level / cells.goal_region_scale
    key = (key ^ int(-1 - level)) * NEXT
    for k in range(goal.entry.shape[0]):
        key = (key ^ math.floor(normalized_error(goal, k, x) * per_tolerance)) * NEXT
    return key


@kernel
def place_of(cells, key):  # type: ignore[no-untyped-def]
    """Return where in the table a cell is, or would be."""
    last = cells.table.shape[0] - 1
    place = (key ^ (key >> 29)) & last
    while cells.table[place] != EMPTY and cells.key[cells.table[place]] != key:
        place = (place + 1) & last
    return place


@kernel
def holds(cells, key):  # type: ignore[no-untyped-def]
    """Return how many nodes a cell holds."""
    cell = cells.table[place_of(cells, key)]
    return 0 if cell == EMPTY else cells.held[cell]


@kernel
def put(cells, key, node, score):  # type: ignore[no-untyped-def]
    """Put a node into a cell; a new one has a score."""
    place = place_of(cells, key)
    cell = cells.table[place]
    if cell == EMPTY:
        cell = cells.size[0]
        cells.size[0] += 1
        cells.table[place], cells.key[cell] = cell, key
        cells.newest[cell], cells.held[cell], cells.chosen[cell] = EMPTY, 0, 0
        cells.score[cell] = score
    cells.older[node], cells.newest[cell] = cells.newest[cell], node
    cells.held[cell] += 1
    weigh(cells, cell)


@kernel
def weigh(cells, cell):  # type: ignore[no-untyped-def]
    """Work out how important a cell is."""
    cells.importance[cell] = cells.score[cell] / ((1.0 + cells.chosen[cell]) * cells.held[cell])
    first = cell // BLOCK * BLOCK
    best = first
    for k in range(first, first + BLOCK):
        if cells.importance[k] > cells.importance[best]:
            best = k
    cells.best[cell // BLOCK] = best


@kernel
def choose(cells, random):  # type: ignore[no-untyped-def]
    """Choose the most important cell, and a node of it: rather a young one."""
    found, most = 0, -1.0
    for block in range((cells.size[0] + BLOCK - 1) // BLOCK):
        cell = cells.best[block]
        if cells.importance[cell] > most:
            found, most = cell, cells.importance[cell]
    cells.chosen[found] += 1
    node = cells.newest[found]
    while cells.older[node] != EMPTY and uniform(random) < OLDER_STATE_PROBABILITY:
        node = cells.older[node]
    return found, np.int64(node)


@kernel
def rate(cells, cell, good):  # type: ignore[no-untyped-def]
    """Lower the score of a cell from which was grown."""
    cells.score[cell] *= GOOD if good else BAD
    weigh(cells, cell)
