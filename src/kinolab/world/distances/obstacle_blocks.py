"""Boxes around blocks of obstacles, so that one look passes over many that are far away.

Blocks follow the order of the obstacles and are passed over whole, so that those which are looked
at come in the same order as without them. They help most where near obstacles follow each other.
"""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.world.distances.gjk import box_gap

SHIFT = 5  # blocks hold 2^5 obstacles, or blocks


def blocks_around(boxes: Array) -> tuple[Array, Integers]:
    """Return the boxes of all blocks of boxes (n, 6), and the first of each layer, lowest first."""
    layers = []
    while len(boxes) > 1 << SHIFT:
        begin = np.arange(0, len(boxes), 1 << SHIFT)
        low, high = np.minimum.reduceat(boxes, begin), np.maximum.reduceat(boxes, begin)
        boxes = np.concatenate([low[:, :3], high[:, 3:]], axis=1)
        layers.append(boxes)
    first = np.cumsum([0, *map(len, layers)], dtype=np.int64)[:-1]
    return np.concatenate([np.zeros((0, 6)), *layers]), first


@kernel
def following(k, box, reach, obstacles):  # type: ignore[no-untyped-def]
    """Return the first obstacle from one on whose blocks are nearer to a box than a reach.

    Args:
        k: The obstacle to begin with.
        box: Lowest and highest x, y, z in [m], shape (6,).
        reach: In [m].
        obstacles: ``ObstacleArrays``.

    Returns:
        Its row; the number of obstacles where there is none.
    """
    blocks, first = obstacles.blocks, obstacles.first
    while k < obstacles.box.shape[0]:
        passed = 0
        for layer in range(first.shape[0] - 1, -1, -1):
            bits = SHIFT * (layer + 1)
            begins = k & ((1 << bits) - 1) == 0
            if begins and box_gap(box, blocks[first[layer] + (k >> bits)]) >= reach:
                passed = 1 << bits
                break
        if passed == 0:
            return k
        k += passed
    return obstacles.box.shape[0]
