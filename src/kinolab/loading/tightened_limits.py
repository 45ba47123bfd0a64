"""Tightened input limits, which leave control authority for feedback."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from kinolab.dynamics.language.feedback import Feedback
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.errors import InputError, Mistake


def with_tightened_limits(
    system: Mechanism, limits: Mapping[str, tuple[float, float]]
) -> Mechanism:
    """Return a machine with narrower limits of inputs or references.

    Args:
        system: The machine; a regulator's gains are designed for its original limits.
        limits: (lower, upper) by name of the input or reference; others are ignored.

    Raises:
        InputError: Where limits do not intersect those of the machine.
    """
    mistakes: list[Mistake] = []

    def held(entry: Any) -> Any:
        if entry.name not in limits:
            return entry
        lower, upper = bounds_of(entry)
        least, most = max(lower, limits[entry.name][0]), min(upper, limits[entry.name][1])
        if not least < most:
            what = f"the limits of {entry.name} exclude each other: {least:g} to {most:g}."
            mistakes.append(Mistake(entry.name, what, f"The machine's are {lower:g} to {upper:g}."))
        return replace(entry, limit=(least, most))

    inputs, feedback = [held(entry) for entry in system.inputs], system.feedback
    if isinstance(feedback, Feedback):
        feedback = Feedback([held(entry) for entry in feedback.references], feedback.law)
    if mistakes:
        raise InputError(mistakes)
    return system.changed(inputs=inputs, feedback=feedback)
