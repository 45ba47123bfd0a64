"""From rest to rest along a path: how far at which time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import Array

MAX_RAMP_SLOPE = 2.1875  # the largest slope of the ramp from 0 to 1 over a unit of time


@dataclass(frozen=True)
class TimeScaling:
    """A share of a path that grows from 0 to 1: a smooth ramp of speed, a cruise, a ramp down.

    Four derivatives of the share are continuous, so that a machine which turns the fourth
    derivative into force, as a crane does, is not jerked.

    Attributes:
        ramp: Duration of each ramp in [s].
        cruise: Duration at constant speed in [s].
    """

    ramp: float
    cruise: float

    @property
    def duration(self) -> float:
        """In [s]."""
        return 2 * self.ramp + self.cruise

    @property
    def speed(self) -> float:
        """Of the cruise, in shares per second."""
        return 1.0 / (self.ramp + self.cruise)

    def stretched(self, step: float) -> TimeScaling:
        """Return the timing made longer to a whole number of steps in [s]."""
        steps = max(int(np.ceil(self.duration / step - 1e-9)), 2)
        factor = steps * step / self.duration
        return TimeScaling(self.ramp * factor, self.cruise * factor)

    def at(self, t: Array) -> tuple[Array, Array, Array]:
        """Return the share and its first two derivatives at times t in [s]."""
        up, down = _ramp(t / self.ramp), _ramp((self.duration - t) / self.ramp)
        rising = t < self.ramp
        falling = t > self.ramp + self.cruise
        fraction = np.where(rising, up[0] * self.ramp, t - self.ramp / 2)
        fraction = np.where(falling, self.ramp + self.cruise - down[0] * self.ramp, fraction)
        rate = np.where(rising, up[1], np.where(falling, down[1], 1.0))
        slope = np.where(rising, up[2], np.where(falling, -down[2], 0.0)) / self.ramp
        return self.speed * fraction, self.speed * rate, self.speed * slope


def _ramp(tau: Array) -> tuple[Array, Array, Array]:
    """Return integral, value and slope of the seventh-degree ramp from 0 to 1 over [0, 1]."""
    tau = np.clip(tau, 0.0, 1.0)
    value = tau**4 * (35 - 84 * tau + 70 * tau**2 - 20 * tau**3)
    integral = tau**5 * (7 - 14 * tau + 10 * tau**2 - 2.5 * tau**3)
    return integral, value, 140 * tau**3 * (1 - tau) ** 3
