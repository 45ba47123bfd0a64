"""Steering along plane curves: quintic Hermite, Reeds-Shepp, and turns on the spot."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from typing import final

import numpy as np

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.dynamics.facts.machine_facts import FlatFacts
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.steering.path_motion import AbstractPathFamily, Path, SampledPath
from kinolab.steering.reeds_shepp import Arc, PlanePose, arcs

CURVE_SAMPLES = 120  # of a smooth curve
CURVATURE_FRACTION = 0.9  # fraction of the largest curvature that curves use
MIN_LENGTH = 1e-6  # [m] or [rad] below which no motion is made
FORWARD, BACKWARD = GEARS = 1.0, -1.0


@final
class PlanePaths(AbstractPathFamily):
    """Paths along plane curves.

    Candidates in order: smooth curves forward and backward (quintic Hermite polynomials with zero
    curvature at both ends); then turn-drive-turn if the machine turns on the spot, otherwise the
    shortest curve of arcs and straight lines, with a stop wherever the steering must change. A pose
    is an array: x, y in [m], heading in [rad] and the steered coordinates, shape (3 + steered,).

    Source: Reeds, Shepp, Optimal paths for a car that goes both forwards and backwards, Pacific J.
    Mathematics 145(2), 1990; Laumond (ed.), Robot Motion Planning and Control, 1998, chapter 1.
    """

    def __init__(self, problem: PlanningTask, flat: FlatFacts) -> None:
        self._flat, self._steers = flat, bool(flat.steered)
        self.coordinates = flat.coordinates
        self._index = [problem.model.coordinate_names.index(name) for name in flat.coordinates]
        self._sharpest = _sharpest(problem, flat)

    @property
    def radius(self) -> float:
        """Minimum turning radius in [m]; 0 if the machine turns on the spot."""
        return 1.0 / (CURVATURE_FRACTION * self._sharpest) if self._steers else 0.0

    def straightened(self, x: Array) -> Array:
        """Return the state, shape (nx,), with the steering straight."""
        straight = x.copy()
        straight[self._index[3:]] = self._steered(np.zeros(1))[0]
        return straight

    def paths(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield sequences of paths from x0 to x1, shape (nx,), with a stop after each path."""
        begin, end = x0[self._index], x1[self._index]
        straight = self.straightened(x0)[self._index]
        for path in self._smooth(straight, end):
            yield [*self._shifts([begin, straight]), path]
        if self._steers:
            yield self._reeds_shepp(begin, end)[0]
        else:
            for gear in GEARS:
                yield self._turn_go_turn(begin, end, gear)

    def detours(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield paths with a straight final approach, for ends without clearance to turn."""
        begin, end = x0[self._index], x1[self._index]
        if not self._steers or _distance(begin, end) < MIN_LENGTH:
            return
        straight, heading = self._steered(np.zeros(1))[0], end[2]
        # Lengths of a straight final approach, in minimum turning radii
        for lead in (0.25, 0.5, 1.0):
            for gear in GEARS:
                back = gear * lead * self.radius
                before = end[:2] - back * np.array([np.cos(heading), np.sin(heading)])
                paths, gate = self._reeds_shepp(begin, np.array([*before, heading, *straight]))
                there = np.array([*end[:2], gate[2], *straight])
                arrived = np.array([*end[:2], gate[2], *end[3:]])
                yield [*paths, *self._shifts([gate, there, arrived])]

    def _smooth(self, begin: Array, end: Array) -> Iterator[Path]:
        """Yield quintic curves by arc length, but none that is too sharp."""
        distance = _distance(begin, end)
        if distance < MIN_LENGTH:
            return
        headings = np.array([begin[2], end[2]])
        towards = np.column_stack([np.cos(headings), np.sin(headings)])
        # Tangent lengths of a smooth curve, in distances between its ends.
        pace = np.array([[gear * reach * distance] for reach in (0.7, 1.2) for gear in GEARS])
        ends = np.broadcast_to([begin[:2], end[:2]], (len(pace), 2, 2))
        weights = np.concatenate([ends, pace[:, :, None] * towards], axis=1)
        point, slope, bend = (table @ weights for table in _hermite_basis())
        speed = np.hypot(slope[..., 0], slope[..., 1])
        turning = slope[..., 0] * bend[..., 1] - slope[..., 1] * bend[..., 0]
        curvature = np.sign(pace) * turning / speed**3
        wide = (np.abs(curvature) <= CURVATURE_FRACTION * self._sharpest).all(axis=1)
        for k in np.flatnonzero(wide):
            course = np.sign(pace[k]) * slope[k].T
            heading = np.unwrap(np.arctan2(course[1], course[0]))
            heading += begin[2] - heading[0]
            steered = self._steered(curvature[k])
            off = np.abs([steered[0] - begin[3:], steered[-1] - end[3:]])
            if off.max(initial=0.0) > MIN_LENGTH:
                continue  # the steering would have to jump
            gone = np.concatenate([[0.0], np.cumsum((speed[k, 1:] + speed[k, :-1]) / 2)])
            poses = np.column_stack([point[k], heading, steered])
            yield SampledPath(gone / gone[-1], poses)

    def _steered(self, curvature: Array) -> Array:
        if not self._steers:
            return np.empty((len(curvature), 0))
        return np.column_stack(_steered_at(self._flat, curvature))

    def _turn_go_turn(self, begin: Array, end: Array, gear: float) -> list[Path]:
        path = end[:2] - begin[:2]
        if _distance(begin, end) < MIN_LENGTH:
            return self._shifts([begin, _turned(begin, end[2])])
        course = _nearest(float(np.arctan2(*(gear * path[::-1]))), begin[2])
        there = np.array([*end[:2], course])
        return [
            *self._shifts([begin, _turned(begin, course)]),
            _straight(_turned(begin, course), there),
            *self._shifts([there, _turned(there, end[2])]),
        ]

    def _shifts(self, poses: list[Array]) -> list[Path]:
        """Return straight paths between consecutive poses, skipping coincident ones."""
        return [_straight(a, b) for a, b in pairwise(poses) if _apart(a, b)]

    def _reeds_shepp(self, begin: Array, end: Array) -> tuple[list[Path], Array]:
        """Return arcs with steering changes at stops between them, and the final pose."""
        paths, here = [], begin
        for arc in arcs(_in_plane(begin), _in_plane(end), self.radius):
            steered = self._steered(np.array([arc.curvature]))[0]
            ready = np.array([*here[:3], *steered])
            there = np.array([*arc.after(_in_plane(here)), *steered])
            paths += [*self._shifts([here, ready]), _around(ready, arc)]
            here = there
        arrived = np.array([*here[:3], *end[3:]])
        return [*paths, *self._shifts([here, arrived])], arrived


def _sharpest(problem: PlanningTask, flat: FlatFacts) -> float:
    """Return the largest curvature in [1/m] within the steering limits."""
    curvatures = np.geomspace(1e-3, 20.0, 400)  # [1/m] for machines that turn on the spot
    possible = np.ones(len(curvatures), dtype=bool)
    for sign in (1.0, -1.0) if flat.steered else ():
        angles = _steered_at(flat, sign * curvatures)
        for name, values in zip(flat.steered, angles, strict=True):
            lower, upper = problem.bounds[problem.model.state_names.index(name)]
            possible &= (lower <= values) & (values <= upper)
    return float(curvatures[possible].max(initial=1e-3))


def _steered_at(flat: FlatFacts, curvature: Array) -> list[Array]:
    """Return what each steered coordinate is where a curve has curvatures (m,) in [1/m]."""
    found = flat.determined({"curvature": curvature})
    return [np.broadcast_to(angles, curvature.shape) for angles in found]


@cache
def _hermite_basis() -> tuple[Array, Array, Array]:
    """Return the quintics of unit ends or tangents, and two derivatives, at even samples.

    Their second derivatives are zero at both ends. The shape of each is (CURVE_SAMPLES, 4).
    """
    basis = np.array(
        [[1, 0, 0, -10, 15, -6], [0, 0, 0, 10, -15, 6], [0, 1, 0, -6, 8, -3], [0, 0, 0, -4, 7, -3]],
        dtype=float,
    )
    powers = np.vander(np.linspace(0.0, 1.0, CURVE_SAMPLES), 6, increasing=True)
    first = np.column_stack([np.zeros(CURVE_SAMPLES), *((k + 1) * powers[:, k] for k in range(5))])
    second = np.column_stack([np.zeros(CURVE_SAMPLES), *((k + 1) * first[:, k] for k in range(5))])
    return powers @ basis.T, first @ basis.T, second @ basis.T


def _in_plane(pose: Array) -> PlanePose:
    x, y, heading = pose[:3].tolist()
    return x, y, heading


def _distance(begin: Array, end: Array) -> float:
    return float(np.hypot(*(end - begin)[:2]))


def _straight(begin: Array, end: Array) -> Path:
    return lambda s, _rate, _slope: begin + s[:, None] * (end - begin)


def _around(begin: Array, arc: Arc) -> Path:
    def path(s: Array, _rate: Array, _slope: Array) -> Array:
        poses = np.column_stack(arc.poses(_in_plane(begin), s))
        return np.hstack([poses, np.tile(begin[3:], (len(s), 1))])

    return path


def _turned(pose: Array, heading: float) -> Array:
    return np.array([*pose[:2], _nearest(heading, pose[2]), *pose[3:]])


def _nearest(angle: float, other: float) -> float:
    """Unwrap an angle in [rad] to the branch nearest to another one."""
    return float(other + wrapped(angle - other))


def _apart(a: Array, b: Array) -> bool:
    return float(np.abs(a - b)[2:].max()) > MIN_LENGTH or _distance(a, b) > MIN_LENGTH
