"""Several solids around a mesh, which is cut in two again and again.

Cuts that save little are taken back, as decision trees are pruned.

Source: Breiman, Friedman, Olshen, Stone, Classification and Regression Trees, 1984, chapter 3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.robots.solids.enclosing import enclosing_shape, principal_axes
from kinolab.robots.tree.kinematic_tree import PlacedShape


@dataclass
class _Piece:
    """Triangles (n, 3, 3), the padded volume of a box around them, and their halves, if cut."""

    triangles: Array
    volume: float
    halves: tuple[_Piece, ...] = ()

    def leaves(self) -> list[_Piece]:
        """Return the pieces that are not cut."""
        if not self.halves:
            return [self]
        return [leaf for half in self.halves for leaf in half.leaves()]

    def cut_pieces(self) -> list[_Piece]:
        """Return the pieces that are cut, this one and those within it."""
        if not self.halves:
            return []
        return [self, *(piece for half in self.halves for piece in half.cut_pieces())]

    def saving(self) -> float:
        """Return the volume that each further solid within it saves, in [m^3]."""
        leaves = self.leaves()
        return (self.volume - sum(leaf.volume for leaf in leaves)) / (len(leaves) - 1)


def enclosing_solids(
    triangles: Array, within: Array, padding: float, most: int = 24
) -> list[PlacedShape]:
    """Return boxes and capsules around triangles, each around what lies on its side of cuts.

    Every point of every triangle is in one of them. What is full is not cut to save what is inside.

    Args:
        triangles: Corners, shape (n, 3, 3), in [m].
        within: Points inside the mesh, shape (m, 3), in [m].
        padding: Added to the edges of a solid, in [m]: what is flat takes room, too. The larger it
            is, the fewer solids there are, as a rule.
        most: Solids that are returned at most.
    """
    triangles = np.concatenate([triangles, np.repeat(within[:, None], 3, axis=1)])
    whole = _cut_up(triangles, padding, 6)  # of cuts within cuts
    while cut := whole.cut_pieces():
        weakest = min(cut, key=_Piece.saving)
        leaves = whole.leaves()
        volume = sum(leaf.volume for leaf in leaves)
        # 0.01 of the volume of all solids, by every further one
        if len(leaves) <= most and weakest.saving() > 0.01 * volume:
            break
        weakest.halves = ()
    return [enclosing_shape(leaf.triangles.reshape(-1, 3)) for leaf in whole.leaves()]


def _cut_up(triangles: Array, padding: float, depth: int) -> _Piece:
    """Return triangles (n, 3, 3) as a piece that is cut so many times within itself."""
    turns = (np.eye(3), principal_axes(triangles.reshape(-1, 3)))
    piece = _Piece(triangles, min(_padded_volume(triangles @ turn, padding) for turn in turns))
    if depth == 0 or piece.volume <= (3.0 * padding) ** 3:
        return piece
    turn, axis, at = _best_cut(triangles, turns, padding)
    halves = [half @ turn.T for half in _cut(triangles @ turn, axis, at) if len(half)]
    if len(halves) == 2:
        piece.halves = tuple(_cut_up(half, padding, depth - 1) for half in halves)
    return piece


def _best_cut(
    triangles: Array, turns: tuple[Array, ...], padding: float
) -> tuple[Array, int, float]:
    """Return where to cut triangles (n, 3, 3): along which column of which rotation, and at what.

    That is where the boxes around both halves are smallest together; of cuts that save nothing, it
    is the one through the middle of the longest side.
    """
    # 1000 triangles that say where to cut; all are cut there
    looked_at = triangles[:: 1 + len(triangles) // 1000]
    turned = turns[-1]
    corners = (looked_at @ turned).reshape(-1, 3)
    longest = int(np.ptp(corners, axis=0).argmax())
    middle = float(corners[:, longest].min() + np.ptp(corners[:, longest]) / 2)
    best, found = float("inf"), (turned, longest, middle)
    whole = min(_padded_volume(looked_at @ turn, padding) for turn in turns)
    real = (looked_at[:, 0] != looked_at[:, 1]).any(axis=1)  # and no point inside
    for turn in turns:
        own = looked_at @ turn
        for axis in range(3):
            for at in _places(own[..., axis], real):
                left = sum(_padded_volume(half, padding) for half in _cut(own, axis, at))
                if left < min(best, whole):
                    best, found = left, (turn, axis, float(at))
    return found


def _padded_volume(triangles: Array, padding: float) -> float:
    """Return the volume of the box around triangles (n, 3, 3) along the axes, padded."""
    return float((np.ptp(triangles.reshape(-1, 3), axis=0) + padding).prod())


def _places(coordinates: Array, real: NDArray[np.bool_]) -> Array:
    """Return where cuts may be along an axis: at corners, or evenly where there are many.

    Args:
        coordinates: Of corners, shape (n, 3).
        real: Which are those of triangles, shape (n,).
    """
    low, high = coordinates.min(), coordinates.max()
    distinct = np.unique(np.round([low, *coordinates[real].reshape(-1), high], 9))
    even = np.linspace(low, high, 9 + 2)  # places of a cut along each axis, between the ends
    # 12 coordinates of corners that are tried as such; more are taken evenly
    return (distinct if len(distinct) <= 12 else even)[1:-1]


def _cut(triangles: Array, axis: int, at: float) -> tuple[Array, Array]:
    """Cut triangles (n, 3, 3) by the plane at a coordinate, and return those below and above."""
    above = triangles[..., axis] > at
    count = above.sum(axis=1)
    below_all, above_all = triangles[count == 0], triangles[count == 3]
    crossing, sides, ones = (
        part[(count == 1) | (count == 2)] for part in (triangles, above, count)
    )
    lone = np.where(ones[:, None] == 1, sides, ~sides).argmax(axis=1)  # on its side by itself
    order = (lone[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(crossing, order[..., None], axis=1).swapaxes(0, 1)
    p, q = _between(a, b, axis, at), _between(a, c, axis, at)
    tips = np.stack([a, p, q], axis=1)
    rests = np.concatenate([np.stack([p, b, c], axis=1), np.stack([p, c, q], axis=1)])
    up, twice = ones == 1, np.concatenate([ones == 1] * 2)
    return (
        np.concatenate([below_all, tips[~up], rests[twice]]),
        np.concatenate([above_all, tips[up], rests[~twice]]),
    )


def _between(start: Array, end: Array, axis: int, at: float) -> Array:
    """Return where edges from points (n, 3) to points (n, 3) cross a plane, shape (n, 3)."""
    share = (at - start[:, axis]) / (end[:, axis] - start[:, axis])
    found = start + share[:, None] * (end - start)
    found[:, axis] = at
    return found
