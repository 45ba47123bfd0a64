"""How far it is to the goal around obstacles, roughly: over cells of where a machine is.

A cell counts as free where one of a few random states in it is. The way from cell to free cell says
little about what the dynamics allow, and more than the straight line does.

Source: Plaku, Kavraki, Vardi, Motion planning with dynamics by a synergistic combination of layers
of planning, IEEE Transactions on Robotics 26(3), 2010.
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
from kinolab.problem import PlanningTask
from kinolab.problem.metric import projected_coordinates
from kinolab.search.tree.problem_arrays import sample_uniform
from kinolab.simulation.collision_context import clearance_bound, place_machine

MAX_CELLS = 4096  # at most, and ...
MAX_CELLS_PER_AXIS = 48  # of one entry
SAMPLES_PER_CELL = 3  # states of a cell that are looked at
UNREACHED = -1.0  # instead of steps
BLOCKED_COST = 10.0  # steps, for a cell that looked blocked


class CostToGoGrid(NamedTuple):
    """Cells over some entries of the state, for compiled code."""

    entry: Integers  # (k,) entries of the state that are divided
    lower: Array  # (k,)
    per_unit: Array  # (k,) cells per unit
    circular: NDArray[np.bool_]  # (3,) whether the last cell along an entry is next to the first
    along: Integers  # (3,) cells along each, 1 where there are fewer entries
    steps: Array  # (cells,) to the goal; infinite where there is no way
    queue: NDArray[np.int32]  # (cells,) scratch


def cost_to_go_grid(problem: PlanningTask) -> CostToGoGrid:
    """Return cells that know no way yet."""
    entries = projected_coordinates(problem, angles=False)
    lower, upper = problem.sampling_bounds[entries].T
    span = (upper - lower) * np.maximum(problem.weights[entries], 1e-9)
    edge = (span.prod() / MAX_CELLS) ** (1 / len(span))
    count = np.ones(3, np.int64)
    count[: len(span)] = np.clip(np.floor(span / edge), 1, MAX_CELLS_PER_AXIS)
    while count.prod() > MAX_CELLS:
        count[count.argmax()] -= 1
    circular = np.zeros(3, dtype=bool)
    circular[: len(span)] = problem.circular[entries]
    return CostToGoGrid(
        entry=np.array(entries, dtype=np.int64),
        lower=np.ascontiguousarray(lower),
        per_unit=count[: len(span)] / (upper - lower),
        circular=circular,
        along=count,
        steps=np.full(int(count.prod()), math.inf),
        queue=np.zeros(int(count.prod()), np.int32),
    )


@kernel
def cell_at(grid, x):  # type: ignore[no-untyped-def]
    """Return the cell of a state."""
    cell = 0
    for k in range(3):
        place = 0
        if k < grid.entry.shape[0]:
            at, most = (x[grid.entry[k]] - grid.lower[k]) * grid.per_unit[k], grid.along[k]
            if grid.circular[k]:
                at -= most * math.floor(at / most)
            place = int(min(max(at, 0.0), most - 1.0))
        cell = cell * grid.along[k] + place
    return cell


@kernel
def compute_cost_to_go(search, grid, x):  # type: ignore[no-untyped-def]
    """Work out how many steps each cell is from the goal; ``x`` (nx,) is scratch."""
    steps, context, scratch = grid.steps, search.collision, search.scratch
    for cell in range(steps.shape[0]):
        steps[cell] = UNREACHED
        for _ in range(SAMPLES_PER_CELL):
            draw_in_cell(grid, search.problem, search.random, cell, x)
            place_machine(search.machine, x, scratch)
            if (
                clearance_bound(0.0, context.required_clearance, scratch, context)
                >= context.required_clearance
            ):
                steps[cell] = math.inf
                break
    flood(grid, search.problem)
    for cell in range(steps.shape[0]):
        if steps[cell] == UNREACHED or steps[cell] == math.inf:
            steps[cell] = steps.shape[0]


@kernel
def draw_in_cell(grid, arrays, random, cell, x):  # type: ignore[no-untyped-def]
    """Draw a state in the middle of a cell.

    Elsewhere in it, two neighbours could be free on either side of a wall that is as thick as one.

    Args:
        grid, arrays: ``CostToGoGrid`` and ``ProblemArrays``.
        random: State of the generator.
        cell: Its number.
        x: The state, shape (nx,); written.
    """
    sample_uniform(arrays, random, x)
    places = places_of(grid, cell)
    for k in range(grid.entry.shape[0]):
        x[grid.entry[k]] = grid.lower[k] + (places[k] + 0.5) / grid.per_unit[k]


@kernel
def places_of(grid, cell):  # type: ignore[no-untyped-def]
    """Return where a cell is along each entry."""
    along = grid.along
    return cell // (along[1] * along[2]), cell // along[2] % along[1], cell % along[2]


@kernel
def cell_of(grid, i, j, k):  # type: ignore[no-untyped-def]
    """Return the cell that is so far along each entry, -1 where there is none."""
    cell = 0
    for axis, place in enumerate((i, j, k)):
        most = grid.along[axis]
        if grid.circular[axis]:
            place = (place + most) % most  # noqa: PLW2901
        if not 0 <= place < most:
            return -1
        cell = cell * most + place
    return cell


@kernel
def flood(grid, arrays):  # type: ignore[no-untyped-def]
    """Count the steps from the cells of the goal through free cells, corners included.

    Where these do not lead to the start, a gap is narrower than a cell: then through others, too.
    """
    steps, queue, last = grid.steps, grid.queue, np.int64(0)
    for k in range(arrays.goal_states.shape[0]):
        cell = cell_at(grid, arrays.goal_states[k])
        if steps[cell] != 0.0:
            steps[cell], queue[last] = 0.0, cell
            last += 1
    last = spread(grid, last, 1.0, math.inf)
    start = steps[cell_at(grid, arrays.start)]
    if start == UNREACHED or start == math.inf:  # noqa: PLR1714  compiled: no container
        spread(grid, last, BLOCKED_COST, UNREACHED)


@kernel
def spread(grid, last, cost, through):  # type: ignore[no-untyped-def]
    """Count on from cells in the queue to all their neighbours; return how many it holds then.

    Args:
        grid: Its queue holds the cells that were counted, in order.
        last: How many.
        cost: Of a cell.
        through: What may be crossed besides free cells that were not counted yet.
    """
    steps, queue, first = grid.steps, grid.queue, 0
    while first < last:
        cell = np.int64(queue[first])
        first += 1
        i, j, k = places_of(grid, cell)
        for a in range(-1, 2):
            for b in range(-1, 2):
                for c in range(-1, 2):
                    other = cell_of(grid, i + a, j + b, k + c)
                    if other >= 0 and (steps[other] == math.inf or steps[other] == through):
                        steps[other], queue[last] = steps[cell] + cost, other
                        last += 1
    return last
