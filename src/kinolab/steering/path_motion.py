"""Time scaling and inverse dynamics: from a path of some coordinates to a maneuver."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import TypeAlias

import numpy as np

from kinolab.concurrency.cancel import CancellationToken, never_cancelled, raise_if_cancelled
from kinolab.dynamics import Model
from kinolab.numerics.arrays import Array
from kinolab.numerics.cubic_spline import CubicSpline
from kinolab.problem import PlanningTask
from kinolab.problem.task import LIMIT_TOLERANCE
from kinolab.problem.time_steps import covering_steps
from kinolab.steering.maneuver import Maneuver


class SampledPath:
    """A path that is known by samples, and can be looked at without more.

    Args:
        fraction: Of the arc length, at samples, shape (n,).
        coordinates: There, shape (n, coordinates).
    """

    def __init__(self, fraction: Array, coordinates: Array) -> None:
        self._fraction, self._coordinates = fraction, coordinates

    def __call__(self, s: Array, _rate: Array, _slope: Array) -> Array:
        """Return the coordinates at fractions s (m,), twice differentiable."""
        return self._spline(s)

    def sampled(self, s: Array) -> Array:
        """Return the coordinates at fractions s (m,), by straight lines between samples.

        Most curves are only looked at, to see that something is in the way.
        """
        return np.column_stack([np.interp(s, self._fraction, c) for c in self._coordinates.T])

    @cached_property
    def _spline(self) -> CubicSpline:
        return CubicSpline(self._fraction, self._coordinates)


@dataclass(frozen=True)
class TimeScaling:
    """Path parameter from 0 to 1 over time: smooth acceleration, cruise, deceleration.

    Four derivatives are continuous, so machines whose force depends on the fourth derivative, such
    as cranes, see no jumps.

    Attributes:
        ramp: Duration of each speed ramp in [s].
        cruise: Duration at constant speed in [s].
    """

    ramp: float
    cruise: float

    @property
    def duration(self) -> float:
        """Total duration in [s]."""
        return 2 * self.ramp + self.cruise

    @property
    def speed(self) -> float:
        """Cruise speed of the path parameter in [1/s]."""
        return 1.0 / (self.ramp + self.cruise)

    def stretched(self, step: float) -> TimeScaling:
        """Stretch the duration to a whole number of steps, each in [s]."""
        steps = max(covering_steps(self.duration, step), 2)
        factor = steps * step / self.duration
        return TimeScaling(self.ramp * factor, self.cruise * factor)

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Return the path parameter and its first two derivatives at times t in [s], shape (m,)."""
        up, down = _ramp(t / self.ramp), _ramp((self.duration - t) / self.ramp)
        rising = t < self.ramp
        falling = t > self.ramp + self.cruise
        fraction = np.where(rising, up[0] * self.ramp, t - self.ramp / 2)
        fraction = np.where(falling, self.ramp + self.cruise - down[0] * self.ramp, fraction)
        rate = np.where(rising, up[1], np.where(falling, down[1], 1.0))
        slope = np.where(rising, up[2], np.where(falling, -down[2], 0.0)) / self.ramp
        return self.speed * fraction, self.speed * rate, self.speed * slope


def _ramp(tau: Array) -> tuple[Array, Array, Array]:
    """Return integral, value and slope of the septic ramp from 0 to 1 over [0, 1], shape (m,)."""
    tau = np.clip(tau, 0.0, 1.0)
    value = tau**4 * (35 - 84 * tau + 70 * tau**2 - 20 * tau**3)
    integral = tau**5 * (7 - 14 * tau + 10 * tau**2 - 2.5 * tau**3)
    return integral, value, 140 * tau**3 * (1 - tau) ** 3


Path: TypeAlias = Callable[[Array, Array, Array], Array]  # s, ds/dt, d2s/dt2 -> (times, known)


class AbstractPathFamily(ABC):
    """Rest-to-rest paths.

    Attributes:
        coordinates: Names of the coordinates that the paths determine.
    """

    coordinates: tuple[str, ...]

    @abstractmethod
    def paths(self, x0: Array, x1: Array) -> Iterator[list[Path]]:
        """Yield sequences of paths from x0 to x1, shape (nx,), with a stop after each path."""

    def detours(self, x0: Array, x1: Array) -> Iterator[list[Path]]:  # noqa: ARG002
        """Yield longer alternatives, for when none of the others is free: by default none."""
        yield from ()

    def straightened(self, x: Array) -> Array:
        """Return the state, shape (nx,), with its steering straight, if the machine has any."""
        return x


LIMIT_FRACTION = 0.9  # fraction of every limit that a motion may use; the rest is for corrections
SLOW = TimeScaling(100.0, 100.0)  # quasi-static: velocities matter, forces do not
MAX_STEPS = 20_000  # steps of one motion
ROUNDING_FACTOR = 1.0 + 1e-9  # fraction of a limit, with tolerance for rounding
MIN_SLOWDOWN = 1.15  # smallest slowdown factor after a violation


class PathMotion:
    """Rest-to-rest motions along paths of known coordinates.

    Velocities follow from the path through the constraints, the other coordinates by integrating
    their rates, and inputs from the equations of motion at the midpoint of each step, in the
    least-squares sense.

    Args:
        known: Names of the coordinates that paths determine, in order.
        stop: Cancellation token; cancelling raises a CancelledError.
    """

    def __init__(
        self,
        problem: PlanningTask,
        known: tuple[str, ...],
        stop: CancellationToken = never_cancelled,
    ) -> None:
        model, self._stop = problem.model, stop
        self._problem, self._model = problem, model
        self._known = [model.coordinate_names.index(name) for name in known]
        self._rates = [_rate_of(model, i) for i in self._known]
        self._other = [i for i in range(model.nq) if i not in self._known]
        self._other_rates = [_rate_of(model, i) for i in self._other]
        self._speeds = slice(model.nq, model.nq + model.nv)
        lower, upper = model.control_bounds.T
        self._middle, self._half = (lower + upper) / 2, np.maximum((upper - lower) / 2, 1e-12)
        self._limited = np.flatnonzero(np.isfinite(problem.bounds).all(axis=1))
        self._limited_rates = np.flatnonzero(np.isfinite(problem.rate_bounds).all(axis=1))

    def chain(self, paths: Sequence[Path], start: Array) -> Maneuver | None:
        """Follow paths in sequence from a state (nx,), with stops between them; or None."""
        whole: Maneuver | None = None
        for path in paths:
            piece = self.follow(path, start if whole is None else whole.x[-1])
            if piece is None:
                return None
            whole = piece if whole is None else whole.then(piece)
        return whole

    # 12 samples of a path checked before its motion is computed
    def sample_states(self, path: Path, start: Array, count: int = 12) -> Array:
        """Sample states at rest along a path, from its middle outwards, shape (count, nx)."""
        shares, states = _from_the_middle(count), np.empty((count, len(start)))
        states[:] = start
        states[:, self._known] = (
            path.sampled(shares)
            if isinstance(path, SampledPath)
            else path(shares, np.zeros(count), np.zeros(count))
        )
        return states

    def follow(self, path: Path, start: Array) -> Maneuver | None:
        """Return the fastest motion along a path within limits; None if there is none.

        Its end only approximates the path's, since inputs are zero-order held.

        Args:
            path: Coordinates as a function of the path parameter and its derivatives.
            start: State at rest at the path's beginning, shape (nx,).
        """
        step = self._problem.step
        found = self._motion(path, start, SLOW, 48)  # steps of the quasi-static feasibility test
        if found is None or self._fastest(found) > ROUNDING_FACTOR:
            return None  # the path violates a limit at any speed
        speed = SLOW.speed / max(self._fastest(found, first=self._model.nq), 1e-9)
        ramp, closely = max(0.5, 2 * step), False  # [s]
        # 10.0: multiple of the duration at full speed beyond which to give up
        longest = max(SLOW.duration, 10.0 / speed)
        for _ in range(24):  # time scalings to try
            timing = TimeScaling(ramp, max(1.0 / speed - ramp, 0.0)).stretched(step)
            if timing.duration > longest:
                return None  # slowing down further does not help
            steps = round(timing.duration / step)
            if steps > MAX_STEPS:
                return None
            # 32 steps in which a time scaling is first tried
            count = steps if closely else min(32, steps)
            found = self._motion(path, start, timing, count)
            if found is None:
                return None
            fast, (hard, when) = self._fastest(found), self._hardest(found)
            if fast <= ROUNDING_FACTOR and hard <= ROUNDING_FACTOR:
                if count == steps:
                    return found
                closely = True
                continue
            cruising = timing.ramp < when * timing.duration < timing.ramp + timing.cruise
            if hard > ROUNDING_FACTOR:
                ramp *= max(MIN_SLOWDOWN, min(hard, 2.0))
                speed = min(speed, 1.0 / ramp)
            if hard > ROUNDING_FACTOR and cruising:
                speed /= max(MIN_SLOWDOWN, min(np.sqrt(hard), 2.0))  # force ~ speed squared
            elif fast > ROUNDING_FACTOR or ramp * speed > 0.5:
                speed /= max(MIN_SLOWDOWN, min(fast, 2.0))
        return None

    def _fastest(self, motion: Maneuver, first: int = 0) -> float:
        """Return the largest utilisation of state limits, relative to LIMIT_FRACTION.

        An entry that begins or ends closer to a limit may be as close in between.

        Args:
            motion: The motion to evaluate.
            first: First entry of the state to consider.
        """
        limited = [i for i in self._limited if i >= first]
        values, limits = motion.x[:, limited], self._problem.bounds[limited]
        if len(self._limited_rates):
            rates = self._model.velocity(motion.x)[:, self._limited_rates]
            values = np.hstack([values, rates])
            limits = np.vstack([limits, self._problem.rate_bounds[self._limited_rates]])
        lower, upper = limits.T
        off, half = np.abs(values - (lower + upper) / 2), (upper - lower) / 2
        ends = np.minimum(np.maximum(off[0], off[-1]), half + LIMIT_TOLERANCE)
        allowed = np.maximum(LIMIT_FRACTION * half, ends)
        return float((off / allowed).max(initial=0.0))

    def _hardest(self, motion: Maneuver) -> tuple[float, float]:
        """Return the largest utilisation of input ranges, relative to LIMIT_FRACTION, and its time.

        The time is a fraction of the duration.
        """
        shares = (np.abs(motion.u - self._middle) / self._half).max(axis=1) / LIMIT_FRACTION
        if self._problem.machine.requirements:
            margins = self._model.requirements(motion.x[:-1], motion.u)
            shares = np.where((margins < 0).any(axis=1), np.maximum(shares, 1.5), shares)
        worst = int(np.argmax(shares))
        return float(shares[worst]), (worst + 0.5) / motion.steps

    def _motion(self, path: Path, start: Array, timing: TimeScaling, count: int) -> Maneuver | None:
        """Return a motion of ``count`` steps; None if the constraints forbid the path."""
        raise_if_cancelled(self._stop)
        half = timing.duration / count / 2  # times of knots and midpoints
        times: Array = half * np.arange(2 * count + 1, dtype=float)
        x = np.tile(start, (2 * count + 1, 1))
        x[:, self._known] = path(*timing.at(times))
        rates = np.gradient(x[:, self._known], half, axis=0)
        rates[[0, -1]] = 0.0  # from rest to rest
        speeds, others = self._speeds_of(x, rates)
        if speeds is None:
            return None
        x[:, self._speeds] = speeds
        gone = np.cumsum((others[1:] + others[:-1]) * half / 2, axis=0)
        x[1:, self._other] = start[self._other] + gone
        changes = (speeds[2::2] - speeds[:-2:2]) / (2 * half)
        return Maneuver(x[::2], self._inputs(x[1::2], changes))

    def _speeds_of(self, x: Array, rates: Array) -> tuple[Array | None, Array]:
        """Solve for independent velocities from known rates (m, known); also the other rates.

        Velocities are None if the rates violate the constraints.
        """
        model, count = self._model, self._model.nv
        if model.velocity_names == model.rate_names and not self._other:
            speeds = np.empty_like(rates)
            speeds[:, self._rates] = rates
            return speeds, np.empty((len(x), 0))
        units = np.repeat(x, count, axis=0)
        units[:, self._speeds] = np.tile(np.eye(count), (len(x), 1))
        maps = model.velocity(units).reshape(len(x), count, model.nt).transpose(0, 2, 1)
        known = maps[:, self._rates]
        speeds = _least_squares(known, rates)
        missed = np.abs((known @ speeds[:, :, None])[:, :, 0] - rates)
        # 0.05 of the largest rate: finite-difference error of a path that fits the constraints
        if missed.max(initial=0.0) > 0.05 * np.abs(rates).max(initial=0.0):
            return None, rates
        return speeds, (maps[:, self._other_rates] @ speeds[:, :, None])[:, :, 0]

    def _inputs(self, x: Array, changes: Array) -> Array:
        """Return inputs (N, nu) that give wanted accelerations at states (N, nx)."""
        model = self._model
        _, gain = model.jacobian(x, self._middle)
        drift = model.f(x, np.tile(self._middle, (len(x), 1)))[:, self._speeds]
        weight = 1.0 / self._problem.scales[self._speeds]
        rows = gain[:, self._speeds] * weight[:, None] * self._half
        u: Array = self._middle + self._half * _least_squares(rows, (changes - drift) * weight)
        return u


@cache
def _from_the_middle(count: int) -> Array:
    """Return even fractions in [0, 1] from the middle outwards, shape (count,)."""
    shares = np.linspace(0.0, 1.0, count)
    return shares[np.argsort(np.abs(shares - 0.5), kind="stable")]


def _rate_of(model: Model, coordinate: int) -> int:
    """Return the index of a coordinate's rate among all rates."""
    return model.rate_names.index(f"{model.coordinate_names[coordinate]}_dot")


def _least_squares(rows: Array, right: Array) -> Array:
    """Solve a batch of least-squares problems (N, m, n), (N, m) by regularised normal equations."""
    turned = rows.transpose(0, 2, 1)
    square = turned @ rows
    size = np.trace(square, axis1=1, axis2=2)[:, None, None]
    # 1e-13 relative to the matrix's trace, for redundant inputs
    regular = square + 1e-13 * size * np.eye(square.shape[-1])
    return np.asarray(np.linalg.solve(regular, turned @ right[:, :, None])[:, :, 0], dtype=float)
