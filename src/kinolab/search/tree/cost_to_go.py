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

from kinolab.numerics.jit import kernel
from kinolab.numerics.kd_forest import Array, Integers
from kinolab.problem import Problem
from kinolab.problem.metric import projected
from kinolab.search.tree.problem_arrays import draw_anywhere
from kinolab.simulation.collision_context import place_at, room_at

CELLS = 4096  # at most, and ...
ALONG = 48  # of one entry
TRIES = 3  # states of a cell that are looked at
BLOCKED = -1.0  # instead of steps
CROSSING = 10.0  # steps, for a cell that looked blocked


class Leads(NamedTuple):
    """Cells over some entries of the state, for compiled code."""

    entry: Integers  # (k,) entries of the state that are divided
    lower: Array  # (k,)
    per_unit: Array  # (k,) cells per unit
    circular: NDArray[np.bool_]  # (3,) whether the last cell along an entry is next to the first
    along: Integers  # (3,) cells along each, 1 where there are fewer entries
    steps: Array  # (cells,) to the goal; infinite where there is no way
    queue: NDArray[np.int32]  # (cells,) scratch


def leads(problem: Problem) -> Leads:
    """Return cells that know no way yet."""
    entries = projected(problem, angles=False)
    lower, upper = problem.sampling_bounds[entries].T
    span = (upper - lower) * np.maximum(problem.weights[entries], 1e-9)
    edge = (span.prod() / CELLS) ** (1 / len(span))
    count = np.ones(3, np.int64)
    count[: len(span)] = np.clip(np.floor(span / edge), 1, ALONG)
    while count.prod() > CELLS:
        count[count.argmax()] -= 1
    circular = np.zeros(3, dtype=bool)
    circular[: len(span)] = problem.circular[entries]
    return Leads(
        entry=np.array(entries, dtype=np.int64),
        lower=np.ascontiguousarray(lower),
        per_unit=count[: len(span)] / (upper - lower),
        circular=circular,
        along=count,
        steps=np.full(int(count.prod()), math.inf),
        queue=np.zeros(int(count.prod()), np.int32),
    )


@kernel
def cell_at(leads, x):  # type: ignore[no-untyped-def]
    """Return the cell of a state."""
    cell = 0
    for k in range(3):
        place = 0
        if k < leads.entry.shape[0]:
            at, most = (x[leads.entry[k]] - leads.lower[k]) * leads.per_unit[k], leads.along[k]
            if leads.circular[k]:
                at -= most * math.floor(at / most)
            place = int(min(max(at, 0.0), most - 1.0))
        cell = cell * leads.along[k] + place
    return cell


@kernel
def find_ways(search, leads, x):  # type: ignore[no-untyped-def]
    """Work out how many steps each cell is from the goal; ``x`` (nx,) is scratch."""
    steps, ways, looks = leads.steps, search.ways, search.looks
    for cell in range(steps.shape[0]):
        steps[cell] = BLOCKED
        for _ in range(TRIES):
            draw_in_cell(leads, search.question, search.random, cell, x)
            place_at(search.machine, x, looks)
            if room_at(0.0, ways.tight, looks, ways) >= ways.tight:
                steps[cell] = math.inf
                break
    flood(leads, search.question)
    for cell in range(steps.shape[0]):
        if steps[cell] == BLOCKED or steps[cell] == math.inf:
            steps[cell] = steps.shape[0]


@kernel
def draw_in_cell(leads, question, random, cell, x):  # type: ignore[no-untyped-def]
    """Draw a state in the middle of a cell.

    Elsewhere in it, two neighbours could be free on either side of a wall that is as thick as one.
    """
    draw_anywhere(question, random, x)
    places = places_of(leads, cell)
    for k in range(leads.entry.shape[0]):
        x[leads.entry[k]] = leads.lower[k] + (places[k] + 0.5) / leads.per_unit[k]


@kernel
def places_of(leads, cell):  # type: ignore[no-untyped-def]
    """Return where a cell is along each entry."""
    along = leads.along
    return cell // (along[1] * along[2]), cell // along[2] % along[1], cell % along[2]


@kernel
def cell_of(leads, i, j, k):  # type: ignore[no-untyped-def]
    """Return the cell that is so far along each entry, -1 where there is none."""
    cell = 0
    for axis, place in enumerate((i, j, k)):
        most = leads.along[axis]
        if leads.circular[axis]:
            place = (place + most) % most  # noqa: PLW2901
        if not 0 <= place < most:
            return -1
        cell = cell * most + place
    return cell


@kernel
def flood(leads, question):  # type: ignore[no-untyped-def]
    """Count the steps from the cells of the goal through free cells, corners included.

    Where these do not lead to the start, a gap is narrower than a cell: then through others, too.
    """
    steps, queue, last = leads.steps, leads.queue, np.int64(0)
    for k in range(question.ends.shape[0]):
        cell = cell_at(leads, question.ends[k])
        if steps[cell] != 0.0:
            steps[cell], queue[last] = 0.0, cell
            last += 1
    last = spread(leads, last, 1.0, math.inf)
    start = steps[cell_at(leads, question.start)]
    if start == BLOCKED or start == math.inf:  # noqa: PLR1714  compiled: no container
        spread(leads, last, CROSSING, BLOCKED)


@kernel
def spread(leads, last, cost, through):  # type: ignore[no-untyped-def]
    """Count on from cells in the queue to all their neighbours; return how many it holds then.

    Args:
        leads: Its queue holds the cells that were counted, in order.
        last: How many.
        cost: Of a cell.
        through: What may be crossed besides free cells that were not counted yet.
    """
    steps, queue, first = leads.steps, leads.queue, 0
    while first < last:
        cell = np.int64(queue[first])
        first += 1
        i, j, k = places_of(leads, cell)
        for a in range(-1, 2):
            for b in range(-1, 2):
                for c in range(-1, 2):
                    other = cell_of(leads, i + a, j + b, k + c)
                    if other >= 0 and (steps[other] == math.inf or steps[other] == through):
                        steps[other], queue[last] = steps[cell] + cost, other
                        last += 1
    return last
