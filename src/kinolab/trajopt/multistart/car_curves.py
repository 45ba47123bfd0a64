"""Motions of cars along curves of Dubins, Reeds and Shepp: the shortest, and chains of them.

In the open the shortest curve is the quickest motion there is. Round obstacles a lazy roadmap joins
random poses by such curves, which random shortcuts then make fewer and shorter. Either is a motion
of the machine as it is, with arcs that end when they should.

Source: Svestka, Overmars, Motion planning for car-like robots using a probabilistic learning
approach, IJRR 16(2), 1997 (roadmaps of curves).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from itertools import pairwise

import numpy as np

from kinolab.concurrency.cancel import CancelledError
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.steering.bounded_curvature import CurvatureCar
from kinolab.steering.reeds_shepp import Arc, PlanePose
from kinolab.trajectory import Trajectory
from kinolab.trajopt.multistart.geometric_path import GeometricPaths
from kinolab.trajopt.multistart.lazy_roadmap import (
    LazyRoadmap,
    free_states,
    prm_star_neighbours,
)
from kinolab.trajopt.multistart.switching_times import motion_along
from kinolab.trajopt.nlp.options import GUESS
from kinolab.trajopt.nlp.problem import TrajectoryProblem

LENGTH_SECONDS, CURVE_SECONDS = 4e-6, 1e-3  # [s] of work for a curve's length, and for its arcs


class CarCurves:
    """Motions of a car along its shortest curves.

    Args:
        cancelled: Whether to give up.
        below: Duration in [s] that motions must be shorter than.
    """

    def __init__(
        self,
        problem: PlanningTask,
        car: CurvatureCar,
        generator: np.random.Generator,
        cancelled: Callable[[], bool],
        below: float = np.inf,
    ) -> None:
        self._problem, self._car, self._generator = problem, car, generator
        self._cancelled, self._below = cancelled, below
        self._paths = GeometricPaths(problem, generator, cancelled)
        self._task = TrajectoryProblem(problem, 0.0, cancelled=cancelled)
        self._ends = np.stack([problem.start, problem.goal.centre(problem.start)])

    def next(self) -> Trajectory | None:
        """Return a motion along the quickest curve, else along a roadmap; None without one.

        None, too, where the quickest curve takes too long: no motion takes less time.
        """
        curves = self._curves(*map(self._car.pose, self._ends))
        if not 0.0 < self._seconds(curves[0]) < self._below:
            return None
        direct = (motion for motion in map(self._motion, curves) if motion is not None)
        with suppress(CancelledError):
            return next(direct, None) or self._around()
        return None

    def _around(self) -> Trajectory | None:
        """Return a motion along a new roadmap of curves, None if there is none."""
        if not self._paths.are_free(self._ends):
            return None
        x = free_states(self._paths, self._ends, 1.0, GUESS.roadmap_poses, self._cancelled)
        poses = [self._car.pose(one) for one in x]
        seconds = self._car.all_seconds(poses)
        charge(LENGTH_SECONDS * seconds.size)
        rows = {one.tobytes(): row for one, row in zip(x, seconds, strict=True)}
        roadmap = LazyRoadmap(
            x,
            lambda begin: rows[begin.tobytes()],
            lambda begin, end: self._free_curve(self._car.pose(begin), self._car.pose(end)) != [],
            prm_star_neighbours(len(x), len(self._car.entries)),
            self._cancelled,
            directed=True,
        )
        path = roadmap.path()
        if path is None:
            return None
        legs = [self._free_curve(a, b) for a, b in pairwise(map(self._car.pose, path))]
        return self._motion(self._shortened([arc for leg in legs for arc in leg]))

    def _curves(self, begin: PlanePose, end: PlanePose) -> list[list[Arc]]:
        charge(CURVE_SECONDS)
        return self._car.curves(begin, end)

    def _free_curve(self, begin: PlanePose, end: PlanePose) -> list[Arc]:
        """Return the quickest free curve between two poses, no arcs if there is none."""
        return next((c for c in self._curves(begin, end) if self._is_free(begin, c)), [])

    def _is_free(self, begin: PlanePose, curve: Sequence[Arc]) -> bool:
        """Say whether samples of a curve are free, and within the limits of the place."""
        entries, states = list(self._car.entries), []
        for arc in curve:
            share = np.linspace(0.0, 1.0, self._paths.samples(abs(arc.length), _turned(arc)) + 1)
            x = np.tile(self._problem.start, (len(share), 1))
            x[:, entries] = np.column_stack(arc.poses(begin, share))
            states.append(x)
            begin = arc.after(begin)
        x = np.vstack(states)
        lower, upper = self._problem.bounds[entries[:2]].T
        inside = ((lower <= x[:, entries[:2]]) & (x[:, entries[:2]] <= upper)).all()
        return bool(inside) and self._paths.are_free(x)

    def _shortened(self, curve: list[Arc]) -> list[Arc]:
        """Return a free curve from the start with random shortcuts, each a free curve."""
        for _ in range(GUESS.max_path_shortcuts):
            lengths = np.cumsum([0.0, *(abs(arc.length) for arc in curve)])
            first, last = np.sort(self._generator.uniform(0.0, lengths[-1], 2)).tolist()
            before, rest = _cut(curve, first)
            between, after = _cut(rest, last - first)
            begin = _end(self._car.pose(self._problem.start), before)
            short = self._free_curve(begin, _end(begin, between))
            if short and self._seconds(short) < self._seconds(between):
                curve = [*before, *short, *after]
        return curve

    def _seconds(self, curve: Sequence[Arc]) -> float:
        return sum(map(self._car.seconds, curve))

    def _motion(self, curve: Sequence[Arc]) -> Trajectory | None:
        """Return the motion along a curve from the start, if it is short and breaks nothing."""
        if not self._seconds(curve) < self._below:
            return None
        word = np.array([self._car.input(arc) for arc in curve])
        durations = np.array([self._car.seconds(arc) for arc in curve])
        return motion_along(self._task, word, durations)


def _turned(arc: Arc) -> float:
    return abs(arc.length * arc.curvature)


def _end(begin: PlanePose, curve: Sequence[Arc]) -> PlanePose:
    for arc in curve:
        begin = arc.after(begin)
    return begin


def _cut(curve: Sequence[Arc], length: float) -> tuple[list[Arc], list[Arc]]:
    """Return the arcs before a length in [m], and those after it."""
    before: list[Arc] = []
    for k, arc in enumerate(curve):
        if abs(arc.length) > length:
            share = length / abs(arc.length)
            parts = (Arc(part * arc.length, arc.curvature) for part in (share, 1.0 - share))
            one, other = parts
            return [*before, one], [other, *curve[k + 1 :]]
        before.append(arc)
        length -= abs(arc.length)
    return before, []
