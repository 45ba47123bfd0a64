"""The shortest way of a point in the plane round squares that it cannot enter: exact.

It is a chain of straight lines between corners of the squares, found by A* among those that see
each other. What only grazes a corner counts as seen, so that no way is longer than it is.

Source: Lozano-Perez, Wesley, An algorithm for planning collision-free paths among polyhedral
obstacles, Communications of the ACM 22(10), 1979.
"""

from __future__ import annotations

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.problem.goal import angle_between

GRAZED = 1e-9  # of a cell's edge, by which a line may enter a blocked one


def shortest_path(blocked: NDArray[np.bool_], start: Array, goal: Array) -> float:
    """Return the length of the shortest way from one point to another, infinite if there is none.

    Args:
        blocked: Which unit squares cannot be entered, shape (nx, ny); all outside can.
        start: In units of a square from the corner of the first, shape (2,).
    """
    around = np.pad(blocked, 1).astype(np.uint8)
    pairs = np.stack([around[:-1, :-1], around[1:, 1:], around[1:, :-1], around[:-1, 1:]])
    count = pairs.sum(axis=0)
    # Ways bend only where one square sticks out, or two touch with their corners.
    bends = (count == 1) | ((count == 2) & (pairs[0] == pairs[1]))
    points = np.vstack([goal, np.argwhere(bends), start]).astype(float)
    far = np.linalg.norm(points - goal, axis=1)
    lengths, done = np.full(len(points), np.inf), np.zeros(len(points), dtype=bool)
    lengths[-1] = 0.0
    queue, seen = [(float(far[-1]), len(points) - 1)], np.zeros(len(points), dtype=bool)
    while queue:
        _, k = heapq.heappop(queue)
        if k == 0:
            return float(lengths[0])
        if done[k]:
            continue
        done[k] = True
        sees(around, points + 1.0, k, done, seen)
        reached = lengths[k] + np.linalg.norm(points - points[k], axis=1)
        for i in np.flatnonzero(seen & (reached < lengths)).tolist():
            lengths[i] = reached[i]
            heapq.heappush(queue, (float(reached[i] + far[i]), i))
    return math.inf


def arc_outside(start: Array, goal: Array, centre: Array, half_angle: float) -> float:
    """Return the length in [rad] of the shortest way on the unit sphere outside a cap: exact.

    Args:
        start: Unit vector (3,), outside the cap.
        centre: Of the cap, a unit vector (3,).
        half_angle: Of the cap in [rad], below pi / 2.
    """
    away = [max(float(angle_between(one, centre)), half_angle) for one in (start, goal)]
    sides = [one - np.dot(one, centre) * centre for one in (start, goal)]
    around = float(angle_between(*sides))  # seen from the centre
    straight = float(angle_between(start, goal))
    touch = [math.acos(min(math.cos(a) / math.cos(half_angle), 1.0)) for a in away]
    turned = [math.acos(min(math.tan(half_angle) / math.tan(a), 1.0)) for a in away]
    rest = around - sum(turned)
    return straight if rest <= 0.0 else sum(touch) + rest * math.sin(half_angle)


@kernel
def sees(blocked, points, k, done, seen):  # type: ignore[no-untyped-def]
    """Say which points (n, 2) one of them sees past blocked squares, but for those that are done.

    Args:
        blocked: Which squares of a grid, whose border is open, shape (nx, ny).
        points: In units of a square, shape (n, 2).
        k: Which of the points looks.
        done: Which are not looked at, shape (n,).
        seen: Written, shape (n,).
    """
    for i in range(points.shape[0]):
        seen[i] = not done[i] and line_is_open(
            blocked, points[k, 0], points[k, 1], points[i, 0], points[i, 1]
        )


@kernel
def line_is_open(blocked, x0, y0, x1, y1):  # type: ignore[no-untyped-def]
    """Say whether a line enters no blocked square by more than ``GRAZED``.

    Args:
        blocked: Which squares of a grid, shape (nx, ny).
        x0, y0: Where the line begins, in units of a square.
        x1, y1: Where it ends.
    """
    steep = abs(y1 - y0) > abs(x1 - x0)
    if steep:
        x0, y0, x1, y1 = y0, x0, y1, x1
    if x0 > x1:
        x0, y0, x1, y1 = x1, y1, x0, y0
    columns, rows = blocked.shape[0], blocked.shape[1]
    if steep:
        columns, rows = rows, columns
    slope = (y1 - y0) / (x1 - x0) if x1 > x0 else 0.0
    for c in range(max(0, math.floor(x0 + GRAZED)), min(columns, math.ceil(x1 - GRAZED))):
        a = y0 + slope * (max(x0, c) - x0)
        b = y0 + slope * (min(x1, c + 1.0) - x0)
        low, high = math.floor(min(a, b) + GRAZED), math.ceil(max(a, b) - GRAZED)
        if high <= low:  # along a line between squares, which both have to be blocked
            low, high = high - 1, low + 1
            if low < 0 or high > rows:
                continue
            if (
                (blocked[low, c] and blocked[low + 1, c])
                if steep
                else (blocked[c, low] and blocked[c, low + 1])
            ):
                return False
            continue
        for r in range(max(low, 0), min(high, rows)):
            if blocked[r, c] if steep else blocked[c, r]:
                return False
    return True
