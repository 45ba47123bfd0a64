"""Trees of balls that contain a shape: what a grid of distances can be asked about.

A shape's box is halved again and again, across its longest edge; every piece that holds some of
the shape has a ball around it. Balls of pieces stick out of the shape less than the one around all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from kinolab.dynamics.language.shapes import Shape
from kinolab.numerics.arrays import Array
from kinolab.world.collision.triangle_grid import Integers
from kinolab.world.geometry import ShapeKind, sizes

MAX_SPHERES = 31  # balls of one shape: no more are asked for where three are divided
ROUNDING_FACTOR = 1.0 + 1e-9  # for rounding


class SphereTree(NamedTuple):
    """Balls around the shapes of a machine, in each shape's own frame, for compiled code."""

    root: Integers  # (shapes,) the ball around a whole shape
    center: Array  # (balls, 3) in [m]
    radius: Array  # (balls,) in [m]
    child: Integers  # (balls, 2) balls of its two halves, -1 where there is none


def sphere_tree(shapes: Sequence[Shape], finest: float) -> SphereTree:
    """Cover shapes with balls that become as small as ``finest`` in [m], as far as memory goes."""
    rows: list[tuple[Array, float]] = []
    children: list[list[int]] = []
    roots = [_grow(*sizes(shape), finest, rows, children) for shape in shapes]
    return SphereTree(
        root=np.array(roots, dtype=np.int64),
        center=np.array([center for center, _ in rows]).reshape(-1, 3),
        radius=ROUNDING_FACTOR * np.array([radius for _, radius in rows], dtype=float),
        child=np.array(children, dtype=np.int64).reshape(-1, 2),
    )


def _grow(
    kind: ShapeKind,
    half: Array,
    finest: float,
    rows: list[tuple[Array, float]],
    children: list[list[int]],
) -> int:
    """Add the tree of one shape, level by level; return where it begins."""
    root, reach = (
        len(rows),
        half + (np.array([0.0, 0.0, half[0]]) if kind is ShapeKind.CAPSULE else 0.0),
    )
    rows.append((np.zeros(3), _around(kind, half)))
    children.append([-1, -1])
    level = [] if kind is ShapeKind.SPHERE else [(root, -reach, reach)]
    while level and len(rows) - root + 2 * len(level) <= MAX_SPHERES:
        finer = []
        for parent, low, high in level:
            if rows[parent][1] <= finest:
                continue
            for k, (first, last) in enumerate(_halves(low, high)):
                if not _holds(kind, half, first, last):
                    continue
                children[parent][k] = len(rows)
                finer.append((len(rows), first, last))
                rows.append(((first + last) / 2, float(np.linalg.norm(last - first)) / 2))
                children.append([-1, -1])
        level = finer
    return root


def _halves(low: Array, high: Array) -> Iterator[tuple[Array, Array]]:
    axis = int(np.argmax(high - low))
    middle = (low[axis] + high[axis]) / 2
    first, last = high.copy(), low.copy()
    first[axis] = last[axis] = middle
    yield low, first
    yield last, high


def _holds(kind: ShapeKind, half: Array, low: Array, high: Array) -> bool:
    """Say whether a box in the shape's frame holds any of it, as far as its roundness tells."""
    if kind is ShapeKind.BOX:
        return True
    nearest = np.clip(0.0, low, high)
    across = float(np.hypot(*nearest[:2]))
    if kind is ShapeKind.CAPSULE:
        across = float(np.hypot(across, max(abs(nearest[2]) - half[2], 0.0)))
    return bool(across <= half[0])


def _around(kind: ShapeKind, half: Array) -> float:
    match kind:
        case ShapeKind.BOX:
            return float(np.linalg.norm(half))
        case ShapeKind.SPHERE:
            return float(half[0])
        case ShapeKind.CYLINDER:
            return float(np.hypot(half[0], half[2]))
        case ShapeKind.CAPSULE:
            return float(half[0] + half[2])
