"""Curves of Reeds and Shepp, and of Dubins, as arcs in [m]."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import TypeAlias

import numpy as np

from kinolab.numerics.arrays import Array, allocate
from kinolab.numerics.struct import Record
from kinolab.steering.arc_words import ArcWord, shortest_word

PlanePose: TypeAlias = tuple[float, float, float]  # x, y in [m], heading in [rad]


@dataclass(frozen=True)
class Arc:
    """A segment of constant curvature.

    Attributes:
        length: In [m]; negative if driven backward.
        curvature: In [1/m], positive to the left of the heading; 0 for a straight line.
    """

    length: float
    curvature: float

    def poses(self, begin: PlanePose, fraction: Array) -> tuple[Array, Array, Array]:
        """Return x, y and heading at fractions of the arc's length, shape (m,) each."""
        x, y, heading = begin
        gone = fraction * self.length
        turned = heading + self.curvature * gone
        if self.curvature == 0.0:
            return x + gone * np.cos(heading), y + gone * np.sin(heading), turned
        r = 1.0 / self.curvature
        return (
            x + r * (np.sin(turned) - np.sin(heading)),
            y - r * (np.cos(turned) - np.cos(heading)),
            turned,
        )

    def after(self, begin: PlanePose) -> PlanePose:
        """Return the pose at its end, from the one at its beginning."""
        x, y, heading = begin
        turned = heading + self.curvature * self.length
        if self.curvature == 0.0:
            return x + self.length * cos(heading), y + self.length * sin(heading), turned
        r = 1.0 / self.curvature
        return x + r * (sin(turned) - sin(heading)), y - r * (cos(turned) - cos(heading)), turned


def arcs(begin: PlanePose, end: PlanePose, radius: float, *, backward: bool = True) -> list[Arc]:
    """Return the shortest curve between two poses for a car.

    Args:
        end: End pose.
        radius: Minimum turning radius in [m].
        backward: Whether it may reverse (Reeds-Shepp) or not (Dubins).
    """
    word, found = allocate(ArcWord, {}), list[Arc]()
    ends = np.array([begin, end], dtype=float)
    shortest_word(Record(word), *ends, float(radius), backward)
    for length, side in zip(word.length[: word.size[0]].tolist(), word.side.tolist(), strict=False):
        arc = Arc(length * radius, side / radius)
        if abs(arc.length) <= 1e-6:  # [m] below which an arc is dropped
            continue
        if found and found[-1].curvature == arc.curvature and found[-1].length * arc.length > 0.0:
            arc = Arc(found.pop().length + arc.length, arc.curvature)  # it goes on alike
        found.append(arc)
    return found


def lengths(poses: Sequence[PlanePose], radius: float, *, backward: bool = True) -> Array:
    """Return the lengths of the shortest curves between all poses in [m], shape (n, n).

    Args:
        poses: Of which each is a beginning and an end.
        radius: Minimum turning radius in [m].
        backward: As for ``arcs``.
    """
    word, ends = Record(allocate(ArcWord, {})), np.array(poses, dtype=float)
    rows = [[shortest_word(word, a, b, float(radius), backward) for b in ends] for a in ends]
    return np.array(rows)
