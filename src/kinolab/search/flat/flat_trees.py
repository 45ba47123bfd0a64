"""Two trees of straight lines between states of rest, which grow toward each other.

Source: Kuffner, LaValle, RRT-Connect: an efficient approach to single-query path planning, ICRA
2000.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.insertion import add
from kinolab.numerics.neighbours.queries import nearest
from kinolab.numerics.neighbours.r_tree import RTree, clear
from kinolab.numerics.rng import uniform
from kinolab.problem.goal_kernel import wrapped_angle
from kinolab.search.flat.car_routes import aim_ahead, walk_word
from kinolab.search.flat.flat_machine import CAR, PLANE
from kinolab.search.flat.flat_pieces import BACK, MOVE, TURN, put_stretch
from kinolab.search.flat.piece_sweeps import free_until, is_state_free
from kinolab.search.tree.flat_arrays import copy

NONE = -1
GROWING, LINKED, FILLED = 0, 1, 2
TRAPPED = 0.01  # of an extension: shorter ones are none
RETREATS = 5  # parts of an extension that was stopped: it ends before the last of them


class FlatTree(NamedTuple):
    """States of rest, by their flat outputs, and the one that each was reached from."""

    z: Annotated[Array, "capacity", "outputs"]
    parent: Annotated[Integers, "capacity"]
    size: Annotated[Integers, 1]
    neighbours: RTree


@kernel
def begin_trees(search):  # type: ignore[no-untyped-def]
    """Clear both trees to the start, and to all places in the goal."""
    search.turn[0] = 0
    for tree in (search.ahead, search.behind):
        tree.size[0] = 0
        clear(tree.neighbours)
    for i in range(search.work.z.shape[0]):
        search.work.z[i] = search.start[i]
    insert(search, search.ahead, search.work.z, NONE)
    for k in range(search.goals.shape[0]):
        insert(search, search.behind, search.goals[k], NONE)


@kernel
def insert(search, tree, z, parent):  # type: ignore[no-untyped-def]
    """Add a node at outputs z (outputs,); return its number."""
    node, outputs = tree.size[0], tree.z.shape[1]
    for i in range(outputs):
        value = z[i]
        tree.z[node, i] = value
        if search.flat.period[i] < math.inf:
            value = wrapped_angle(value)
        search.work.point[i] = search.flat.weight[i] * value
    tree.parent[node] = parent
    add(tree.neighbours, search.work.point)
    tree.size[0] += 1
    return node


@kernel
def nearest_node(search, tree, z):  # type: ignore[no-untyped-def]
    """Return the node nearest to outputs z (outputs,)."""
    for i in range(tree.z.shape[1]):
        value = z[i]
        if search.flat.period[i] < math.inf:
            value = wrapped_angle(value)
        search.work.point[i] = search.flat.weight[i] * value
    found, _ = nearest(tree.neighbours, search.work.point, 0, math.inf)
    return found


@kernel
def gap(search, begin, end, i):  # type: ignore[no-untyped-def]
    """Return the i-th output's way between two of outputs, the shorter one where it is periodic."""
    away = end[i] - begin[i]
    return wrapped_angle(away) if search.flat.period[i] < math.inf else away


@kernel
def grow_trees(search, iterations):  # type: ignore[no-untyped-def]
    """Grow both trees in turns; return how that ended, and the number of iterations made.

    The first of them goes from the start straight to the goal. When they are LINKED, ``links`` has
    a node of each.
    """
    for k in range(iterations):
        if max(search.ahead.size[0], search.behind.size[0]) + 2 > search.ahead.parent.shape[0]:
            return FILLED, k
        turn = search.turn[0]
        search.turn[0] += 1
        if turn == 0:
            linked = link(search, search.behind, search.ahead, 0, False)
        elif turn % 2 == 1:
            linked = grow_once(search, search.ahead, search.behind, True)
        else:
            linked = grow_once(search, search.behind, search.ahead, False)
        if linked:
            return LINKED, k + 1
    return GROWING, iterations


@kernel
def grow_once(search, tree, other, forward):  # type: ignore[no-untyped-def]
    """Extend a tree toward a sample, and the other one as far as it gets toward there."""
    sample = search.work.sample
    for i in range(sample.shape[0]):
        low, high = search.flat.lower[i], search.flat.upper[i]
        sample[i] = low + uniform(search.random) * (high - low)
    near = nearest_node(search, tree, sample)
    if search.flat.kind == CAR and uniform(search.random) < 0.5:
        aim_ahead(search, tree.z[near], sample, forward)
    node, _ = extend_toward(search, tree, near, sample, forward)
    return node != NONE and link(search, tree, other, node, forward)


@kernel
def link(search, tree, other, node, forward):  # type: ignore[no-untyped-def]
    """Extend the other tree toward a node of one until it is there; say whether that is so.

    Args:
        search: ``FlatSearch``; its ``links`` are written.
        tree, other: The one and the other.
        node: Of the one.
        forward: Whether that is the tree from the start.
    """
    aim = tree.z[node]
    at = nearest_node(search, other, aim)
    while other.size[0] + 1 < other.parent.shape[0]:
        at, arrived = extend_toward(search, other, at, aim, not forward)
        if at == NONE:
            return False
        if arrived:
            search.links[0], search.links[1] = (node, at) if forward else (at, node)
            return True
    return False


@kernel
def extend_toward(search, tree, node, aim, forward):  # type: ignore[no-untyped-def]
    """Extend a tree from a node toward outputs; return the new node, or NONE, and whether it is it.

    Args:
        search, tree: ``FlatSearch`` and ``FlatTree``.
        node: From which.
        aim: Outputs, shape (outputs,).
        forward: Whether motions go away from the tree's root, and not toward it.
    """
    if search.flat.kind == CAR:
        pose = search.work.z[:3]
        copy(tree.z[node], pose)
        gone, arrived = walk_word(search, pose, aim, forward, search.reach)
        if not gone > TRAPPED * search.reach and not arrived:
            return NONE, False
        return insert(search, tree, pose, node), arrived
    z, way, outputs, length = search.work.z, search.work.direction, tree.z.shape[1], 0.0
    for i in range(z.shape[0]):
        z[i], way[i] = 0.0, 0.0
    for i in range(outputs):
        z[i], way[i] = tree.z[node, i], gap(search, tree.z[node], aim, i)
        length += (search.flat.weight[i] * way[i]) ** 2
    length = math.sqrt(length)
    whole = length <= search.reach
    T = 1.0 if whole else search.reach / length
    put_stretch(search.trial, 0, MOVE if forward else BACK, z, way, 0.0, 1.0, 0.0, T)
    free = free_until(search, search.trial, 0)
    if not free > TRAPPED * T:
        return NONE, whole and free >= T
    arrived = whole and free >= T
    if arrived:
        for i in range(outputs):
            z[i] = tree.z[node, i] + way[i]
        return insert(search, tree, z, node), True
    for k in range(1, RETREATS):
        share = free * (RETREATS - k) / RETREATS
        for i in range(outputs):
            z[i] = tree.z[node, i] + share * way[i]
        if seems_to_turn(search, z, way):
            return insert(search, tree, z, node), False
    return NONE, False


@kernel
def seems_to_turn(search, z, way):  # type: ignore[no-untyped-def]
    """Say whether a machine that drives along curves may turn on the spot, by both its broadsides.

    Args:
        search: ``FlatSearch``.
        z: Where it is, shape (axes,).
        way: Along which it has come, shape (axes,).
    """
    if search.flat.kind != PLANE:
        return True
    around = search.work.around
    around[0], around[1], around[2] = 0.0, 0.0, 1.0
    z[2] = math.atan2(way[1], way[0])
    put_stretch(search.trial, 0, TURN, z, around, 0.0, 1.0, 0.0, 2.0 * math.pi)
    z[2] = 0.0
    quarter = 0.5 * math.pi
    return is_state_free(search, search.trial, 0, quarter) and is_state_free(
        search, search.trial, 0, 3.0 * quarter
    )
