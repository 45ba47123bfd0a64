"""How many times as long one side takes, and how sure that is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Times: TypeAlias = Sequence[float]

RESAMPLES = 10_000
LEVEL = 0.95  # of the interval


@dataclass(frozen=True)
class Ratio:
    """A ratio of medians.

    Attributes:
        value: Of what was measured.
        low, high: Between which it lies in all but 5 % of the resamples.
    """

    value: float
    low: float
    high: float


def ratio(theirs: Sequence[Times], ours: Sequence[Times], seed: int = 0) -> Ratio:
    """Return the least median of theirs over the least of ours, with a bootstrap's interval.

    Each planner's times are drawn anew with replacement, and who is best is asked again in every
    resample: that choice is uncertain, too.

    Args:
        theirs, ours: Times of every planner, one per run.
        seed: Of the resamples.

    Source: Efron, Bootstrap methods: another look at the jackknife, The Annals of Statistics 7(1),
    1979.
    """
    generator = np.random.default_rng(seed)
    drawn = _least(theirs, generator) / _least(ours, generator)
    low, high = np.quantile(drawn, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    value = min(median(own) for own in theirs) / min(median(own) for own in ours)
    return Ratio(value, float(low), float(high))


def _least(times: Sequence[Times], generator: np.random.Generator) -> Array:
    """Return the least median of each resample, shape (RESAMPLES,)."""
    least = np.full(RESAMPLES, np.inf)
    for own in map(np.asarray, times):
        chosen = generator.integers(len(own), size=(RESAMPLES, len(own)))
        least = np.minimum(least, np.median(own[chosen], axis=1))
    return least
