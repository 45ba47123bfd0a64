"""SST's witnesses: evenly spread points, each represented by the cheapest node found near it.

No two are nearer than the pruning radius. Only the representatives of witnesses are extended, which
keeps the tree sparse. Nodes that are no ancestors of representatives are useless; they are pruned
all at once when the capacity is used.

Source: Li, Littlefield, Bekris, Asymptotically optimal sampling-based kinodynamic planning, IJRR
35(5), 2016.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Integers, allocate
from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.insertion import add
from kinolab.numerics.neighbours.queries import cheapest_within, nearest
from kinolab.numerics.neighbours.r_tree import RTree, clear, r_tree
from kinolab.search.tree.flat_arrays import copy
from kinolab.search.tree.problem_arrays import ProblemArrays, metric_periods
from kinolab.search.tree.tree import NONE

NOBODY = -1
USELESS, OF_USE = -1, -2  # marks of nodes before renumbering
EXACT = np.float32(1.0)


class Witnesses(NamedTuple):
    """Witnesses and their representatives, for compiled kernels; a tree's start is the first."""

    neighbours: RTree  # of witnesses
    node: Annotated[NDArray[np.int32], "capacity"]  # representative of each witness
    cost: Annotated[Integers, "capacity"]  # of representatives, in steps
    place: Annotated[NDArray[np.int32], "capacity"]  # scratch: new indices of nodes


def witnesses(arrays: ProblemArrays, capacity: int) -> Witnesses:
    """Allocate an empty set of witnesses with a capacity in nodes."""
    neighbours = r_tree(capacity, metric_periods(arrays))
    return allocate(Witnesses, {"capacity": capacity}, neighbours=neighbours)


@kernel
def witness_at(witnesses, point, radius):  # type: ignore[no-untyped-def]
    """Return the nearest witness within a radius of a point (d,), NOBODY if there is none."""
    return nearest(witnesses.neighbours, point, NOBODY, radius * radius, EXACT)[0]


@kernel
def represent(witnesses, witness, node, cost, point):  # type: ignore[no-untyped-def]
    """Make a node the representative of a witness, or of a new one at its point for NOBODY.

    Args:
        witnesses: ``Witnesses``.
        witness: Its index, or NOBODY.
        node, cost: The node and its cost in steps.
        point: In coordinates of the metric, shape (d,).
    """
    if witness == NOBODY:
        witness = witnesses.neighbours.counts[0]
        add(witnesses.neighbours, point)
    witnesses.node[witness], witnesses.cost[witness] = node, cost


@kernel
def select(witnesses, point, radius):  # type: ignore[no-untyped-def]
    """Select the node to extend: the cheapest within a radius of a point (d,), else the nearest.

    A node is located at its witness, to within the pruning radius.
    """
    found, square = nearest(witnesses.neighbours, point, NOBODY, math.inf)
    if square <= (1.1 * radius) ** 2:  # error factor of the approximate ``nearest``
        around = cheapest_within(witnesses.neighbours, witnesses.cost, point, radius * radius)
        found = found if around == NOBODY else around
    return witnesses.node[found]


@kernel
def sweep(tree, witnesses, best, most):  # type: ignore[no-untyped-def]
    """Prune witnesses that cannot meet the cost bound, and useless nodes.

    Args:
        tree: Its nodes are renumbered; those that are being extended are kept.
        witnesses: Their representatives are renumbered.
        best: Its first entry is a node that is kept and renumbered.
        most: Cost bound: steps that a solution must stay below.

    Returns:
        Whether enough capacity is left to continue.
    """
    place, points = witnesses.place, witnesses.neighbours.points
    size, count = tree.size[0], witnesses.neighbours.counts[0]
    place[:size] = USELESS
    place[0] = place[int(best[0])] = OF_USE
    clear(witnesses.neighbours)
    for witness in range(count):
        node, cost = witnesses.node[witness], witnesses.cost[witness]
        if cost + 1 < most:
            place[node] = OF_USE
            represent(witnesses, NOBODY, node, cost, points[witness])
    extended = tree.extensions.parent
    for lane in range(extended.shape[0]):
        if extended[lane] != NONE:
            place[extended[lane]] = OF_USE
    for node in range(size - 1, 0, -1):  # parents have smaller numbers
        if place[node] == OF_USE:
            place[tree.parent[node]] = OF_USE
    pack(tree, place)
    for witness in range(witnesses.neighbours.counts[0]):
        witnesses.node[witness] = place[witnesses.node[witness]]
    for lane in range(extended.shape[0]):
        if extended[lane] != NONE:
            extended[lane] = place[extended[lane]]
    best[0] = place[int(best[0])]
    # fraction of the capacity after pruning beyond which the tree is full
    return tree.size[0] <= 0.875 * tree.x.shape[0]


@kernel
def pack(tree, place):  # type: ignore[no-untyped-def]
    """Compact a tree to its marked nodes, and write their new indices to ``place``."""
    size = 0
    for node in range(tree.size[0]):
        if place[node] == USELESS:
            continue
        place[node] = size
        copy(tree.x[node], tree.x[size])
        copy(tree.u[node], tree.u[size])
        tree.parent[size] = place[tree.parent[node]] if node > 0 else -1
        tree.steps[size], tree.cost[size] = tree.steps[node], tree.cost[node]
        tree.clearance[size], tree.failures[size] = tree.clearance[node], tree.failures[node]
        size += 1
    tree.size[0] = size
