"""Shortcuts: direct connections between two states of a motion, the largest gain first.

Differentially flat machines follow curves from rest to rest; the optimiser then corrects for the
velocities at both ends. Others are guessed to move straight.

Source: Geraerts, Overmars, Creating high-quality paths for motion planning, IJRR 26(8), 2007.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, cycle

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.steering.maneuver import Maneuver
from kinolab.steering.path_families import path_family
from kinolab.steering.path_motion import Path, PathMotion
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.segments import Segments, straight
from kinolab.trajopt.multistart.geometric_path import GeometricPaths
from kinolab.trajopt.multistart.guesses import Guesses, path_time_scaling
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.options import SHORT


class Shortcuts:
    """Searches for direct connections between two states of a motion."""

    def __init__(self, segments: Segments) -> None:
        self._segments, self._samples = segments, cycle(SHORT.shortcut_samples)
        self._guesses = ConnectionGuesses(segments.problem)

    def taken(self, motion: Trajectory) -> Iterator[Trajectory]:
        """Yield a motion with one shortcut, with two, and so on."""
        while not self._segments.cancelled():
            shorter = self._once(motion)
            if shorter is None:
                break
            little = shorter.duration > (1 - SHORT.small_gain) * motion.duration
            motion = shorter
            yield motion
            if little:
                break

    def _once(self, motion: Trajectory) -> Trajectory | None:
        """Return a motion with one more shortcut, or None."""
        failures, slow, places = 0, 0, next(self._samples)
        for begin, end in self._pairs(motion, places):
            if (
                failures == SHORT.max_failed_shortcuts
                or slow == SHORT.max_slow_shortcuts
                or self._segments.cancelled()
            ):
                break
            given, last = motion.piece(begin, end), end == len(motion.u)
            for guess in self._guesses.between(given.x[0], given.x[-1], SHORT.shortcut_knots):
                if not guess.duration < given.duration:
                    slow += 1
                    continue
                segment = self._segments.along(guess, given, last=last)
                if segment is not None:
                    return motion.with_piece(begin, end, segment, self._segments.space)
                failures += 1
        return None

    def _pairs(self, motion: Trajectory, places: int) -> Iterator[tuple[int, int]]:
        """Yield the end indices of segments worth a shortcut, the largest gain first."""
        t = motion.t
        even = np.searchsorted(t, np.linspace(0, t[-1], places + 1))
        knots = np.unique(np.minimum(even, len(t) - 1)).tolist()
        gains = []
        for begin, end in combinations(knots, 2):
            least = self._guesses.least(motion.x[begin], motion.x[end])
            duration = float(t[end] - t[begin])
            if least < SHORT.promised_duration * duration:
                gains.append((least - duration, begin, end))
        for _, begin, end in sorted(gains):
            yield begin, end


class ConnectionGuesses:
    """Initial guesses of connections for one machine in one world.

    Args:
        problem: The problem that the whole motion solves.
    """

    def __init__(self, problem: PlanningTask) -> None:
        self._problem = problem
        self._guesses = Guesses(problem, np.random.default_rng(0))
        self._geometric_paths = GeometricPaths(problem, np.random.default_rng(0))
        model, self._curves = problem.model, None
        # Inputs along a curve are forces, which under feedback are not the inputs.
        if problem.machine.flat is not None and not model.space.spheres and model.plant is model:
            self._curves = path_family(problem)
            self._paths = PathMotion(problem, self._curves.coordinates)
            names = self._curves.coordinates
            self._turning = [model.rate_names.index(f"{name}_dot") for name in names]
            places = [model.coordinate_names.index(name) for name in names]
            self._weights = problem.weights[places]

    def least(self, begin: Array, end: Array) -> float:
        """Estimate the minimum time in [s] between two states, shape (nx,)."""
        path = straight(self._problem, begin, end)
        return self._guesses.quickest(path) + self._guesses.starting

    def between(self, begin: Array, end: Array, knots: int) -> Iterator[Knots]:
        """Yield initial guesses, the most promising first.

        Args:
            begin: Start state, shape (nx,).
            end: End state, shape (nx,).
            knots: Maximum number of knots.
        """
        charge(2e-4)
        path = straight(self._problem, begin, end)
        if self._curves is not None:
            yield from self._along_curves(path, knots)
        elif self._geometric_paths.is_free(*path):
            yield self._straight(path, knots)

    def _straight(self, path: Array, knots: int) -> Knots:
        duration = SHORT.shortcut_duration * self.least(*path)
        count = self._count(duration, knots)
        return path_time_scaling(self._problem, self._guesses.knots(path, count, duration / count))

    def _along_curves(self, way: Array, knots: int) -> Iterator[Knots]:
        assert self._curves is not None
        begin, end = resting = way.copy()
        resting[:, self._problem.model.nq :] = 0.0
        for paths in self._curves.paths(begin, self._curves.straightened(end)):
            charge(1e-4)
            if not all(self._free(paths, begin, samples) for samples in SHORT.curve_samples):
                continue
            motion = self._paths.chain(paths, begin)
            if motion is None or not motion.steps or not self._geometric_paths.are_free(motion.x):
                continue
            times, x = self._moving(motion, way)
            count = self._count(times[-1], knots)
            guess = resampled(times, x, motion.u, count, self._problem.space)
            guess.x[0], guess.x[-1] = way[0], straight(self._problem, guess.x[-1], way[1])[1]
            yield guess

    def _free(self, paths: Sequence[Path], begin: Array, count: int) -> bool:
        """Say whether ``count`` samples of each path are free, those at the end first."""
        samples = [self._paths.sample_states(path, begin, count) for path in reversed(paths)]
        return not samples or self._geometric_paths.are_free(np.concatenate(samples))

    def _moving(self, motion: Maneuver, way: Array) -> tuple[Array, Array]:
        """Return times (N+1,) and states (N+1, nx) of a motion from rest to rest, entered moving.

        Where it would be slower than the states it connects, shape (2, nx), it goes on at their
        speeds, as far as these point along it.
        """
        rates = self._rates(motion.x)
        speed = np.linalg.norm(rates, axis=1)
        gone = (speed[1:] + speed[:-1]) / 2
        peak, between = int(gone.argmax()), self._rates(way)
        entered, left = (
            max(0.0, float(rate @ along) / max(float(np.linalg.norm(along)), 1e-12))
            for rate, along in zip(between, (rates[1], rates[-2]), strict=True)
        )
        least = np.where(np.arange(len(gone)) <= peak, entered, left)
        spans = self._problem.step * np.minimum(1.0, gone / np.maximum(least, 1e-12))
        times = np.concatenate([[0.0], np.cumsum(spans)])
        at_knots = np.where(np.arange(len(speed)) <= peak, entered, left)
        x, moving = motion.x.copy(), slice(self._problem.model.nq, None)
        x[:, moving] *= (np.maximum(speed, at_knots) / np.maximum(speed, 1e-12))[:, None]
        return times, x

    def _rates(self, x: Array) -> Array:
        """Return weighted rates of the coordinates at states (m, nx), shape (m, coordinates)."""
        return self._problem.model.velocity(x)[:, self._turning] * self._weights

    def _count(self, duration: float, most: int) -> int:
        return max(SHORT.min_steps, min(most, covering_steps(duration, self._problem.step)))
