"""An R-tree in flat arrays: boxes of boxes of points.

Points lie side by side in leaves, as do the boxes of a group's children, so that a distance to all
of them takes a few instructions. All leaves are equally deep. Coordinates may be periodic.

Source: Guttman, R-trees: a dynamic index structure for spatial searching, SIGMOD 1984.
"""

from __future__ import annotations

from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array, Integers, Singles, allocate
from kinolab.numerics.jit import kernel
from kinolab.numerics.simd import FAR, LANES

CHUNKS = 2  # of a leaf
LEAF_SIZE = CHUNKS * LANES  # most points of a leaf; at least half as many if there are several
FILL = 24  # points of a leaf after packing, on average at least
SPARE_LEAVES = 32
MIN_CHILDREN = 5  # of a group that is not the root
LAYERS = 16  # most layers of groups
POINTS, LEAVES, GROUPS, HEIGHT, ROOT = range(5)  # entries of ``counts``


class RTree(NamedTuple):
    """Points and boxes, for compiled code."""

    points: Annotated[Singles, "capacity", "d"]  # scaled coordinates, by index
    blocks: Annotated[Singles, "leaf capacity", CHUNKS, "d", LANES]  # of leaves; else infinite
    names: Annotated[NDArray[np.int32], "name capacity"]  # indices of points of leaves
    sizes: Annotated[NDArray[np.int32], "leaf capacity"]  # numbers of points
    boxes: Annotated[Singles, "group capacity", 2, "d", LANES]  # lowest and highest of children
    children: Annotated[NDArray[np.int32], "group capacity", LANES]  # or leaves, if lowest
    branches: Annotated[NDArray[np.int32], "group capacity"]  # numbers of children
    counts: Integers  # (5,) of points, leaves, groups and layers of groups; the root group
    period: Singles  # (d,) of each coordinate; infinite if it is not periodic
    query: Annotated[Singles, "d"]  # scratch
    keys: Annotated[Singles, LAYERS, LANES]  # scratch: ranked bounds of a search
    last: Annotated[Integers, LAYERS + 1]  # scratch: what a search has seen of a group
    path: Annotated[Integers, LAYERS + 1]  # scratch: groups of a search
    parts: Annotated[Integers, LANES, 3]  # scratch: parts to divide


def r_tree(capacity: int, period: Array) -> RTree:
    """Return an empty tree; ``period`` (d,) is infinite for non-periodic coordinates."""
    d, leaves = len(period), capacity // FILL + SPARE_LEAVES
    groups = LAYERS + leaves // MIN_CHILDREN
    sizes = {"capacity": capacity, "leaf capacity": leaves, "name capacity": leaves * LEAF_SIZE}
    tree = allocate(
        RTree,
        sizes | {"group capacity": groups, "d": d},
        counts=np.array([0, 1, 1, 1, 0], np.int64),
        period=np.asarray(period, np.float32),
    )
    tree.sizes[0], tree.branches[0], tree.children[0, 0] = 0, 1, 0
    tree.blocks[0], tree.boxes[0, 0], tree.boxes[0, 1] = FAR, FAR, -FAR
    return tree


@kernel
def clear(tree):  # type: ignore[no-untyped-def]
    """Remove all points: an empty leaf is left, below the root."""
    for k in range(tree.counts.shape[0]):
        tree.counts[k] = 0
    root = open_group(tree)
    tree.counts[HEIGHT] = 1
    fill_leaf(tree, root, tree.names, 0, 0)


@kernel
def open_group(tree):  # type: ignore[no-untyped-def]
    """Return a new group without children, whose boxes are farther than anything."""
    group = tree.counts[GROUPS]
    tree.counts[GROUPS] += 1
    tree.branches[group] = 0
    for i in range(tree.period.shape[0]):
        for lane in range(LANES):
            tree.boxes[group, 0, i, lane] = FAR
            tree.boxes[group, 1, i, lane] = -FAR
    return group


@kernel
def open_lane(tree, group):  # type: ignore[no-untyped-def]
    """Return the lane of a new child of a group that is not full."""
    lane = np.int64(tree.branches[group])
    tree.branches[group] += 1
    return lane


@kernel
def fill_leaf(tree, group, order, first, last):  # type: ignore[no-untyped-def]
    """Give a group of the lowest layer a new leaf with a range of points; return its lane.

    Args:
        tree, group: The group is not full.
        order: Indices of points, shape (points,).
        first, last: The range; ``last`` is the position after it.
    """
    leaf, lane = tree.counts[LEAVES], open_lane(tree, group)
    tree.counts[LEAVES] += 1
    tree.children[group, lane] = leaf
    refill_leaf(tree, group, lane, order, first, last)
    return lane


@kernel
def refill_leaf(tree, group, lane, order, first, last):  # type: ignore[no-untyped-def]
    """Let a leaf hold a range of points and no others.

    Args:
        tree, group, lane: The leaf is the group's child in that lane.
        order: Indices of points, shape (points,).
        first, last: As ``fill_leaf`` takes them.
    """
    leaf, size, blocks = np.int64(tree.children[group, lane]), last - first, tree.blocks
    tree.sizes[leaf] = size
    for k in range(size):
        tree.names[leaf * LEAF_SIZE + k] = order[first + k]
    for i in range(tree.period.shape[0]):
        low, high = FAR, -FAR
        for k in range(size):
            value = tree.points[tree.names[leaf * LEAF_SIZE + k], i]
            blocks[leaf, k // LANES, i, k % LANES] = value
            low, high = min(low, value), max(high, value)
        for k in range(size, LEAF_SIZE):
            blocks[leaf, k // LANES, i, k % LANES] = FAR
        tree.boxes[group, 0, i, lane] = low
        tree.boxes[group, 1, i, lane] = high


@kernel
def hold_group(tree, group, lane, child):  # type: ignore[no-untyped-def]
    """Make a group with children the child in a lane of a group of the layer above."""
    tree.children[group, lane] = child
    for i in range(tree.period.shape[0]):
        low, high = FAR, -FAR
        for k in range(tree.branches[child]):
            low = min(low, tree.boxes[child, 0, i, k])
            high = max(high, tree.boxes[child, 1, i, k])
        tree.boxes[group, 0, i, lane] = low
        tree.boxes[group, 1, i, lane] = high
