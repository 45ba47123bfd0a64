"""Insertion into an R-tree: down the nearest boxes; what is full is split on the way.

Boxes of an R-tree that grows point by point come to overlap. So the tree is packed anew whenever
the number of its points has doubled, and when no leaf is left.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.packing import pack, widest_side
from kinolab.numerics.neighbours.r_tree import (
    HEIGHT,
    LEAF_SIZE,
    LEAVES,
    POINTS,
    ROOT,
    fill_leaf,
    hold_group,
    open_group,
    open_lane,
    refill_leaf,
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
    """Add a point (d,); its index is the number of points before it.

    A point with a coordinate that is not finite is not found, and does no harm.
    """
    name, count = tree.counts[POINTS], tree.counts[POINTS] + 1
    tree.counts[POINTS] = count
    for i in range(point.shape[0]):
        value = np.float32(point[i])
        tree.points[name, i] = value if abs(value) < FAR else FAR
    is_doubled = count > LEAF_SIZE and count & (count - 1) == 0  # a power of two
    if is_doubled or tree.counts[LEAVES] == tree.sizes.shape[0]:
        pack(tree)
    else:
        insert(tree, name)


@kernel
def insert(tree, name):  # type: ignore[no-untyped-def]
    """Put a point into the leaf whose box is the nearest, layer by layer.

    A full child is split before it is entered, so that there is always a lane for its other half.
    """
    at = tree.counts[ROOT]
    if tree.branches[at] == LANES:  # one more layer
        child, at = at, open_group(tree)
        hold_group(tree, at, open_lane(tree, at), child)
        tree.counts[ROOT] = at
        tree.counts[HEIGHT] += 1
    for layer in range(tree.counts[HEIGHT] - 1, -1, -1):
        lane = nearest_lane(tree, at, name)
        child = np.int64(tree.children[at, lane])
        other = lane
        if layer == 0 and tree.sizes[child] == LEAF_SIZE:
            other = split_leaf(tree, at, lane)
        elif layer > 0 and tree.branches[child] == LANES:
            other = split_group(tree, at, lane)
        if is_nearer(tree, at, other, lane, name):
            lane = other
        extend_box(tree, at, lane, name)
        at = np.int64(tree.children[at, lane])
    place = tree.sizes[at]
    tree.sizes[at] += 1
    tree.names[at * LEAF_SIZE + place] = name
    for i in range(tree.period.shape[0]):
        tree.blocks[at, place // LANES, i, place % LANES] = tree.points[name, i]


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
def is_nearer(tree, group, one, other, name):  # type: ignore[no-untyped-def]
    """Return whether the box of a child of a group is nearer to a point than that of another.

    Args:
        tree: The tree.
        group: The group.
        one, other: Lanes of the two children.
        name: Index of the point.
    """
    boxes, excess = tree.boxes, NOTHING
    if one == other:
        return False
    for i in range(tree.period.shape[0]):
        value = tree.points[name, i]
        gap = max(boxes[group, 0, i, one] - value, value - boxes[group, 1, i, one], NOTHING)
        excess += gap * gap
        gap = max(boxes[group, 0, i, other] - value, value - boxes[group, 1, i, other], NOTHING)
        excess -= gap * gap
    return excess < NOTHING


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
    names, first = tree.names, np.int64(tree.children[group, lane]) * LEAF_SIZE
    middle, last = first + LEAF_SIZE // 2, first + LEAF_SIZE
    widest = widest_side(tree.points, names, first, last)
    partition_median(tree.points, widest, names, first, last - 1, middle)
    other = fill_leaf(tree, group, names, middle, last)
    refill_leaf(tree, group, lane, names, first, middle)
    return other


@kernel
def split_group(tree, group, lane):  # type: ignore[no-untyped-def]
    """Split a full child at the median of its boxes' centres; return the lane of the new half."""
    child, boxes, d = np.int64(tree.children[group, lane]), tree.boxes, tree.period.shape[0]
    widest, extent = 0, -FAR  # the axis on which centres vary most
    for i in range(d):
        low, high = FAR, -FAR
        for k in range(LANES):
            centre = boxes[child, 0, i, k] + boxes[child, 1, i, k]
            low, high = min(low, centre), max(high, centre)
        if high - low > extent:
            widest, extent = i, high - low
    for k in range(LANES):
        tree.keys[0, k] = boxes[child, 0, widest, k] + boxes[child, 1, widest, k]
    new, other = open_group(tree), open_lane(tree, group)
    tree.branches[child] = 0
    for k in range(LANES):  # no lane is written before it is read
        rank = 0
        for j in range(LANES):
            before = tree.keys[0, j] < tree.keys[0, k]
            rank += before or (j < k and tree.keys[0, j] == tree.keys[0, k])
        half = child if rank < LANES // 2 else new
        to = open_lane(tree, half)
        tree.children[half, to] = tree.children[child, k]
        for i in range(d):
            boxes[half, 0, i, to] = boxes[child, 0, i, k]
            boxes[half, 1, i, to] = boxes[child, 1, i, k]
    for i in range(d):
        for k in range(LANES // 2, LANES):
            boxes[child, 0, i, k] = FAR
            boxes[child, 1, i, k] = -FAR
    hold_group(tree, group, lane, child)
    hold_group(tree, group, other, new)
    return other
