"""Reeds-Shepp and Dubins curves from OMPL, decomposed into arcs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from math import copysign, cos, sin
from typing import Any, TypeAlias

import numpy as np

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.numerics.arrays import Array

PlanePose: TypeAlias = tuple[float, float, float]  # x, y in [m], heading in [rad]

KINDS = [(gear, side) for gear in (1, -1) for side in (0, 1, -1)]


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

    def continues(self, other: Arc) -> bool:
        """Say whether another arc has the same curvature and direction."""
        return self.curvature == other.curvature and self.length * other.length > 0

    def longer(self, by: float) -> Arc:
        """Return the arc extended by a length in [m]."""
        return Arc(self.length + copysign(by, self.length), self.curvature)

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
    pieces = _Curve(begin, end, radius, backward=backward).arcs()
    whole = _merged(pieces, lambda last, arc: last.continues(arc))
    # A bisection interval across a junction may pass for a third, tiny arc.
    # 1e-6 [m] below which an arc is dropped
    found = _merged(whole, lambda _, arc: abs(arc.length) <= 1e-6)
    return [arc for arc in found if abs(arc.length) > 1e-6]


def _merged(arcs: Iterable[Arc], belongs: Callable[[Arc, Arc], bool]) -> list[Arc]:
    """Merge each arc that belongs to its predecessor into it."""
    found: list[Arc] = []
    for arc in arcs:
        if found and belongs(found[-1], arc):
            found[-1] = found[-1].longer(abs(arc.length))
        else:
            found.append(arc)
    return found


def lengths(poses: Sequence[PlanePose], radius: float, *, backward: bool = True) -> Array:
    """Return the lengths of the shortest curves between all poses in [m], shape (n, n).

    Args:
        poses: Of which each is a beginning and an end.
        radius: Minimum turning radius in [m].
        backward: As for ``arcs``.
    """
    space = _space(radius, backward)
    states = [_state(space, pose) for pose in poses]
    return np.array([[space.distance(a, b) for b in states] for a in states])


@lru_cache(maxsize=8)
def _space(radius: float, backward: bool) -> Any:
    import ompl.base  # late: machines that are not cars need none

    space = (ompl.base.ReedsSheppStateSpace if backward else ompl.base.DubinsStateSpace)(radius)
    bounds = ompl.base.RealVectorBounds(2)
    bounds.setLow(-1e6)  # [m] bounds that OMPL requires
    bounds.setHigh(1e6)
    space.setBounds(bounds)
    return space


def _state(space: Any, pose: PlanePose) -> Any:
    state, (x, y, heading) = space.allocState(), pose
    state.setXY(x, y)
    state.setYaw(heading)
    return state


class _Curve:
    """An OMPL curve, which exposes poses but not arcs."""

    def __init__(self, begin: PlanePose, end: PlanePose, radius: float, *, backward: bool) -> None:
        self._space = _space(radius, backward)
        self._begin, self._end, self._here = (
            _state(self._space, pose) for pose in (begin, end, begin)
        )
        self.length, self._radius = float(self._space.distance(self._begin, self._end)), radius
        self.size = max(self.length, radius, *map(abs, (*begin[:2], *end[:2])))

    def pose(self, fraction: float) -> PlanePose:
        """Return the pose at a fraction of the length."""
        self._space.interpolate(self._begin, self._end, fraction, self._here)
        return self._here.getX(), self._here.getY(), self._here.getYaw()

    def arcs(self) -> Iterator[Arc]:
        """Yield its arcs, by bisection until each interval is a single one."""
        yield from self._between(0.0, 1.0, self.pose(0.0), self.pose(1.0))

    def _between(
        self, begin: float, end: float, before: PlanePose, after: PlanePose
    ) -> Iterator[Arc]:
        arc = self._single((end - begin) * self.length, before, after)
        if arc is not None:
            yield arc
        elif end - begin > 2.0**-40:  # fraction of a curve that is not bisected further
            middle = (begin + end) / 2
            half = self.pose(middle)
            yield from self._between(begin, middle, before, half)
            yield from self._between(middle, end, half, after)

    def _single(self, length: float, before: PlanePose, after: PlanePose) -> Arc | None:
        """Return the single arc of a length between two poses, or None."""
        for gear, side in KINDS:
            arc = Arc(gear * length, side / self._radius)
            x, y, heading = arc.after(before)
            turned = float(wrapped(heading - after[2]))
            off = max(abs(x - after[0]), abs(y - after[1]), abs(turned) * self._radius)
            # 1e-12 relative to the curve's size: how far a pose may be off its arc
            if off <= 1e-12 * self.size:
                return arc
        return None
