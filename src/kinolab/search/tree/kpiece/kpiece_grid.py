"""KPIECE's grid: cells over positions, and their selection by importance.

Far from the goal, cells divide the first coordinates. Near it they divide everything that the goal
constrains, rates included, and halve in width with half the distance, so that progress into the
goal always reaches new cells. A cell is more important the nearer it is to the goal, the fewer
states it holds and the less often it was selected; past success counts too.

Source: Sucan, Kavraki, Kinodynamic motion planning by interior-exterior cell exploration, WAFR
2008.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array, Integers, allocate
from kinolab.numerics.jit import kernel
from kinolab.numerics.rng import uniform
from kinolab.problem import PlanningTask
from kinolab.problem.goal_kernel import normalized_error
from kinolab.problem.metric import CELLS_AROUND_GOAL, projected_coordinates
from kinolab.search.tree.problem_arrays import ProblemArrays

NONE = -1  # instead of a node
EMPTY = 0  # instead of a cell's number in the table, which counts from 1
FEW = 32  # slots for each cell, from which on cells are removed from the table one by one
BLOCK = 64  # cells per block, whose most important cell is cached
GOOD, BAD = 0.9, 0.45  # factors on a cell's score after success and failure
FIRST, NEXT = -3750763034362895579, 1099511628211  # FNV-1a, 64 bits


class KpieceGrid(NamedTuple):
    """Cells of nodes in a hash table, for compiled kernels."""

    entry: Annotated[Integers, "k"]  # divided entries of the state
    lower: Annotated[Array, "k"]
    per_unit: Annotated[Array, "k"]  # cells per unit
    around: Annotated[Array, "k"]  # period in cells; infinite on a line
    goal_region_scale: float  # what counts as near the goal, in its tolerances
    across: float  # cells across the goal's tolerances, at the finest level
    table: Annotated[NDArray[np.int32], "slots"]  # numbers of cells by the hash of their key
    key: Annotated[Integers, "capacity"]  # of cells
    newest: Annotated[NDArray[np.int32], "capacity"]  # newest node of a cell
    held: Annotated[NDArray[np.int32], "capacity"]  # number of nodes of a cell
    chosen: Annotated[NDArray[np.int32], "capacity"]  # number of selections of a cell
    score: Annotated[Array, "capacity"]  # of cells
    importance: Annotated[Array, "padded"]  # of cells, and 0 beyond them
    best: Annotated[NDArray[np.int32], "blocks"]  # the most important cell of a block
    older: Annotated[NDArray[np.int32], "capacity"]  # by node: the next older one in its cell
    size: Annotated[Integers, 1]  # number of cells


def kpiece_grid(
    problem: PlanningTask,
    arrays: ProblemArrays,
    capacity: int,
    goal_region_scale: float,
    across: int,
) -> KpieceGrid:
    """Allocate an empty grid.

    Args:
        arrays: The same problem as arrays.
        capacity: Maximum number of nodes and cells.
        goal_region_scale: What counts as near the goal, in its tolerances.
        across: Number of cells along each divided coordinate.
    """
    entries = projected_coordinates(problem)
    lower, upper = problem.sampling_bounds[entries].T
    named = len(arrays.goal.entry)
    places = 1 << max(4, (2 * capacity).bit_length())
    return allocate(
        KpieceGrid,
        {
            "capacity": capacity,
            "slots": places,
            "padded": capacity + BLOCK,
            "blocks": capacity // BLOCK + 1,
        },
        entry=np.array(entries, dtype=np.int64),
        lower=np.ascontiguousarray(lower),
        per_unit=across / (upper - lower),
        around=np.where(problem.circular[entries], float(across), np.inf),
        goal_region_scale=float(goal_region_scale) if named else 0.0,
        across=float(max(2, round(CELLS_AROUND_GOAL ** (1 / max(1, named))))),
    )


@kernel
def clear_cells(cells):  # type: ignore[no-untyped-def]
    """Remove all cells: the table as a whole, or only what few of them take."""
    last, size = cells.table.shape[0] - 1, cells.size[0]
    if FEW * size > last:
        cells.table[:] = EMPTY
    else:
        for cell in range(size):
            place = first_place(cells.key[cell], last)
            while cells.table[place] != cell + 1:
                place = (place + 1) & last
            cells.table[place] = EMPTY
    cells.importance[:size] = 0.0
    cells.size[0] = 0


@kernel
def key_of(cells, goal, x, steps):  # type: ignore[no-untyped-def]
    """Return the hash key of the cell of a state (nx,) with a cost to go of ``steps``.

    Among many millions of cells a few may collide.
    """
    farthest = 0.0
    for k in range(goal.entry.shape[0]):
        farthest = max(farthest, abs(normalized_error(goal, k, x)))
    key = FIRST
    # cost to go below which a state is near, so not behind a wall
    if farthest >= cells.goal_region_scale or steps > 2.0:
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
def first_place(key, last):  # type: ignore[no-untyped-def]
    """Return the slot where the search for a key begins, up to the ``last`` one."""
    return (key ^ (key >> 29)) & last


@kernel
def place_of(cells, key):  # type: ignore[no-untyped-def]
    """Return the slot of a key in the table, or where it would be inserted."""
    last = cells.table.shape[0] - 1
    place = first_place(key, last)
    while cells.table[place] != EMPTY and cells.key[cells.table[place] - 1] != key:
        place = (place + 1) & last
    return place


@kernel
def holds(cells, key):  # type: ignore[no-untyped-def]
    """Return the number of nodes in a cell."""
    number = cells.table[place_of(cells, key)]
    return 0 if number == EMPTY else cells.held[number - 1]


@kernel
def put(cells, key, node, score):  # type: ignore[no-untyped-def]
    """Insert a node into a cell; a new cell gets the score."""
    place = place_of(cells, key)
    cell = cells.table[place] - 1
    if cell == EMPTY - 1:
        cell = cells.size[0]
        cells.size[0] += 1
        cells.table[place], cells.key[cell] = cell + 1, key
        cells.newest[cell], cells.held[cell], cells.chosen[cell] = NONE, 0, 0
        cells.score[cell] = score
    cells.older[node], cells.newest[cell] = cells.newest[cell], node
    cells.held[cell] += 1
    weigh(cells, cell)


@kernel
def weigh(cells, cell):  # type: ignore[no-untyped-def]
    """Update the importance of a cell."""
    cells.importance[cell] = cells.score[cell] / ((1.0 + cells.chosen[cell]) * cells.held[cell])
    first = cell // BLOCK * BLOCK
    best = first
    for k in range(first, first + BLOCK):
        if cells.importance[k] > cells.importance[best]:
            best = k
    cells.best[cell // BLOCK] = best


@kernel
def choose(cells, random):  # type: ignore[no-untyped-def]
    """Select the most important cell and one of its nodes, preferring newer ones."""
    found, most = 0, -1.0
    for block in range((cells.size[0] + BLOCK - 1) // BLOCK):
        cell = cells.best[block]
        if cells.importance[cell] > most:
            found, most = cell, cells.importance[cell]
    cells.chosen[found] += 1
    node = cells.newest[found]
    # probability of passing on from a state of a cell to the next older one
    while cells.older[node] != NONE and uniform(random) < 0.3:
        node = cells.older[node]
    return found, np.int64(node)


@kernel
def rate(cells, cell, good):  # type: ignore[no-untyped-def]
    """Lower the score of a cell after an extension from it."""
    cells.score[cell] *= GOOD if good else BAD
    weigh(cells, cell)
