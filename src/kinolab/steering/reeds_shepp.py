"""The shortest curves of arcs and straight lines, as OMPL knows them, arc by arc."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from ompl import base as ob

Array: TypeAlias = NDArray[np.float64]
PlanePose: TypeAlias = tuple[float, float, float]  # x, y in [m], heading in [rad]

LOOKS = 240  # along a curve, to tell its arcs apart
NEAR = 1e-5  # of a curve's length, over which its kind is looked at
HALVINGS = 40  # to find where one arc ends and the next begins
WORLD = 1e6  # [m] that OMPL wants to be told of
SHORTEST = 1e-6  # [m] of an arc


@dataclass(frozen=True)
class Arc:
    """A piece of constant curvature.

    Attributes:
        length: In [m]; negative where it is driven backward.
        curvature: In [1/m], positive to the left of the heading; 0 for a straight line.
    """

    length: float
    curvature: float

    def poses(self, begin: PlanePose, share: Array) -> tuple[Array, Array, Array]:
        """Return x, y and heading at shares of the arc's length."""
        x, y, heading = begin
        gone = share * self.length
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
        """Return the pose at its end."""
        x, y, heading = (float(values[0]) for values in self.poses(begin, np.ones(1)))
        return x, y, heading


def arcs(begin: PlanePose, end: PlanePose, radius: float, *, backward: bool = True) -> list[Arc]:
    """Return the shortest curve between two poses for a car of a turning radius in [m].

    Args:
        begin: Where it starts.
        end: Where it ends.
        radius: Of the tightest circle.
        backward: Whether it may go back (Reeds and Shepp), or not (Dubins).
    """
    curve = _Curve(begin, end, radius, backward=backward)
    edges, kinds = [0.0], [curve.kind(0.0)]
    looks = np.linspace(0.0, 1.0 - 2 * NEAR, LOOKS)
    for before, look in pairwise(looks.tolist()):
        if curve.kind(look) != kinds[-1]:
            edges.append(_edge(curve.kind, before, look))
            kinds.append(curve.kind(look))
    lengths = np.diff([*edges, 1.0]) * curve.length
    found = [
        Arc(float(length) * gear, bend / radius)
        for length, (gear, bend) in zip(lengths, kinds, strict=True)
    ]
    return [arc for arc in found if abs(arc.length) > SHORTEST]


def _edge(kind: Callable[[float], tuple[int, int]], before: float, after: float) -> float:
    """Return where a curve stops being of the kind that it has before."""
    first = kind(before)
    for _ in range(HALVINGS):
        middle = (before + after) / 2
        before, after = (middle, after) if kind(middle) == first else (before, middle)
    return (before + after) / 2


class _Curve:
    """A curve of OMPL's, which tells its poses but not its arcs."""

    def __init__(self, begin: PlanePose, end: PlanePose, radius: float, *, backward: bool) -> None:
        self._space: Any = (
            ob.ReedsSheppStateSpace(radius) if backward else ob.DubinsStateSpace(radius)
        )
        bounds = ob.RealVectorBounds(2)
        bounds.setLow(-WORLD)
        bounds.setHigh(WORLD)
        self._space.setBounds(bounds)
        self._begin, self._end, self._here = (self._space.allocState() for _ in range(3))
        for state, (x, y, heading) in ((self._begin, begin), (self._end, end)):
            state.setXY(x, y)
            state.setYaw(heading)
        self.length, self._radius = float(self._space.distance(self._begin, self._end)), radius

    def pose(self, share: float) -> PlanePose:
        """Return the pose at a share of the length."""
        self._space.interpolate(self._begin, self._end, share, self._here)
        return self._here.getX(), self._here.getY(), self._here.getYaw()

    def kind(self, share: float) -> tuple[int, int]:
        """Return the gear, 1 or -1, and the side to which it bends, -1, 0 or 1."""
        (x0, y0, a), (x1, y1, b) = self.pose(share), self.pose(share + NEAR)
        ahead = (x1 - x0) * np.cos(a) + (y1 - y0) * np.sin(a)
        gear = 1 if ahead > 0 else -1
        turned = (b - a + np.pi) % (2 * np.pi) - np.pi
        bend = turned * self._radius / (NEAR * self.length) * gear
        return gear, round(float(bend)) if abs(bend) <= 1.5 else int(np.sign(bend))
