"""Insertion into an R-tree: down the nearest boxes; what is full is split on the way.

Boxes of an R-tree that grows point by point come to overlap. So the tree is packed anew whenever
the number of its points has doubled.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.packing import pack
from kinolab.numerics.neighbours.r_tree import (
    HEIGHT,
    LEAF_SIZE,
    POINTS,
    ROOT,
    empty_group,
    empty_leaf,
    hold_group,
    hold_leaf,
    open_group,
    open_lane,
    open_leaf,
    put,
)
from kinolab.numerics.neighbours.selection import partition_median
from kinolab.numerics.simd import (
    FAR,
    LANES,
    NOTHING,
    first_lane,
    lanes_at,
    least,
    load,
    maximum,
    spread,
)


@kernel
def add(tree, point):  # type: ignore[no-untyped-def]
    """Add a point (d,); its index is the number of points before it."""
    name, count = tree.counts[POINTS], tree.counts[POINTS] + 1
    tree.counts[POINTS] = count
    for i in range(point.shape[0]):
        tree.points[name, i] = point[i]
    insert(tree, name)
    if count > LEAF_SIZE and count & (count - 1) == 0:  # a power of two
        pack(tree)


@kernel
def insert(tree, name):  # type: ignore[no-untyped-def]
    """Put a point into the leaf whose box is the nearest, layer by layer.

    A full child is split before it is entered, so that there is always a lane for its other half.
    """
    make_room_below_root(tree)
    at = tree.counts[ROOT]
    for layer in range(tree.counts[HEIGHT] - 1, -1, -1):
        lane = nearest_lane(tree, at, name)
        child = np.int64(tree.children[at, lane])
        if layer == 0 and tree.sizes[child] == LEAF_SIZE:
            lane = nearer_lane(tree, at, lane, split_leaf(tree, at, lane), name)
        elif layer > 0 and tree.branches[child] == LANES:
            lane = nearer_lane(tree, at, lane, split_group(tree, at, lane), name)
        extend_box(tree, at, lane, name)
        at = np.int64(tree.children[at, lane])
    put(tree, at, name)


@kernel
def make_room_below_root(tree):  # type: ignore[no-untyped-def]
    """Split the root if it is full; then the tree has one more layer."""
    root, height = tree.counts[ROOT], tree.counts[HEIGHT]
    if height == 0 and tree.sizes[root] == LEAF_SIZE:
        above = open_group(tree)
        hold_leaf(tree, above, open_lane(tree, above), root)
        split_leaf(tree, above, 0)
    elif height > 0 and tree.branches[root] == LANES:
        above = open_group(tree)
        hold_group(tree, above, open_lane(tree, above), root)
        split_group(tree, above, 0)
    else:
        return
    tree.counts[ROOT], tree.counts[HEIGHT] = above, height + 1


@kernel
def nearest_lane(tree, group, name):  # type: ignore[no-untyped-def]
    """Return the lane of the child of a group whose box is the nearest to a point.

    No distance is across a period: boxes do not wrap around.
    """
    total = spread(NOTHING)
    for i in range(tree.period.shape[0]):
        value = spread(tree.points[name, i])
        low, high = load(tree.boxes, (group, 0, i, 0)), load(tree.boxes, (group, 1, i, 0))
        gap = maximum(maximum(low - value, value - high), spread(NOTHING))
        total += gap * gap
    return first_lane(lanes_at(total, least(total)))


@kernel
def nearer_lane(tree, group, one, other, name):  # type: ignore[no-untyped-def]
    """Return which of two children of a group has the box that is nearer to a point."""
    excess = NOTHING
    for i in range(tree.period.shape[0]):
        excess += gap_to_box(tree, group, i, one, name) - gap_to_box(tree, group, i, other, name)
    return one if excess <= NOTHING else other


@kernel
def gap_to_box(tree, group, i, lane, name):  # type: ignore[no-untyped-def]
    """Return the squared gap between a point and a child's box along an axis."""
    value = tree.points[name, i]
    low, high = tree.boxes[group, 0, i, lane], tree.boxes[group, 1, i, lane]
    gap = max(low - value, value - high, NOTHING)
    return gap * gap


@kernel
def extend_box(tree, group, lane, name):  # type: ignore[no-untyped-def]
    """Extend a child's box to a point."""
    boxes = tree.boxes
    for i in range(tree.period.shape[0]):
        value = tree.points[name, i]
        boxes[group, 0, i, lane] = min(boxes[group, 0, i, lane], value)
        boxes[group, 1, i, lane] = max(boxes[group, 1, i, lane], value)


@kernel
def split_leaf(tree, group, lane):  # type: ignore[no-untyped-def]
    """Split a full leaf at the median of its widest side; return the lane of the new half."""
    leaf, boxes, names = np.int64(tree.children[group, lane]), tree.boxes, tree.names
    widest, extent = 0, -FAR
    for i in range(tree.period.shape[0]):
        side = boxes[group, 1, i, lane] - boxes[group, 0, i, lane]
        if side > extent:
            widest, extent = i, side
    first, half = leaf * LEAF_SIZE, LEAF_SIZE // 2
    partition_median(tree.points, widest, names, first, first + LEAF_SIZE - 1, first + half)
    new, new_lane = open_leaf(tree), open_lane(tree, group)
    empty_leaf(tree, leaf)
    for k in range(LEAF_SIZE):  # a name is written where it was
        put(tree, leaf if k < half else new, names[first + k])
    hold_leaf(tree, group, lane, leaf)
    hold_leaf(tree, group, new_lane, new)
    return new_lane


@kernel
def split_group(tree, group, lane):  # type: ignore[no-untyped-def]
    """Split a full child at the median of its boxes' centres; return the lane of the new half."""
    child, boxes = np.int64(tree.children[group, lane]), tree.boxes
    partition_median(
        tree.centres, widest_of_centres(tree, child), tree.order, 0, LANES - 1, LANES // 2
    )
    for k in range(LANES):
        tree.moved[k] = tree.children[child, k]
        for i in range(tree.period.shape[0]):
            tree.moved_boxes[0, i, k] = boxes[child, 0, i, k]
            tree.moved_boxes[1, i, k] = boxes[child, 1, i, k]
    new, new_lane = open_group(tree), open_lane(tree, group)
    empty_group(tree, child)
    for k in range(LANES):
        half, old = child if k < LANES // 2 else new, tree.order[k]
        to = open_lane(tree, half)
        tree.children[half, to] = tree.moved[old]
        for i in range(tree.period.shape[0]):
            boxes[half, 0, i, to] = tree.moved_boxes[0, i, old]
            boxes[half, 1, i, to] = tree.moved_boxes[1, i, old]
    hold_group(tree, group, lane, child)
    hold_group(tree, group, new_lane, new)
    return new_lane


@kernel
def widest_of_centres(tree, group):  # type: ignore[no-untyped-def]
    """Write twice the centres of a full group's boxes; return the axis on which they vary most."""
    widest, extent = 0, -FAR
    for i in range(tree.period.shape[0]):
        low, high = FAR, -FAR
        for k in range(LANES):
            value = tree.boxes[group, 0, i, k] + tree.boxes[group, 1, i, k]
            tree.centres[k, i] = value
            low, high = min(low, value), max(high, value)
        if high - low > extent:
            widest, extent = i, high - low
    for k in range(LANES):
        tree.order[k] = k
    return widest
