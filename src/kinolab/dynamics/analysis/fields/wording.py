"""Combinations of names as text."""

from __future__ import annotations

from collections.abc import Iterable

DIGITS = 4  # of a coefficient that is told
MIN_COEFFICIENT = 1e-6  # of the largest coefficient: one below is not told


def combination_text(coefficients: Iterable[float], names: Iterable[str]) -> str:
    """Write a linear combination: ``theta_1 - 0.5 theta_2``."""
    terms = [(float(c), name) for c, name in zip(coefficients, names, strict=True)]
    largest = max((abs(c) for c, _ in terms), default=0.0)
    text = ""
    for c, name in terms:
        if abs(c) > MIN_COEFFICIENT * largest:
            size = f"{abs(c):.{DIGITS}g}"
            sign = ("-" if c < 0 else "") if not text else (" - " if c < 0 else " + ")
            text += sign + (name if size == "1" else f"{size} {name}")
    return text or "0"
