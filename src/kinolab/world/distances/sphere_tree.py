"""Trees of balls that contain a shape: what a grid of distances can be asked about.

A shape's box is halved again and again, across its longest edge; every piece that holds some of
the shape has a ball around it. Balls of pieces stick out of the shape less than the one around all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np

from kinolab.dynamics.language.shapes import Shape, ShapeKind
from kinolab.numerics.arrays import Array, Integers
from kinolab.world.shapes.geometry import sizes
from kinolab.world.shapes.support_functions import reach_along

STACK_SIZE = 8  # balls that wait in a search, at most: three are divided


Point: TypeAlias = tuple[float, ...]  # x, y, z in the shape's own frame, in [m]


class SphereTree(NamedTuple):
    """Balls around the shapes of a machine, in each shape's own frame, for compiled code."""

    root: Integers  # (shapes,) the ball around a whole shape
    center: Array  # (balls, 3) in [m]
    radius: Array  # (balls,) in [m]
    child: Integers  # (balls, 2) balls of its two halves, -1 where there is none


def sphere_tree(shapes: Sequence[Shape], finest: float) -> SphereTree:
    """Cover shapes with balls that become as small as ``finest`` in [m], as far as memory goes."""
    trees = [_around_one(shape, finest) for shape in shapes]
    counts = np.array([len(tree.radius) for tree in trees], dtype=np.int64)
    root = np.cumsum(counts) - counts
    if not trees:
        return SphereTree(root, np.zeros((0, 3)), np.zeros(0), np.zeros((0, 2), np.int64))
    children = [np.where(t.child < 0, -1, t.child + k) for t, k in zip(trees, root, strict=True)]
    return SphereTree(
        root,
        np.concatenate([tree.center for tree in trees]),
        np.concatenate([tree.radius for tree in trees]),
        np.concatenate(children),
    )


@lru_cache(maxsize=512)
def _around_one(shape: Shape, finest: float) -> SphereTree:
    """Cover one shape, level by level."""
    edges, rounding = shape.span()
    around = float(np.linalg.norm(np.array(edges, dtype=float))) / 2 + float(rounding)
    kind, half = sizes(shape)
    x, y, z = (float(reach_along(int(kind), half, axis)) for axis in range(3))
    is_round = bool(shape.symmetric) and kind is not ShapeKind.HULL
    balls: list[tuple[Point, float]] = [((0.0, 0.0, 0.0), around)]
    children = [[-1, -1]]
    level: list[tuple[int, Point, Point]] = [(0, (-x, -y, -z), (x, y, z))]
    if shape.symmetric == "xyz":
        level = []
    # balls of one shape: no more are asked for where three are divided
    while level and len(balls) + 2 * len(level) <= 31:
        finer = []
        for parent, low, high in level:
            if balls[parent][1] <= finest:
                continue
            for k, (first, last) in enumerate(_halves(low, high)):
                # Of what is round a box holds some where it does of its point next to the axis.
                if is_round and shape.depths(np.clip(0.0, first, last)) < 0.0:
                    continue
                children[parent][k] = len(balls)
                finer.append((len(balls), first, last))
                balls.append(_ball(first, last))
                children.append([-1, -1])
        level = finer
    return SphereTree(
        root=np.zeros(1, np.int64),
        center=np.array([center for center, _ in balls]),
        radius=(1.0 + 1e-9) * np.array([radius for _, radius in balls]),  # for rounding
        child=np.array(children, dtype=np.int64),
    )


def _ball(low: Point, high: Point) -> tuple[Point, float]:
    """Return the centre and the radius of the ball around a box."""
    (a, b, c), (x, y, z) = low, high
    radius = float(np.linalg.norm(np.subtract(high, low))) / 2
    return ((a + x) / 2, (b + y) / 2, (c + z) / 2), radius


def _halves(low: Point, high: Point) -> Iterator[tuple[Point, Point]]:
    edges = [b - a for a, b in zip(low, high, strict=True)]
    axis = edges.index(max(edges))
    middle = (low[axis] + high[axis]) / 2
    yield low, (*high[:axis], middle, *high[axis + 1 :])
    yield (*low[:axis], middle, *low[axis + 1 :]), high
