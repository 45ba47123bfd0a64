"""Searches in an R-tree: nearest neighbours, and the cheapest point around.

Source: Roussopoulos, Kelley, Vincent, Nearest neighbor queries, SIGMOD 1995; for the slack, Arya,
Mount et al., Journal of the ACM 45(6), 1998.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.r_tree import HEIGHT, LEAF_SIZE, ROOT
from kinolab.numerics.simd import (
    BEFORE_ALL,
    FAR,
    LANES,
    NOTHING,
    bits_of,
    first_lane,
    lanes_at,
    lanes_below,
    lanes_up_to,
    least,
    load,
    maximum,
    minimum,
    next_key,
    ranked,
    spread,
    store,
)

# approximate search: no point is nearer by more than a tenth
RELATIVE_SLACK = np.float32(1.0 / 1.1**2)


@kernel
def nearest(tree, query, start, best, slack=RELATIVE_SLACK):  # type: ignore[no-untyped-def]
    """Return index and squared distance of an approximate nearest neighbour of a query (d,).

    No point is nearer by more than a tenth, unless ``slack`` says otherwise. Nearer boxes are
    searched first.

    Args:
        tree: With or without points.
        query: Scaled coordinates (d,).
        start: Index returned if no point is nearer than ``best``.
        best: A squared distance.
        slack: No point has less than this fraction of the squared distance found.
    """
    for i in range(query.shape[0]):
        tree.query[i] = query[i]
    found, square, height = np.int64(start), np.float32(best), tree.counts[HEIGHT]
    keys, last, path = tree.keys, tree.last, tree.path
    layer, group = height - 1, tree.counts[ROOT]
    while True:
        if layer == 0:
            found, square = look_below(tree, group, found, square, slack)
            layer = 1
        else:
            store(keys, (layer, 0), ranked(bounds(tree, group)))
            last[layer], path[layer] = BEFORE_ALL, group
        key, limit = 0, bits_of(square * slack)
        while layer < height:
            key = next_key(load(keys, (layer, 0)), last[layer])
            if key & -LANES < limit:
                break
            layer += 1
        if layer == height:
            return found, square
        last[layer] = key
        group = np.int64(tree.children[path[layer], key & (LANES - 1)])
        layer -= 1


@kernel
def look_below(tree, group, found, square, slack):  # type: ignore[no-untyped-def]
    """Search the leaves of a group; return the nearest so far, and its squared distance.

    Args:
        tree: Its ``query`` is set.
        group: Of the lowest layer.
        found, square: The nearest so far, and its squared distance.
        slack: As ``nearest`` takes it.
    """
    keys = ranked(bounds(tree, group))
    key = next_key(keys, BEFORE_ALL)
    while key & -LANES < bits_of(square * slack):
        leaf = np.int64(tree.children[group, key & (LANES - 1)])
        found, square = look(tree, leaf, found, square)
        key = next_key(keys, key)
    return found, square


@kernel
def look(tree, leaf, found, square):  # type: ignore[no-untyped-def]
    """Scan a leaf; return the nearest point so far, and its squared distance.

    Args:
        tree: Its ``query`` is set.
        leaf: The leaf.
        found, square: The nearest so far, and its squared distance.
    """
    for chunk in range(-(-tree.sizes[leaf] // LANES)):
        here = squares(tree, leaf, chunk)
        if lanes_below(here, square) != 0:
            square = least(here)
            lane = first_lane(lanes_at(here, square))
            found = np.int64(tree.names[leaf * LEAF_SIZE + chunk * LANES + lane])
    return found, square


@kernel
def squares(tree, leaf, chunk):  # type: ignore[no-untyped-def]
    """Return the squared distances of some points of a leaf from the query, infinite for none."""
    blocks, query, period, total = tree.blocks, tree.query, tree.period, spread(NOTHING)
    for i in range(query.shape[0]):
        gap = load(blocks, (leaf, chunk, i, 0)) - spread(query[i])
        if period[i] != FAR:
            gap = maximum(gap, spread(NOTHING) - gap)
            gap = minimum(gap, spread(period[i]) - gap)
        total += gap * gap
    return total


@kernel
def bounds(tree, group):  # type: ignore[no-untyped-def]
    """Return lower bounds on squared distances from the query to points below each child.

    Infinite where there is no child; not a number if the query is not: then none is searched.
    """
    boxes, query, period, total = tree.boxes, tree.query, tree.period, spread(NOTHING)
    nothing = spread(NOTHING)
    for i in range(query.shape[0]):
        value = spread(query[i])
        under = load(boxes, (group, 0, i, 0)) - value
        over = value - load(boxes, (group, 1, i, 0))
        gap = maximum(nothing, maximum(under, over))
        if period[i] != FAR:  # the other end may be nearer across the period
            gap = minimum(gap, maximum(nothing, spread(period[i]) + minimum(under, over)))
        total += gap * gap
    return total


@kernel
def cheapest_within(tree, costs, query, square):  # type: ignore[no-untyped-def]
    """Return the index of the cheapest point within a radius of a query, -1 if there is none.

    Ties are broken arbitrarily.

    Args:
        tree: Of points.
        costs: Cost of each point, by index.
        query: Scaled coordinates (d,).
        square: Squared radius.
    """
    for i in range(query.shape[0]):
        tree.query[i] = query[i]
    found, within, height = np.int64(-1), np.float32(square), tree.counts[HEIGHT]
    pending, path = tree.last, tree.path  # of the layer above, a bit for each child to search
    layer, at = height, tree.counts[ROOT]
    while True:
        if layer == 0:
            found = look_for_cheaper(tree, at, costs, found, within)
            layer = 1
        else:
            pending[layer], path[layer] = lanes_up_to(bounds(tree, at), within), at
        while layer <= height and pending[layer] == 0:
            layer += 1
        if layer > height:
            return found
        at = np.int64(tree.children[path[layer], first_lane(pending[layer])])
        pending[layer] &= pending[layer] - 1  # without the first
        layer -= 1


@kernel
def look_for_cheaper(tree, leaf, costs, found, within):  # type: ignore[no-untyped-def]
    """Scan a leaf; return the cheapest point within a squared radius so far.

    Args:
        tree: Its ``query`` is set.
        leaf: The leaf.
        costs: Cost of each point, by index, shape (capacity,).
        found: The cheapest so far, negative if none.
        within: Squared radius.
    """
    for chunk in range(-(-tree.sizes[leaf] // LANES)):
        near = lanes_up_to(squares(tree, leaf, chunk), within)
        while near != 0:
            name = np.int64(tree.names[leaf * LEAF_SIZE + chunk * LANES + first_lane(near)])
            near &= near - 1
            if found < 0 or costs[name] < costs[found]:
                found = name
    return found
