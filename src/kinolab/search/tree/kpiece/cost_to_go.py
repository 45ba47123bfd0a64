"""Cost-to-go grid: approximate distance to the goal around obstacles, over cells of positions.

A cell counts as free if one of a few random states in it is. Paths over free cells ignore the
dynamics, but guide better than the straight line.

Source: Plaku, Kavraki, Vardi, Motion planning with dynamics by a synergistic combination of layers
of planning, IEEE Transactions on Robotics 26(3), 2010.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.problem import PlanningTask
from kinolab.problem.metric import projected_coordinates
from kinolab.search.tree.problem_arrays import sample_uniform
from kinolab.simulation.collision_context import clearance_bound, place_machine

MAX_CELLS_PER_AXIS = 48  # along one entry
UNREACHED = -1.0  # marks a blocked cell, in place of steps
COASTING_CELLS = 6.0  # that a motion is followed straight on at most


class CostToGoGrid(NamedTuple):
    """Grid over some entries of the state, for compiled kernels."""

    entry: Integers  # (k,) divided entries of the state
    lower: Array  # (k,)
    per_unit: Array  # (k,) cells per unit
    circular: NDArray[np.bool_]  # (3,) whether an axis is periodic
    along: Integers  # (3,) cells along each axis, 1 for unused axes
    steps: Array  # (cells,) cost to go in cells; infinite if not reached
    queue: NDArray[np.int32]  # (cells,) scratch
    poses: Array  # (bodies, 12) scratch: of the state placed last
    ends: Array  # (cables, 6)


def cost_to_go_grid(problem: PlanningTask) -> CostToGoGrid:
    """Allocate the grid, with costs not yet computed."""
    entries = projected_coordinates(problem, angles=False)
    lower, upper = problem.sampling_bounds[entries].T
    span = (upper - lower) * np.maximum(problem.weights[entries], 1e-9)
    most = 4096  # cells of the grid
    edge = (span.prod() / most) ** (1 / len(span))
    count = np.ones(3, np.int64)
    count[: len(span)] = np.clip(np.floor(span / edge), 1, MAX_CELLS_PER_AXIS)
    while count.prod() > most:
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
        poses=np.zeros((len(problem.bodies), 12)),
        ends=np.zeros((len(problem.cables), 6)),
    )


@kernel
def cell_at(grid, x):  # type: ignore[no-untyped-def]
    """Return the cell of a state, shape (nx,)."""
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
def coasting_cost(grid, before, x, steps, ahead):  # type: ignore[no-untyped-def]
    """Return the cost to go of where a motion arrives if it goes straight on.

    A fast machine is bound to go on for a while: what counts is where that leads.

    Args:
        grid: ``CostToGoGrid``.
        before, x: The states (nx,) before and after its last step.
        steps: For how many more steps it goes on.
        ahead: Scratch (nx,).
    """
    for k in range(grid.entry.shape[0]):
        i = grid.entry[k]
        cells = abs(x[i] - before[i]) * grid.per_unit[k]
        if cells * steps > COASTING_CELLS:
            steps = COASTING_CELLS / cells
    for k in range(grid.entry.shape[0]):
        i = grid.entry[k]
        ahead[i] = x[i] + steps * (x[i] - before[i])
    # steps by which the place it leads to counts more than where it is at most
    return min(grid.steps[cell_at(grid, ahead)], grid.steps[cell_at(grid, x)] + 3.0)


@kernel
def compute_cost_to_go(search, grid, x):  # type: ignore[no-untyped-def]
    """Compute the cost to go of every cell; ``x`` (nx,) is scratch."""
    steps, context, scratch = grid.steps, search.collision, search.scratch
    for cell in range(steps.shape[0]):
        steps[cell], places = UNREACHED, places_of(grid, cell)
        for sample in range(3):  # states checked per cell
            sample_uniform(search.problem, search.random, x)
            # At its centre: elsewhere in them, two adjacent cells could be free on opposite sides
            # of a wall one cell thick.
            for k in range(grid.entry.shape[0]):
                x[grid.entry[k]] = grid.lower[k] + (places[k] + 0.5) / grid.per_unit[k]
            place_machine(search.machine, x, scratch)
            # What no pose depends on, such as a velocity, does not make a blocked place free.
            moved = moved_from(grid.poses, scratch.poses) | moved_from(grid.ends, scratch.ends)
            if (moved or sample == 0) and (
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
def moved_from(before, now):  # type: ignore[no-untyped-def]
    """Say whether poses or ends (n, m) differ from those before, which they replace."""
    moved = False
    for i in range(now.shape[0]):
        for j in range(now.shape[1]):
            moved |= before[i, j] != now[i, j]
            before[i, j] = now[i, j]
    return moved


@kernel
def places_of(grid, cell):  # type: ignore[no-untyped-def]
    """Return the three grid coordinates of a cell."""
    along = grid.along
    return cell // (along[1] * along[2]), cell // along[2] % along[1], cell % along[2]


@kernel
def cell_of(grid, i, j, k):  # type: ignore[no-untyped-def]
    """Return the cell at grid coordinates, -1 if outside."""
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
    """Compute the cost to go by a flood fill from the goal's cells, diagonals included.

    If free cells do not reach the start, a passage is narrower than a cell: then cross blocked ones
    as well, at a higher cost.
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
        spread(grid, last, 10.0, UNREACHED)  # steps to cross a blocked cell


@kernel
def spread(grid, last, cost, through):  # type: ignore[no-untyped-def]
    """Propagate costs from the queued cells to their neighbours; return the queue's new length.

    Args:
        grid: The grid; its queue holds the visited cells in order.
        last: Length of the queue.
        cost: Cost of crossing a cell.
        through: Mark of cells that may be crossed besides unvisited free ones.
    """
    steps, queue, first, along = grid.steps, grid.queue, 0, grid.along
    a_side, b_side, c_side = min(along[0] - 1, 1), min(along[1] - 1, 1), min(along[2] - 1, 1)
    while first < last:
        cell = np.int64(queue[first])
        first += 1
        i, j, k = places_of(grid, cell)
        for a in range(-a_side, a_side + 1):
            for b in range(-b_side, b_side + 1):
                for c in range(-c_side, c_side + 1):
                    other = cell_of(grid, i + a, j + b, k + c)
                    if other >= 0 and (steps[other] == math.inf or steps[other] == through):
                        steps[other], queue[last] = steps[cell] + cost, other
                        last += 1
    return last
