"""Packing of an R-tree: all of its points are sorted into boxes that do not overlap.

A group's points are divided at medians of widest sides, like those of a kd-tree, into as many parts
as it gets children. Leaves and groups keep room for further points.

Source: Friedman, Bentley, Finkel, An algorithm for finding best matches in logarithmic expected
time, ACM TOMS 3(3), 1977; Roussopoulos, Leifker, Direct spatial search on pictorial databases using
packed R-trees, SIGMOD 1985.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.jit import kernel
from kinolab.numerics.neighbours.r_tree import (
    FILL,
    GROUPS,
    HEIGHT,
    LEAF_SIZE,
    LEAVES,
    POINTS,
    ROOT,
    fill_leaf,
    hold_group,
    open_group,
    open_lane,
)
from kinolab.numerics.neighbours.selection import partition_median
from kinolab.numerics.simd import FAR

CHILDREN = 11  # most children of a group, about


@kernel
def pack(tree):  # type: ignore[no-untyped-def]
    """Build the tree anew, from the root to the leaves; of more points than a leaf takes."""
    count = tree.counts[POINTS]
    # At the end of memory for a third more: names that leaves write are before what is yet to read.
    order = tree.names[tree.names.shape[0] - count :]
    for k in range(count):
        order[k] = k
    height, leaves = 1, CHILDREN  # leaves below the root, at most
    while leaves * FILL < count:
        height, leaves = height + 1, leaves * CHILDREN
    tree.counts[LEAVES] = tree.counts[GROUPS] = 0
    root, group, lowest = open_group(tree), 0, 0
    tree.counts[HEIGHT], tree.counts[ROOT] = height, root
    tree.children[root, 0], tree.children[root, 1] = 0, count
    for layer in range(height - 1, -1, -1):
        leaves //= CHILDREN
        lowest = group
        for _ in range(tree.counts[GROUPS] - group):
            divide(tree, order, group, layer, leaves)
            group += 1
    for group in range(lowest - 1, -1, -1):  # children before their parents
        for lane in range(tree.branches[group]):
            hold_group(tree, group, lane, np.int64(tree.children[group, lane]))


@kernel
def divide(tree, order, group, layer, leaves):  # type: ignore[no-untyped-def]
    """Divide the points of a new group into its children, of equal size but for rounding.

    Args:
        tree: Where a new group's first two children will be is its range in ``order``: the first
            position and that after the last; written.
        order: Indices of points; sorted.
        group: The group.
        layer: Number of layers of groups below it.
        leaves: Of a child, at most.
    """
    parts = tree.parts
    first, last = np.int64(tree.children[group, 0]), np.int64(tree.children[group, 1])
    count = -(-((last - first) // FILL) // leaves)
    if layer == 0:
        # One point less than a leaf has leaves room for rounding.
        count = max(count, -(-(last - first) // (LEAF_SIZE - 1)))
    parts[0, 0], parts[0, 1], parts[0, 2], left = first, last, count, 1
    while left > 0:
        left -= 1
        first, last, count = parts[left, 0], parts[left, 1], parts[left, 2]
        if count == 1 and layer == 0:
            fill_leaf(tree, group, order, first, last)
            continue
        if count == 1:  # a group that is yet to be divided
            child = open_group(tree)
            tree.children[child, 0], tree.children[child, 1] = first, last
            tree.children[group, open_lane(tree, group)] = child
            continue
        middle = first + (last - first) * (count // 2) // count
        widest = widest_side(tree.points, order, first, last)
        partition_median(tree.points, widest, order, first, last - 1, middle)
        parts[left, 0], parts[left, 1], parts[left, 2] = middle, last, count - count // 2
        left += 1
        parts[left, 0], parts[left, 1], parts[left, 2] = first, middle, count // 2
        left += 1


@kernel
def widest_side(points, order, first, last):  # type: ignore[no-untyped-def]
    """Return the axis on which a sample of a range of points, in an order, extends farthest."""
    widest, extent = 0, -FAR
    for i in range(points.shape[1]):
        low, high = FAR, -FAR
        # 64, the least number of points that tell which side of many is the widest
        for k in range(first, last, max((last - first) // 64, 1)):
            value = points[order[k], i]
            low, high = min(low, value), max(high, value)
        if high - low > extent:
            widest, extent = i, high - low
    return widest
