"""Nearest neighbours in a growing point set: a forest of kd-trees.

The newest points are kept in a list. When it is full it becomes a tree, together with all trees
that are no larger, like carries in a binary counter, so that each point is sorted into a larger
tree only a few times. A tree is split at the median of its widest side down to leaves; the boxes of
eight nodes are stored side by side, as are the points of a leaf, for vectorisation. Coordinates may
be periodic: distances wrap around.

Source: Bentley, Saxe, Decomposable searching problems, Journal of Algorithms 1(4), 1980; Friedman,
Bentley, Finkel, An algorithm for finding best matches in logarithmic expected time, ACM TOMS 3(3),
1977; for the slack, Arya, Mount et al., Journal of the ACM 45(6), 1998.
"""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel


@kernel
def partition_median(values, axis, order, first, last, at):  # type: ignore[no-untyped-def]
    """Quickselect in ``order``: no value before ``at`` exceeds one after it.

    Args:
        values: Shape (n, d).
        axis: The column to compare.
        order: Rows of ``values``, shape (n,); written.
        first, last: Range to sort, both ends included.
        at: Position in that range.

    Source: Hoare, Algorithm 65: find, Communications of the ACM 4(7), 1961.
    """
    while first < last:
        pivot = values[order[(first + last) // 2], axis]
        i, j = first, last
        while i <= j:
            while values[order[i], axis] < pivot:
                i += 1
            while values[order[j], axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i, j = i + 1, j - 1
        if at <= j:
            last = j
        elif at >= i:
            first = i
        else:
            return


Integers: TypeAlias = NDArray[np.int64]
Singles: TypeAlias = NDArray[np.float32]

LEAF_SIZE = 64  # points per leaf, and in the list of the newest points
BRANCHING = 8  # boxes tested together
QUEUE_SIZE = 512  # most pending nodes of a tree: BRANCHING per layer
# approximate search: no point is nearer by more than a tenth
RELATIVE_SLACK = np.float32(1.0 / 1.1**2)
NOTHING, FAR = np.float32(0.0), np.float32(np.inf)


class KdForest(NamedTuple):
    """Points and trees in flat arrays, for compiled code.

    Level k holds no tree or one of 2^k leaves, which begin at block 2^k; block 0 is the list of the
    newest points. Above the leaves of a level are layers of boxes, the lowest first.
    """

    points: Singles  # (capacity, d) scaled coordinates, by index
    blocks: Singles  # (blocks, d, LEAF_SIZE)
    names: NDArray[np.int32]  # (blocks * LEAF_SIZE,) point indices
    boxes: Singles  # (groups, 2, d, BRANCHING) lowest and highest coordinates
    begin: Integers  # (levels,) the first group of boxes of a level
    full: NDArray[np.uint8]  # (levels,) whether there is a tree
    counts: Integers  # (2,) of all points, and of those in the list
    period: Singles  # (d,) of each coordinate; infinite if it is not periodic
    squares: Singles  # (LEAF_SIZE,) scratch
    bounds: Singles  # (BRANCHING,) scratch
    queue: Integers  # (QUEUE_SIZE, 2) scratch: layer and group
    gaps: Singles  # (QUEUE_SIZE,) scratch


def kd_forest(capacity: int, period: Array) -> KdForest:
    """Return an empty forest; ``period`` (d,) is infinite for non-periodic coordinates."""
    levels, d = max(1, (capacity // LEAF_SIZE).bit_length()), len(period)
    groups = [sum(_layers(1 << level)) for level in range(levels)]
    # What a tree holds is written before it is read: to clear it all would take milliseconds.
    blocks = np.empty((1 << levels, d, LEAF_SIZE), np.float32)
    blocks[0] = 0.0  # of the list, all of which is measured
    return KdForest(
        points=np.empty((capacity, d), np.float32),
        blocks=blocks,
        names=np.empty(LEAF_SIZE << levels, np.int32),
        boxes=np.empty((sum(groups), 2, d, BRANCHING), np.float32),
        begin=np.cumsum([0, *groups[:-1]]).astype(np.int64),
        full=np.zeros(levels, np.uint8),
        counts=np.zeros(2, np.int64),
        period=np.asarray(period, np.float32),
        squares=np.zeros(LEAF_SIZE, np.float32),
        bounds=np.zeros(BRANCHING, np.float32),
        queue=np.zeros((QUEUE_SIZE, 2), np.int64),
        gaps=np.zeros(QUEUE_SIZE, np.float32),
    )


def _layers(leaves: int) -> list[int]:
    """Return the number of groups of boxes in each layer above the leaves."""
    found: list[int] = []
    while leaves > 1:
        leaves = -(-leaves // BRANCHING)
        found.append(leaves)
    return found


@kernel
def clear(forest):  # type: ignore[no-untyped-def]
    """Remove all points."""
    forest.full[:] = 0
    forest.counts[:] = 0


@kernel
def add(forest, point):  # type: ignore[no-untyped-def]
    """Add a point (d,); its index is the number of points before it."""
    name, at = forest.counts[0], forest.counts[1]
    for i in range(point.shape[0]):
        forest.points[name, i] = point[i]
        forest.blocks[0, i, at] = point[i]
    forest.names[at] = name
    forest.counts[0] += 1
    forest.counts[1] += 1
    if forest.counts[1] == LEAF_SIZE:
        carry(forest)
        forest.counts[1] = 0


@kernel
def carry(forest):  # type: ignore[no-untyped-def]
    """Merge the list and all trees below the first empty level into one tree."""
    points, names, blocks, d = forest.points, forest.names, forest.blocks, forest.points.shape[1]
    level = 0
    while forest.full[level]:
        forest.full[level] = 0
        level += 1
    forest.full[level] = 1
    leaves = 1 << level
    begin = LEAF_SIZE * leaves
    for k in range(begin):  # the list and lower levels lie just before, with as many points
        names[begin + k] = names[k]
    for depth in range(level):
        length = begin >> depth
        for first in range(begin, 2 * begin, length):
            widest, extent = 0, -FAR
            for i in range(d):
                low, high = FAR, -FAR
                for k in range(first, first + length):
                    value = points[names[k], i]
                    low, high = min(low, value), max(high, value)
                if high - low > extent:
                    widest, extent = i, high - low
            partition_median(points, widest, names, first, first + length - 1, first + length // 2)
    for leaf in range(leaves, 2 * leaves):
        for k in range(LEAF_SIZE):
            for i in range(d):
                blocks[leaf, i, k] = points[names[leaf * LEAF_SIZE + k], i]
    enclose(forest, level)


@kernel
def enclose(forest, level):  # type: ignore[no-untyped-def]
    """Compute the bounding boxes of a level's tree, layer by layer."""
    blocks, boxes, d = forest.blocks, forest.boxes, forest.points.shape[1]
    count, group, below = 1 << level, forest.begin[level], -1
    first_leaf = count
    while count > 1:
        first_group, groups = group, -(-count // BRANCHING)
        for part_of in range(groups * BRANCHING):
            group, c = first_group + part_of // BRANCHING, part_of % BRANCHING
            for i in range(d):
                low, high = FAR, -FAR  # empty box: farther than anything
                if part_of < count and below < 0:
                    for k in range(LEAF_SIZE):
                        value = blocks[first_leaf + part_of, i, k]
                        low, high = min(low, value), max(high, value)
                elif part_of < count:
                    for k in range(BRANCHING):
                        low = min(low, boxes[below + part_of, 0, i, k])
                        high = max(high, boxes[below + part_of, 1, i, k])
                boxes[group, 0, i, c], boxes[group, 1, i, c] = low, high
        below, count, group = first_group, groups, first_group + groups


@kernel
def measure(block, query, period, squares):  # type: ignore[no-untyped-def]
    """Write the squared distances (LEAF_SIZE,) of a block's points from a query (d,)."""
    for k in range(LEAF_SIZE):
        squares[k] = NOTHING
    for i in range(period.shape[0]):
        value, turn = np.float32(query[i]), period[i]
        if turn == FAR:
            for k in range(LEAF_SIZE):  # vectorised
                gap = block[i, k] - value
                squares[k] += gap * gap
        else:
            for k in range(LEAF_SIZE):
                gap = abs(block[i, k] - value)
                gap = min(gap, turn - gap)
                squares[k] += gap * gap


@kernel
def bound(boxes, query, period, bounds):  # type: ignore[no-untyped-def]
    """Write lower bounds (BRANCHING,) on squared distances from a query to points in boxes."""
    for c in range(BRANCHING):
        bounds[c] = NOTHING
    for i in range(period.shape[0]):
        value, turn = np.float32(query[i]), period[i]
        for c in range(BRANCHING):
            under, over = boxes[0, i, c] - value, value - boxes[1, i, c]
            gap = max(under, over, NOTHING)
            # The other end may be nearer across the period.
            gap = min(gap, max(turn + min(under, over), NOTHING))
            bounds[c] += gap * gap


@kernel
def nearest(forest, query, start, best, slack=RELATIVE_SLACK):  # type: ignore[no-untyped-def]
    """Return index and squared distance of an approximate nearest neighbour of a query (d,).

    No point is nearer by more than a tenth, unless ``slack`` says otherwise.

    Args:
        forest: With points.
        query: Scaled coordinates.
        start: Index returned if no point is nearer than ``best``.
        best: A squared distance.
        slack: No point has less than this fraction of the squared distance found.
    """
    found, least, period = start, np.float32(best), forest.period
    squares, blocks, names, full = forest.squares, forest.blocks, forest.names, forest.full
    count = forest.counts[1]
    if count > 0:
        found, least = look(blocks[0], names, count, query, period, squares, found, least)
    for level in range(full.shape[0] - 1, -1, -1):  # large trees first: likelier to hold it
        if full[level] and level > 0:
            found, least = descend(forest, level, query, found, least, slack)
        elif full[level]:
            own = names[LEAF_SIZE:]
            found, least = look(
                blocks[1], own, np.int64(LEAF_SIZE), query, period, squares, found, least
            )
    return found, least


@kernel
def look(block, names, count, query, period, squares, found, least):  # type: ignore[no-untyped-def]
    """Scan the first points of a block; return the nearest so far, and its squared distance.

    Args:
        block, names: Points (d, LEAF_SIZE) and their indices, shape (LEAF_SIZE,) or more.
        count: Number of points to scan.
        query, period: Scaled coordinates and their periods, shape (d,).
        squares: Scratch, shape (LEAF_SIZE,).
        found, least: The nearest so far, and its squared distance.
    """
    measure(block, query, period, squares)
    for k in range(count):
        if squares[k] < least:
            least, found = squares[k], names[k]
    return found, least


@kernel
def descend(forest, level, query, found, least, slack):  # type: ignore[no-untyped-def]
    """Search the tree of a level; return the nearest so far, and its squared distance.

    Args:
        forest: With a tree at the level.
        level: Its number.
        query: Scaled coordinates, shape (d,).
        found, least: The nearest so far, and its squared distance.
        slack: As ``nearest`` takes it.
    """
    # Local variables: reading a tuple's field in a loop costs time.
    blocks, names, squares = forest.blocks, forest.names, forest.squares
    boxes, bounds, queue, gaps = forest.boxes, forest.bounds, forest.queue, forest.gaps
    period, leaves, begin = forest.period, 1 << level, forest.begin[level]
    queue[0, 0], queue[0, 1], gaps[0], left = (level - 1) // 3, 0, NOTHING, 1  # BRANCHING is 2^3
    while left > 0:
        left -= 1
        if not gaps[left] < least * slack:
            continue
        layer, group = queue[left, 0], queue[left, 1]
        first, count = begin, leaves
        for _ in range(layer):
            count = -(-count // BRANCHING)
            first += count
        bound(boxes[first + group], query, period, bounds)
        if layer > 0:
            bottom = left
            for c in range(BRANCHING):
                if not bounds[c] < least * slack:
                    continue
                k = left
                while k > bottom and gaps[k - 1] < bounds[c]:  # the nearest on top
                    gaps[k] = gaps[k - 1]
                    queue[k, 0], queue[k, 1] = queue[k - 1, 0], queue[k - 1, 1]
                    k -= 1
                gaps[k], queue[k, 0], queue[k, 1] = bounds[c], layer - 1, group * BRANCHING + c
                left += 1
            continue
        for _ in range(BRANCHING):
            nearer = 0
            for c in range(1, BRANCHING):
                if bounds[c] < bounds[nearer]:
                    nearer = c
            if not bounds[nearer] < least * slack:
                break
            bounds[nearer] = FAR
            leaf = leaves + group * BRANCHING + nearer
            own = names[leaf * LEAF_SIZE :]
            found, least = look(
                blocks[leaf], own, np.int64(LEAF_SIZE), query, period, squares, found, least
            )
    return found, least


@kernel
def cheapest_within(forest, costs, query, square):  # type: ignore[no-untyped-def]
    """Return the index of the cheapest point within a radius of a query, -1 if there is none.

    Ties are broken arbitrarily.

    Args:
        forest: Of points.
        costs: Cost of each point, by index.
        query: Scaled coordinates (d,).
        square: Squared radius.
    """
    blocks, names, full = forest.blocks, forest.names, forest.full
    found = look_cheap(forest, blocks[0], names, forest.counts[1], costs, query, square, -1)
    for level in range(full.shape[0]):
        if full[level] and level > 0:
            found = descend_cheap(forest, level, costs, query, square, found)
        elif full[level]:
            found = look_cheap(
                forest, blocks[1], names[LEAF_SIZE:], LEAF_SIZE, costs, query, square, found
            )
    return found


@kernel
def look_cheap(  # type: ignore[no-untyped-def]
    forest, block, names, count, costs, query, square, found,
):  # fmt: skip
    """Scan the first points of a block; return the cheapest within the radius so far.

    Args:
        forest: Of points.
        block, names: Points (d, LEAF_SIZE) and their indices, shape (LEAF_SIZE,) or more.
        count: Number of points to scan.
        costs: Cost of each point, by index, shape (capacity,).
        query, square: As ``cheapest_within`` takes them.
        found: The cheapest so far, negative if none.
    """
    squares = forest.squares
    measure(block, query, forest.period, squares)
    for k in range(count):
        if squares[k] <= square and (found < 0 or costs[names[k]] < costs[found]):
            found = names[k]
    return found


@kernel
def descend_cheap(forest, level, costs, query, square, found):  # type: ignore[no-untyped-def]
    """Search the tree of a level; return the cheapest point within the radius so far.

    Args:
        forest: With a tree at the level.
        level: Its number.
        costs, query, square, found: As ``look_cheap`` takes them.
    """
    blocks, names, queue = forest.blocks, forest.names, forest.queue
    boxes, bounds, period = forest.boxes, forest.bounds, forest.period
    leaves, begin = 1 << level, forest.begin[level]
    queue[0, 0], queue[0, 1], left = (level - 1) // 3, 0, 1  # BRANCHING is 2^3
    while left > 0:
        left -= 1
        layer, group = queue[left, 0], queue[left, 1]
        first, count = begin, leaves
        for _ in range(layer):
            count = -(-count // BRANCHING)
            first += count
        bound(boxes[first + group], query, period, bounds)
        for c in range(BRANCHING):
            if not bounds[c] <= square:
                continue
            if layer > 0:
                queue[left, 0], queue[left, 1] = layer - 1, group * BRANCHING + c
                left += 1
                continue
            leaf = leaves + group * BRANCHING + c
            own = names[leaf * LEAF_SIZE :]
            found = look_cheap(forest, blocks[leaf], own, LEAF_SIZE, costs, query, square, found)
    return found
