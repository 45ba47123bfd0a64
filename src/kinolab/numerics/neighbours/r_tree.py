"""An R-tree in flat arrays: boxes of boxes of points.

Points lie side by side in leaves, as do the boxes of a group's children, so that a distance to all
of them takes a few instructions. All leaves are equally deep. Coordinates may be periodic.

Source: Guttman, R-trees: a dynamic index structure for spatial searching, SIGMOD 1984.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array, Integers, Singles
from kinolab.numerics.jit import kernel
from kinolab.numerics.simd import FAR, LANES

CHUNKS = 2  # of a leaf
LEAF_SIZE = CHUNKS * LANES  # most points of a leaf; never below half of it if there are several
MIN_CHILDREN = 4  # of a group that is not the root
LAYERS = 16  # most layers of groups: MIN_CHILDREN to that power
POINTS, LEAVES, GROUPS, HEIGHT, ROOT = range(5)  # entries of ``counts``


class RTree(NamedTuple):
    """Points and boxes, for compiled code."""

    points: Singles  # (capacity, d) scaled coordinates, by index
    blocks: Singles  # (leaves, CHUNKS, d, LANES) points of leaves, infinite where there is none
    names: NDArray[np.int32]  # (leaves * LEAF_SIZE,) indices of the points of leaves
    sizes: NDArray[np.int32]  # (leaves,) numbers of points
    boxes: Singles  # (groups, 2, d, LANES) lowest and highest coordinates of children
    children: NDArray[np.int32]  # (groups, LANES) groups, or leaves in the lowest layer
    branches: NDArray[np.int32]  # (groups,) numbers of children
    counts: Integers  # (5,) of points, leaves, groups and layers of groups; the root
    period: Singles  # (d,) of each coordinate; infinite if it is not periodic
    query: Singles  # (d,) scratch
    keys: Singles  # (LAYERS, LANES) scratch: ranked bounds of a search
    last: Integers  # (LAYERS + 1,) scratch: what a search has seen of a group
    path: Integers  # (LAYERS + 1,) scratch: groups of a search
    parts: Integers  # (LANES, 3) scratch: parts to divide
    centres: Singles  # (LANES, d) scratch: of boxes
    order: NDArray[np.int32]  # (LANES,) scratch
    moved: NDArray[np.int32]  # (LANES,) scratch: children
    moved_boxes: Singles  # (2, d, LANES) scratch


def r_tree(capacity: int, period: Array) -> RTree:
    """Return an empty tree; ``period`` (d,) is infinite for non-periodic coordinates."""
    d, leaves = len(period), 1 + 2 * capacity // LEAF_SIZE
    groups = LAYERS + leaves // MIN_CHILDREN
    # What a tree holds is written before it is read: to clear it all would take milliseconds.
    tree = RTree(
        points=np.empty((capacity, d), np.float32),
        blocks=np.empty((leaves, CHUNKS, d, LANES), np.float32),
        names=np.empty(leaves * LEAF_SIZE, np.int32),
        sizes=np.empty(leaves, np.int32),
        boxes=np.empty((groups, 2, d, LANES), np.float32),
        children=np.empty((groups, LANES), np.int32),
        branches=np.empty(groups, np.int32),
        counts=np.array([0, 1, 0, 0, 0], np.int64),
        period=np.asarray(period, np.float32),
        query=np.zeros(d, np.float32),
        keys=np.zeros((LAYERS, LANES), np.float32),
        last=np.zeros(LAYERS + 1, np.int64),
        path=np.zeros(LAYERS + 1, np.int64),
        parts=np.zeros((LANES, 3), np.int64),
        centres=np.zeros((LANES, d), np.float32),
        order=np.zeros(LANES, np.int32),
        moved=np.zeros(LANES, np.int32),
        moved_boxes=np.zeros((2, d, LANES), np.float32),
    )
    tree.sizes[0], tree.blocks[0] = 0, FAR
    return tree


@kernel
def clear(tree):  # type: ignore[no-untyped-def]
    """Remove all points."""
    tree.counts[:] = 0
    open_leaf(tree)


@kernel
def open_leaf(tree):  # type: ignore[no-untyped-def]
    """Return a new empty leaf."""
    leaf = tree.counts[LEAVES]
    tree.counts[LEAVES] += 1
    empty_leaf(tree, leaf)
    return leaf


@kernel
def empty_leaf(tree, leaf):  # type: ignore[no-untyped-def]
    """Remove a leaf's points."""
    tree.sizes[leaf] = 0
    for chunk in range(CHUNKS):
        for i in range(tree.period.shape[0]):
            for k in range(LANES):
                tree.blocks[leaf, chunk, i, k] = FAR


@kernel
def put(tree, leaf, name):  # type: ignore[no-untyped-def]
    """Put a point into a leaf that is not full."""
    at = tree.sizes[leaf]
    tree.sizes[leaf] += 1
    tree.names[leaf * LEAF_SIZE + at] = name
    for i in range(tree.period.shape[0]):
        tree.blocks[leaf, at // LANES, i, at % LANES] = tree.points[name, i]


@kernel
def open_group(tree):  # type: ignore[no-untyped-def]
    """Return a new group without children."""
    group = tree.counts[GROUPS]
    tree.counts[GROUPS] += 1
    empty_group(tree, group)
    return group


@kernel
def empty_group(tree, group):  # type: ignore[no-untyped-def]
    """Remove a group's children; boxes of none are farther than anything."""
    tree.branches[group] = 0
    for i in range(tree.period.shape[0]):
        for lane in range(LANES):
            tree.boxes[group, 0, i, lane], tree.boxes[group, 1, i, lane] = FAR, -FAR


@kernel
def open_lane(tree, group):  # type: ignore[no-untyped-def]
    """Return the lane of a new child of a group that is not full."""
    lane = np.int64(tree.branches[group])
    tree.branches[group] += 1
    return lane


@kernel
def hold_leaf(tree, group, lane, leaf):  # type: ignore[no-untyped-def]
    """Make a leaf with points the child in a lane of a group of the lowest layer."""
    tree.children[group, lane] = leaf
    for i in range(tree.period.shape[0]):
        low, high = FAR, -FAR
        for k in range(tree.sizes[leaf]):
            value = tree.blocks[leaf, k // LANES, i, k % LANES]
            low, high = min(low, value), max(high, value)
        tree.boxes[group, 0, i, lane], tree.boxes[group, 1, i, lane] = low, high


@kernel
def hold_group(tree, group, lane, child):  # type: ignore[no-untyped-def]
    """Make a group with children the child in a lane of a group of the layer above."""
    tree.children[group, lane] = child
    for i in range(tree.period.shape[0]):
        low, high = FAR, -FAR
        for k in range(tree.branches[child]):
            low = min(low, tree.boxes[child, 0, i, k])
            high = max(high, tree.boxes[child, 1, i, k])
        tree.boxes[group, 0, i, lane], tree.boxes[group, 1, i, lane] = low, high
