"""When the frames of a film are shown."""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.numerics.arrays import Array


@dataclass(frozen=True, eq=False)
class Playback:
    """Sample times of the frames, and their display rate.

    Args:
        times: In [s], shape (nf,), from the start to the end of the motion.
        period: Duration of a frame, in [s].
        speed: Seconds of motion per second of film.
    """

    times: Array
    period: float
    speed: float

    @property
    def delay(self) -> int:
        """Duration of a frame, in [1/100 s]."""
        return round(100.0 * self.period)
