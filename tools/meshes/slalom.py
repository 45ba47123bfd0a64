"""Courses between barriers that reach out from alternate sides, a pole at every end; z up, [m].

| file                | for          | length | half width | barriers at x | way past each |
|---------------------|--------------|--------|------------|---------------|---------------|
| disk_slalom.stl     | falling disk | 15     | 2.6        | 3.5, 7, 10.5  | 2.2           |
| unicycle_slalom.stl | unicycle     | 7.6    | 1.3        | 2, 3.8, 5.6   | 1.1           |
| chicane.stl         | motorcycle   | 110    | 8.0        | 30, 55, 80    | 6.5           |

A barrier leaves the way open on one side; the next one leaves it open on the other. The kerbs along
both sides end the course.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from solids import Array, Solid, bent, block, box, cylinder, join, loft, tube, turned


@dataclass(frozen=True)
class Course:
    """The measures of a course, in [m].

    Attributes:
        length: Along x, from 0.
        half: From the middle to the kerb on either side.
        barriers: Where barriers stand; the first one reaches out from the right.
        reach: How far a barrier reaches beyond the middle.
        height: Of a barrier.
        thickness: Of a barrier.
    """

    length: float
    half: float
    barriers: tuple[float, ...]
    reach: float
    height: float
    thickness: float


DISK = Course(15.0, 2.6, (3.5, 7.0, 10.5), 0.4, 0.5, 0.16)
ONE_WHEEL = Course(7.6, 1.3, (2.0, 3.8, 5.6), 0.2, 0.25, 0.08)
CHICANE = Course(110.0, 8.0, (30.0, 55.0, 80.0), 1.5, 0.9, 0.6)


def disk_slalom() -> Solid:
    """Return low walls with poles at their ends."""
    return _course(DISK, _wall)


def unicycle_slalom() -> Solid:
    """Return the same, for a machine of half a metre that turns more tightly."""
    return _course(ONE_WHEEL, _wall)


def chicane() -> Solid:
    """Return barriers of concrete across a road, tyres at their ends, kerbs along it."""
    return join([_course(CHICANE, _concrete), *_tyres(CHICANE)])


def _course(course: Course, barrier: Callable[[Course, int], Solid]) -> Solid:
    return join([*_kerbs(course), *(barrier(course, k) for k in range(len(course.barriers)))])


def _kerbs(course: Course) -> list[Solid]:
    """Return a kerb along either side and one across either end."""
    t, h = course.thickness, 0.4 * course.height
    long = [
        block(
            (-t, course.length + t),
            tuple(sorted((side * course.half, side * (course.half + t)))),
            (0.0, h),
            0.1 * t,
        )
        for side in (-1, 1)
    ]
    across = [
        block((x - t, x), (-course.half, course.half), (0.0, h), 0.1 * t)
        for x in (0.0, course.length + t)
    ]
    return [*long, *across]


def _ends(course: Course, k: int) -> tuple[float, float, float]:
    """Return x of a barrier, y where it begins at the kerb and y where it ends."""
    side = -1.0 if k % 2 == 0 else 1.0
    return course.barriers[k], side * course.half, -side * course.reach


def _wall(course: Course, k: int) -> Solid:
    """Return a plank with a rail above it and a pole at its end."""
    x, begin, end = _ends(course, k)
    t, h = course.thickness, course.height
    plank = block((x - t / 2, x + t / 2), tuple(sorted((begin, end))), (0.0, h), 0.15 * t)
    pole = cylinder(0.55 * t, (0.0, 2.2 * h), 24, 0.1 * t).moved(x, end)
    knob = turned([(r * t, 2.2 * h + z * t) for r, z in _ball()], 24).moved(x, end)
    rail = tube([(x, begin, 1.5 * h), (x, end, 1.5 * h)], 0.2 * t, 12)
    return join([plank, pole, knob, rail])


def _ball() -> list[tuple[float, float]]:
    angle = np.linspace(-np.pi / 2, np.pi / 2, 9)
    return [(0.8 * np.cos(a), 0.8 * np.sin(a) + 0.6) for a in angle]


def _concrete(course: Course, k: int) -> Solid:
    """Return a barrier that is broad at its foot, lofted along y."""
    x, begin, end = _ends(course, k)
    t, h = course.thickness, course.height
    half = [(0.5 * t, 0.0), (0.5 * t, 0.1 * h), (0.28 * t, 0.4 * h), (0.2 * t, h)]
    profile = [*half, *[(-a, z) for a, z in half[::-1]]]
    rings: Array = np.array(
        [[(x + a, y, z) for a, z in profile] for y in np.linspace(begin, end, 12)]
    )
    return loft(rings)


def _tyres(course: Course) -> list[Solid]:
    """Return a stack of tyres at the end of every barrier, and an arch over the start."""
    parts = []
    for k in range(len(course.barriers)):
        x, _, end = _ends(course, k)
        for n in range(3):
            z = 0.25 * n  # a gap between tyres
            ring = turned([(0.33, z), (0.4, z + 0.05), (0.4, z + 0.19), (0.33, z + 0.24)], 24)
            parts.append(ring.moved(x, end + np.sign(end) * 0.2))
    posts = [box((0.3, 0.3, 5.0), (6.0, side * (course.half - 0.3), 0.0)) for side in (-1, 1)]
    half = course.half - 0.3
    beam = tube(
        bent([(6.0, -half, 4.0), (6.0, -half, 5.2), (6.0, half, 5.2), (6.0, half, 4.0)], 0.8), 0.25
    )
    return [*parts, *posts, beam]


MESHES = {
    "chicane.stl": chicane,
    "disk_slalom.stl": disk_slalom,
    "unicycle_slalom.stl": unicycle_slalom,
}
