"""Array types of kinolab: float64 unless stated otherwise; and numbers for JSON."""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Singles: TypeAlias = NDArray[np.float32]
Bytes: TypeAlias = NDArray[np.uint8]

# Products of five such numbers are doubles, which reach from 1e-308 to 1e308.
MULTIPLIABLE = (1e-60, 1e60)


def finite_or_none(value: float) -> float | None:
    """Return a number, or None where it is not finite: JSON has neither NaN nor infinity."""
    return value if math.isfinite(value) else None
