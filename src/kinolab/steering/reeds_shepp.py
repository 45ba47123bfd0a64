"""The shortest curves of arcs and straight lines, as OMPL knows them, arc by arc."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from math import copysign, cos, sin
from typing import Any, TypeAlias

import numpy as np
from ompl import base as ob

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array

PlanePose: TypeAlias = tuple[float, float, float]  # x, y in [m], heading in [rad]

# of all lengths at hand: by how much a pose may be off the arc that it is on
POSE_TOLERANCE = 1e-12
MIN_INTERVAL = 2.0**-40  # share of a curve that is not looked into any more
KINDS = [(gear, side) for gear in (1, -1) for side in (0, 1, -1)]
WORLD_EXTENT = 1e6  # [m] that OMPL wants to be told of
MIN_ARC_LENGTH = 1e-6  # [m] of an arc that is worth a motion


@dataclass(frozen=True)
class Arc:
    """A piece of constant curvature.

    Attributes:
        length: In [m]; negative where it is driven backward.
        curvature: In [1/m], positive to the left of the heading; 0 for a straight line.
    """

    length: float
    curvature: float

    def poses(self, begin: PlanePose, fraction: Array) -> tuple[Array, Array, Array]:
        """Return x, y and heading at shares of the arc's length."""
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

    def continues(self, other: Arc) -> bool:
        """Say whether another arc goes on as this one goes."""
        return self.curvature == other.curvature and self.length * other.length > 0

    def longer(self, by: float) -> Arc:
        """Return the arc made longer, in [m]."""
        return Arc(self.length + copysign(by, self.length), self.curvature)

    def after(self, begin: PlanePose) -> PlanePose:
        """Return the pose at its end."""
        x, y, heading = begin
        turned = heading + self.curvature * self.length
        if self.curvature == 0.0:
            return x + self.length * cos(heading), y + self.length * sin(heading), turned
        r = 1.0 / self.curvature
        return x + r * (sin(turned) - sin(heading)), y - r * (cos(turned) - cos(heading)), turned


def arcs(begin: PlanePose, end: PlanePose, radius: float, *, backward: bool = True) -> list[Arc]:
    """Return the shortest curve between two poses for a car of a turning radius in [m].

    Args:
        begin: Where it starts.
        end: Where it ends.
        radius: Of the tightest circle.
        backward: Whether it may go back (Reeds and Shepp), or not (Dubins).
    """
    pieces = _Curve(begin, end, radius, backward=backward).arcs()
    whole = _merged(pieces, lambda last, arc: last.continues(arc))
    # Where two arcs meet, a piece of both may pass for a third one.
    found = _merged(whole, lambda _, arc: abs(arc.length) <= MIN_ARC_LENGTH)
    return [arc for arc in found if abs(arc.length) > MIN_ARC_LENGTH]


def _merged(arcs: Iterable[Arc], belongs: Callable[[Arc, Arc], bool]) -> list[Arc]:
    """Return arcs with those that belong to the one before made part of it."""
    found: list[Arc] = []
    for arc in arcs:
        if found and belongs(found[-1], arc):
            found[-1] = found[-1].longer(abs(arc.length))
        else:
            found.append(arc)
    return found


class _Curve:
    """A curve of OMPL's, which tells its poses but not its arcs."""

    def __init__(self, begin: PlanePose, end: PlanePose, radius: float, *, backward: bool) -> None:
        self._space: Any = (
            ob.ReedsSheppStateSpace(radius) if backward else ob.DubinsStateSpace(radius)
        )
        bounds = ob.RealVectorBounds(2)
        bounds.setLow(-WORLD_EXTENT)
        bounds.setHigh(WORLD_EXTENT)
        self._space.setBounds(bounds)
        self._begin, self._end, self._here = (self._space.allocState() for _ in range(3))
        for state, (x, y, heading) in ((self._begin, begin), (self._end, end)):
            state.setXY(x, y)
            state.setYaw(heading)
        self.length, self._radius = float(self._space.distance(self._begin, self._end)), radius
        self.size = max(self.length, radius, *map(abs, (*begin[:2], *end[:2])))

    def pose(self, fraction: float) -> PlanePose:
        """Return the pose at a share of the length."""
        self._space.interpolate(self._begin, self._end, fraction, self._here)
        return self._here.getX(), self._here.getY(), self._here.getYaw()

    def arcs(self) -> Iterator[Arc]:
        """Yield its arcs, cut in half until each piece is a single one."""
        yield from self._between(0.0, 1.0, self.pose(0.0), self.pose(1.0))

    def _between(
        self, begin: float, end: float, before: PlanePose, after: PlanePose
    ) -> Iterator[Arc]:
        arc = self._single((end - begin) * self.length, before, after)
        if arc is not None:
            yield arc
        elif end - begin > MIN_INTERVAL:
            middle = (begin + end) / 2
            half = self.pose(middle)
            yield from self._between(begin, middle, before, half)
            yield from self._between(middle, end, half, after)

    def _single(self, length: float, before: PlanePose, after: PlanePose) -> Arc | None:
        """Return the arc of a length from one pose to another; None where no single one leads."""
        for gear, side in KINDS:
            arc = Arc(gear * length, side / self._radius)
            x, y, heading = arc.after(before)
            turned = float(wrapped(heading - after[2]))
            off = max(abs(x - after[0]), abs(y - after[1]), abs(turned) * self._radius)
            if off <= POSE_TOLERANCE * self.size:
                return arc
        return None
