"""Witnesses: points that are spread evenly, each with the cheapest node that was found around it.

No two are nearer than the pruning radius. Only the node of a witness, its representative, is grown
from, so that a tree stays sparse however long it grows. Nodes that no representative descends from
are of no use; they are forgotten when there is no room left, all at once.

Source: Li, Littlefield, Bekris, Asymptotically optimal sampling-based kinodynamic planning, IJRR
35(5), 2016.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.jit import kernel
from kinolab.numerics.kd_forest import (
    Integers,
    KdForest,
    add,
    cheapest_within,
    clear,
    kd_forest,
    nearest,
)
from kinolab.search.tree.problem_arrays import ProblemArrays, metric_coordinates, metric_periods

NOBODY = -1
USELESS, OF_USE = -1, -2  # nodes, before those of use get new numbers
MAX_FILL = 0.875  # share of a tree that is too much to go on with
EXACT = np.float32(1.0)
NEAREST_SLACK = 1.1  # by how much ``nearest`` may be off


class Witnesses(NamedTuple):
    """Points and their representatives, for compiled code; a tree's start is the first."""

    forest: KdForest  # of witnesses
    node: NDArray[np.int32]  # (capacity,) representatives, by witness
    cost: Integers  # (capacity,) of representatives, in steps
    place: NDArray[np.int32]  # (capacity,) scratch: where nodes go


def witnesses(arrays: ProblemArrays, capacity: int) -> Witnesses:
    """Return no witnesses, with room for those of so many nodes."""
    return Witnesses(
        forest=kd_forest(capacity, metric_periods(arrays)),
        node=np.zeros(capacity, np.int32),
        cost=np.zeros(capacity, np.int64),
        place=np.zeros(capacity, np.int32),
    )


@kernel
def witness_at(witnesses, point, radius):  # type: ignore[no-untyped-def]
    """Return the nearest witness within a radius of a point, NOBODY where there is none."""
    return nearest(witnesses.forest, point, NOBODY, radius * radius, EXACT)[0]


@kernel
def represent(witnesses, witness, node, cost, point):  # type: ignore[no-untyped-def]
    """Let a node represent a witness; for NOBODY it becomes a witness itself, at its point.

    Args:
        witnesses: ``Witnesses``.
        witness: Its number, or NOBODY.
        node, cost: The node, and the steps that lead to it.
        point: In coordinates of the metric, shape (d,).
    """
    if witness == NOBODY:
        witness = witnesses.forest.counts[0]
        add(witnesses.forest, point)
    witnesses.node[witness], witnesses.cost[witness] = node, cost


@kernel
def select(witnesses, point, radius):  # type: ignore[no-untyped-def]
    """Return the node to grow from: the cheapest around a point, else the nearest.

    A node is where its witness is, to the pruning radius.
    """
    found, square = nearest(witnesses.forest, point, NOBODY, math.inf)
    if square <= (NEAREST_SLACK * radius) ** 2:
        around = cheapest_within(witnesses.forest, witnesses.cost, point, radius * radius)
        found = found if around == NOBODY else around
    return witnesses.node[found]


@kernel
def begin_witnesses(search, tree, witnesses):  # type: ignore[no-untyped-def]
    """Leave no witness but the start, which is node 0."""
    clear(witnesses.forest)
    metric_coordinates(search.problem, search.problem.start, tree.point)
    represent(witnesses, NOBODY, 0, 0, tree.point)


@kernel
def sweep(tree, witnesses, best, most):  # type: ignore[no-untyped-def]
    """Forget witnesses from which no motion of fewer steps can come, and nodes of no use.

    Args:
        tree: Its nodes get new numbers.
        witnesses: Their nodes, too.
        best: Its first entry is a node that is kept; it gets its new number.
        most: Steps that a motion must fall below.

    Returns:
        Whether there is room to go on.
    """
    place, points = witnesses.place, witnesses.forest.points
    size, count = tree.size[0], witnesses.forest.counts[0]
    place[:size] = USELESS
    place[0] = place[int(best[0])] = OF_USE
    clear(witnesses.forest)
    for witness in range(count):
        node, cost = witnesses.node[witness], witnesses.cost[witness]
        if cost + 1 < most:
            place[node] = OF_USE
            represent(witnesses, NOBODY, node, cost, points[witness])
    for node in range(size - 1, 0, -1):  # parents have smaller numbers
        if place[node] == OF_USE:
            place[tree.parent[node]] = OF_USE
    pack(tree, place)
    for witness in range(witnesses.forest.counts[0]):
        witnesses.node[witness] = place[witnesses.node[witness]]
    best[0] = place[int(best[0])]
    return tree.size[0] <= MAX_FILL * tree.x.shape[0]


@kernel
def pack(tree, place):  # type: ignore[no-untyped-def]
    """Move a tree's nodes of use to its front, and write where each of them is now."""
    size = 0
    for node in range(tree.size[0]):
        if place[node] == USELESS:
            continue
        place[node] = size
        for i in range(tree.x.shape[1]):
            tree.x[size, i] = tree.x[node, i]
        for i in range(tree.u.shape[1]):
            tree.u[size, i] = tree.u[node, i]
        tree.parent[size] = place[tree.parent[node]] if node > 0 else -1
        tree.steps[size], tree.cost[size] = tree.steps[node], tree.cost[node]
        tree.clearance[size], tree.failures[size] = tree.clearance[node], tree.failures[node]
        size += 1
    tree.size[0] = size
