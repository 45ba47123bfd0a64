"""Array types of kinolab: float64 unless stated otherwise."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
Integers: TypeAlias = NDArray[np.int64]
Singles: TypeAlias = NDArray[np.float32]

# Products of five such numbers are doubles, which reach from 1e-308 to 1e308.
MULTIPLIABLE = (1e-60, 1e60)
