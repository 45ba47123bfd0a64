"""Durations in whole steps of time."""

from __future__ import annotations

import math


def covering_steps(duration: float, step: float) -> int:
    """Return the least number of steps that cover a duration, but for rounding.

    Args:
        duration: In [s], at least 0; finite.
        step: Length of a step in [s].
    """
    # rounding, by which a duration may exceed a whole number of steps
    return math.ceil(duration / step - 1e-6)
