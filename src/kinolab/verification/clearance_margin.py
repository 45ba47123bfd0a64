"""Clearance at a state and smallest clearance along a motion, with the closest pairs.

Along a motion, the next sample is taken where the clearance could drop below the smallest so far:
it changes by no more than points move.

Source: Piyavskii, An algorithm for finding the absolute extremum of a function, USSR Computational
Mathematics and Mathematical Physics 12(4), 1972 (minima of functions of limited slope).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.verification.dense_motion import SAFETY_FACTOR, SPEED_PROBES, DenseMotion
from kinolab.world import CollisionChecker, World

CONTACT_MARGIN = 1e-5  # [m] beyond the clearance, to find the closest pairs by contact
CLEARANCE_TOLERANCE = 1e-4  # [m] by which the minimum may be missed between two samples
RELATIVE_TOLERANCE = 0.01  # of the smallest clearance: the same, where that is larger
MAX_CHECKS = 20_000  # samples after which the tolerance doubles, and so on
GOLDEN = (math.sqrt(5) - 1) / 2
SECTIONS = 24  # golden sections around the minimum found, to 1e-5 of its neighbourhood


@dataclass(frozen=True)
class StateClearance:
    """The clearance at a state.

    Attributes:
        clearance: How far every point may move, in [m]; infinite if there are no obstacles.
        beside: The closest pairs of body and obstacle.
    """

    clearance: float
    beside: tuple[str, ...]

    def __str__(self) -> str:
        return f"{100 * self.clearance:.2g} cm ({', '.join(self.beside)})"


@dataclass(frozen=True)
class ClearanceMargin:
    """The smallest clearance along a motion.

    Attributes:
        clearance: How far every point may move before anything can touch, in [m].
        time: When it occurs, in [s].
        beside: The closest pairs of body and obstacle, or of two bodies.
    """

    clearance: float
    time: float
    beside: tuple[str, ...]

    def __str__(self) -> str:
        beside = f" ({', '.join(self.beside)})" if self.beside else ""
        return f"smallest clearance {1000 * self.clearance:.3g} mm at t = {self.time:.6g} s{beside}"


def state_clearance(problem: PlanningTask, x: Array, checker: CollisionChecker) -> StateClearance:
    """Return the clearance at a state (nx,); 0 if it collides."""
    place = problem.placement(x)
    clearance = checker.clearance(*place)
    if math.isinf(clearance):
        return StateClearance(clearance, ())
    reaching = checker.inflated(clearance + CONTACT_MARGIN, ground=problem.world.ground)
    pairs = (f"{contact.body} – {contact.obstacle}" for contact in reaching.contacts(*place))
    return StateClearance(clearance, tuple(dict.fromkeys(pairs)))


def least_clearance(dense: DenseMotion) -> ClearanceMargin | None:
    """Return the smallest clearance along a motion; None if there is nothing to collide with.

    The true minimum is smaller by at most ``CLEARANCE_TOLERANCE`` or ``RELATIVE_TOLERANCE``,
    provided that the speed bound holds. The ground has a search of its own: the height of a machine
    changes more slowly than its place, or not at all.

    Raises:
        TooFastError: If the motion is too fast to be sampled.
    """
    problem, whole = dense.problem, dense.problem.checker()
    samples = _ClearanceSamples(dense, whole)
    if problem.world.ground:
        samples.checker = CollisionChecker(
            problem.bodies, World(ground=True), cables=problem.cables
        )
        samples.search(samples.slopes())
        samples.checker = problem.checker().inflated(0.0, ground=False)
    samples.search(dense.steps.speed)
    if not math.isfinite(samples.least):
        return None
    samples.checker = whole
    samples.refine()
    return samples.margin()


class _ClearanceSamples:
    """Samples the clearance along a motion and keeps the smallest.

    Attributes:
        checker: Says what the clearance is; it may be replaced.
        least: Smallest clearance so far, in [m].
    """

    def __init__(self, dense: DenseMotion, checker: CollisionChecker) -> None:
        self._problem, self._dense, self._motion = dense.problem, dense, dense.motion
        self.checker = checker
        self.least, self._time, self._x, self._count = math.inf, 0.0, dense.motion.x[0], 0

    def search(self, slopes: Array) -> None:
        """Sample where the clearance may be less than the smallest so far.

        Args:
            slopes: How fast the clearance may change in each integrator step, in [m/s], shape (m,).
        """
        motion, steps = self._motion, self._dense.steps
        for time, x in zip(motion.t.tolist(), motion.x, strict=True):  # avoids most samples between
            self.at_state(time, x)
        if not math.isfinite(self.least):
            return
        left = self.at_state(float(motion.t[0]), motion.x[0])
        for (k, begin, end, _), slope in zip(steps.rows(), slopes.tolist(), strict=True):
            now = begin
            while left - slope * (end - now) < self.least - self.overlooked:
                now += (left - self.least + self.overlooked) / slope
                left = self.at(k, now)
            left -= slope * (end - now)

    def slopes(self) -> Array:
        """Return how fast the clearance changes in each integrator step, by sampling it, (m,)."""
        steps, fraction = self._dense.steps, np.linspace(0.0, 1.0, SPEED_PROBES)
        times = steps.begin[:, None] + (steps.end - steps.begin)[:, None] * fraction
        each = np.repeat(steps.knots, SPEED_PROBES)
        states = self._motion.along(each, times.ravel())
        gaps = [self.checker.clearance(*self._problem.placement(x)) for x in states]
        with np.errstate(invalid="ignore"):  # infinite where every body rests on the ground
            rises = np.abs(np.diff(np.reshape(gaps, times.shape)) / np.diff(times))
        return np.asarray(SAFETY_FACTOR * np.nan_to_num(rises).max(axis=1, initial=0.0))

    @property
    def overlooked(self) -> float:
        """Current tolerance on the minimum, in [m]."""
        return max(CLEARANCE_TOLERANCE, RELATIVE_TOLERANCE * self.least) * 2.0 ** (
            self._count // MAX_CHECKS
        )

    def at(self, k: int, time: float) -> float:
        """Return the clearance at a time in knot interval k."""
        return self.at_state(time, self._motion.between(k, np.array([time]))[0])

    def at_state(self, time: float, x: Array) -> float:
        """Return the clearance at a state, and keep it if it is the smallest so far."""
        clearance = self.checker.clearance(*self._problem.placement(x))
        self._count += 1
        if clearance < self.least:
            self.least, self._time, self._x = clearance, time, x
        return clearance

    def refine(self) -> None:
        """Refine the minimum by golden-section search, on both sides if it is at a knot.

        Source: Kiefer, Sequential minimax search for a maximum, Proc. AMS 4(3), 1953.
        """
        t, time = self._motion.t, self._time
        last = len(t) - 2
        for k in {int(np.searchsorted(t, time, side)) - 1 for side in ("left", "right")}:
            if 0 <= k <= last:
                self._section(k, float(t[k]), float(t[k + 1]), time)

    def _section(self, k: int, begin: float, end: float, time: float) -> None:
        """Golden-section search around a time within knot interval k."""
        reach = (end - begin) / 8
        low, high = max(begin, time - reach), min(end, time + reach)
        for _ in range(SECTIONS):
            one, other = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
            if self.at(k, one) < self.at(k, other):
                high = other
            else:
                low = one

    def margin(self) -> ClearanceMargin:
        """Return the smallest clearance."""
        beside = state_clearance(self._problem, self._x, self.checker).beside
        return ClearanceMargin(self.least, self._time, beside)
