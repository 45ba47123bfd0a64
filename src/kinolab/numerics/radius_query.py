"""The cheapest of all points around a query, in a forest whose points have costs."""

from __future__ import annotations

from kinolab.numerics.jit import kernel
from kinolab.numerics.kd_forest import BRANCHING, LEAF_SIZE, bound, measure


@kernel
def cheapest_within(forest, costs, query, square):  # type: ignore[no-untyped-def]
    """Return the name of the cheapest point near a query, -1 where there is none.

    Of several that cost the same it is one.

    Args:
        forest: Of points.
        costs: Of points, by name.
        query: Scaled coordinates (d,).
        square: What counts as near: a squared distance.
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
    """Look at the first points of a block; return the cheapest near a query so far.

    Args:
        forest: Of points.
        block, names: Points (d, LEAF_SIZE) and their names, shape (LEAF_SIZE,) or more.
        count: How many of them there are.
        costs: Of points, by name, shape (capacity,).
        query, square: As ``cheapest_within`` takes them.
        found: The cheapest so far, negative where there is none.
    """
    squares = forest.squares
    measure(block, query, forest.period, squares)
    for k in range(count):
        if squares[k] <= square and (found < 0 or costs[names[k]] < costs[found]):
            found = names[k]
    return found


@kernel
def descend_cheap(forest, level, costs, query, square, found):  # type: ignore[no-untyped-def]
    """Look through the tree of a level; return the cheapest point near a query so far.

    Args:
        forest: With a tree at the level.
        level: Its number.
        costs, query, square, found: As ``look_cheap`` takes them.
    """
    blocks, names, queue = forest.blocks, forest.names, forest.queue
    boxes, bounds, period = forest.boxes, forest.bounds, forest.period
    leaves, begin = 1 << level, forest.begin[level]
    queue[0, 0], queue[0, 1], left = (level - 1) // 3, 0, 1  # WIDTH is 2^3
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
