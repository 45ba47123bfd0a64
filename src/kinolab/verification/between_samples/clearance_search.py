"""The clearance along a motion, sampled where what is known of it leaves too much open.

Between two samples it changes by no more than points move. Whatever interval of time might hold
less clearance than is asked about is halved, all such intervals at once, until none is left. At the
ends of the integrator's steps FCL is asked, too, about everything near: a second opinion on gaps.

Source: Piyavskii, An algorithm for finding the absolute extremum of a function, USSR Computational
Mathematics and Mathematical Physics 12(4), 1972 (minima of functions of limited slope).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.columnar import Columns
from kinolab.verification.between_samples.dense_motion import (
    MAX_SAMPLES,
    SAFETY_FACTOR,
    SPEED_PROBES,
    STATES_PER_BATCH,
    DenseMotion,
    TooFastError,
)
from kinolab.world import CollisionChecker

MIN_RESOLUTION = 1e-5  # [m] least motion between two samples; also the contact tolerance
GRAZE = MIN_RESOLUTION / 2  # [m] of it that a sample without a contact vouches for, on each side
MIDDLE = 0.8  # of an interval, in which it is divided
ZOOM_SAMPLES, ZOOMS = 17, 6  # around a minimum that is pinned down to 1e-5 of its neighbourhood


Told = Callable[[str], None]


@dataclass(frozen=True, eq=False)
class Intervals(Columns):
    """Intervals of time with the clearance at both ends, a row each."""

    step: NDArray[np.intp]  # of the integrator, in which it lies
    begin: Array  # [s]
    end: Array  # [s]
    left: Array  # [m] clearance at the beginning
    right: Array  # [m] at the end


class ClearanceSearch:
    """Samples the clearance along a motion, and keeps the smallest and the first contact.

    Args:
        dense: The motion.
        checker: Says what the clearance is.
        told: Called between rounds with what is being done and how far it is.

    Attributes:
        least: Smallest clearance so far, in [m]; ``time`` and ``x`` are where it occurs.
        contact: When the earliest known contact is, in [s]; infinite where there is none. What
            comes later is not searched. ``touching`` is the state there: where the motion jumps at
            a knot, its time alone does not say which.
        count: Samples so far.

    Raises:
        TooFastError: If the motion is too fast to be sampled.
    """

    def __init__(
        self, dense: DenseMotion, checker: CollisionChecker, told: Told | None = None
    ) -> None:
        self.dense, self.checker, self.told = dense, checker, told
        self.least, self.time, self.x = math.inf, 0.0, dense.motion.x[0]
        self.contact, self.touching, self.count = math.inf, self.x, 0
        steps = dense.steps
        self._slope = steps.speed
        times = np.append(steps.begin, dense.motion.t[-1])
        last = len(dense.motion.t) - 2
        self._judge: CollisionChecker | None = checker.thorough()
        if last < 0:  # it has no step
            gaps = self._clearances(dense.motion.t, dense.motion.x)
        else:
            gaps = self._sampled(np.append(steps.knots, last), times)
        self._judge = None
        each = np.arange(len(steps.begin))
        self._open = Intervals(each, steps.begin, steps.end, gaps[:-1], gaps[1:])
        self._looks = np.zeros(len(each), dtype=np.int64)

    def sample_slopes(self) -> None:
        """Sample how fast the clearance changes: of the ground more slowly than points move."""
        steps, fraction = self.dense.steps, np.linspace(0.0, 1.0, SPEED_PROBES)
        times = steps.begin[:, None] + (steps.end - steps.begin)[:, None] * fraction
        gaps = self._sampled(np.repeat(steps.knots, SPEED_PROBES), times.ravel())
        with np.errstate(invalid="ignore"):  # infinite where every body rests on the ground
            rises = np.abs(np.diff(gaps.reshape(times.shape)) / np.diff(times))
        self._slope = SAFETY_FACTOR * np.nan_to_num(rises).max(axis=1, initial=0.0)

    def narrow(self, below: Callable[[], float], what: str = "collisions") -> None:
        """Sample until no interval is left in which there may be less clearance.

        Args:
            below: Than what, in [m]; it is asked before each round.
            what: Is looked for, in words.

        Raises:
            TooFastError: If that takes too many samples.
        """
        while True:
            self._open = self._open.part(self._open.begin < self.contact)
            wanted = self._lower_bounds() < below()
            if not wanted.any():
                return
            if self.told:
                open_time = (self._open.end - self._open.begin)[wanted].sum()
                done = 1.0 - open_time / self.dense.motion.t[-1]
                self.told(f"verifying a motion: {what}, {max(done, 0.0):.0%} done")
            halves = self._halved(self._open.part(wanted))
            self._open = Intervals.joined([self._open.part(~wanted), *halves])

    def pinpoint(self) -> None:
        """Refine the minimum, on both sides if it is at a knot."""
        t, time = self.dense.motion.t, self.time
        for k in {int(np.searchsorted(t, time, side)) - 1 for side in ("left", "right")}:
            if not 0 <= k < len(t) - 1:
                continue
            reach = (t[k + 1] - t[k]) / 8
            low, high = max(t[k], time - reach), min(t[k + 1], time + reach)
            for _ in range(ZOOMS):
                times = np.linspace(low, high, ZOOM_SAMPLES)
                best = int(np.argmin(self._sampled(np.full(ZOOM_SAMPLES, k), times)))
                low, high = times[max(best - 1, 0)], times[min(best + 1, ZOOM_SAMPLES - 1)]

    def _lower_bounds(self) -> Array:
        """Return what clearance every interval has at least."""
        some = self._open
        change = self._slope[some.step] * (some.end - some.begin)
        ends = np.minimum(some.left, some.right)
        with np.errstate(invalid="ignore"):
            return np.asarray(np.fmin(0.5 * (some.left + some.right - change), ends))

    def _halved(self, some: Intervals) -> tuple[Intervals, Intervals]:
        """Divide intervals where the clearance may be least."""
        np.add.at(self._looks, some.step, 1)
        if len(some.step) and self._looks.max() > MAX_SAMPLES:
            k, steps = int(self._looks.argmax()), self.dense.steps
            raise TooFastError(float(steps.begin[k]), float(steps.end[k]), float(steps.speed[k]))
        half = 0.5 * (some.end - some.begin)
        with np.errstate(divide="ignore", invalid="ignore"):
            aside = np.nan_to_num(0.5 * (some.left - some.right) / self._slope[some.step])
        middle = some.begin + half + np.clip(aside, -MIDDLE * half, MIDDLE * half)
        gaps = self._sampled(self.dense.steps.knots[some.step], middle)
        return (
            Intervals(some.step, some.begin, middle, some.left, gaps),
            Intervals(some.step, middle, some.end, gaps, some.right),
        )

    def _sampled(self, knots: NDArray[np.intp], times: Array) -> Array:
        """Return clearances at times, each in a knot interval; 0 where it collides."""
        gaps = np.empty(len(times))
        for first in range(0, len(times), STATES_PER_BATCH):
            some = slice(first, first + STATES_PER_BATCH)
            states = self.dense.motion.along(knots[some], times[some])
            gaps[some] = self._clearances(times[some], states)
        return gaps

    def _clearances(self, times: Array, states: Array) -> Array:
        place = self.dense.problem.placement(states)
        judge = self._judge or self.checker
        gaps = judge.clearances(*place)
        self.count += len(gaps)
        best = int(np.argmin(gaps))
        if gaps[best] < self.least:
            self.least, self.time, self.x = float(gaps[best]), float(times[best]), states[best]
        for k in np.flatnonzero(gaps == 0.0)[np.argsort(times[gaps == 0.0], kind="stable")]:
            if times[k] >= self.contact:
                break
            poses, ends = place
            if judge.collides(poses[k], ends[k] if len(ends) else ends):
                self.contact, self.touching = float(times[k]), states[k]
            else:  # it grazes something
                gaps[k] = GRAZE
        return np.where(gaps > 0.0, np.maximum(gaps, GRAZE), 0.0)
