"""Numbers and shapes of XML files: as short as they can be, and read back as they were."""

from __future__ import annotations

import math
from collections.abc import Iterable

FAR = 1e6  # [m], [rad], or per second: a limit that is none, where a file must give one


def numbers(values: Iterable[float]) -> str:
    """Return numbers as a file has them."""
    return " ".join(repr(rounded(float(value)) + 0.0).removesuffix(".0") for value in values)


def rounded(value: float) -> float:
    """Return a number that is off by a rounding error as what was meant, any other as it is."""
    near = float(f"{value:.14g}")  # of a number that differs from a shorter one by rounding
    return near if abs(near - value) <= 4e-16 * abs(value) else value


def limits(lower: float, upper: float) -> tuple[float, float] | None:
    """Return both limits, one of which may be far away; None if there is none."""
    if math.isinf(lower) and math.isinf(upper):
        return None
    return max(lower, -FAR), min(upper, FAR)
