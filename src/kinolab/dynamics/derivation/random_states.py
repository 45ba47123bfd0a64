"""Random states of a machine, for decisions that are taken once and must not depend on luck."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.dynamics.language.mechanism import System
from kinolab.dynamics.language.symbols import Coordinate

RANDOM_STATES = 12  # more never changed a choice


def sampled_values(system: System, count: int = RANDOM_STATES) -> Iterator[dict[str, float]]:
    """Yield values of all symbols by name: first the rest position, then any within the limits.

    The same machine gives the same values every time.
    """
    generator = np.random.default_rng(0)
    for k in range(count):
        values = dict(system.parameter_values)
        for coordinate in system.coordinates:
            if isinstance(coordinate, Coordinate):
                value = random_value(coordinate, generator)
                values[coordinate.name] = value if k else rest_value(coordinate)
                values[f"{coordinate.name}_dot"] = float(generator.normal())
            else:
                quaternion = generator.normal(size=4)
                quaternion /= np.linalg.norm(quaternion)
                entries = zip(coordinate.quaternion, quaternion, strict=True)
                values |= {symbol.name: float(value) for symbol, value in entries}
                values |= {s.name: float(generator.normal()) for s in coordinate.turn_rate}
        values |= {entry.name: float(generator.normal()) for entry in system.states}
        values |= {entry.name: float(generator.normal()) for entry in system.inputs}
        yield values


def rest_value(coordinate: Coordinate) -> float:
    """Return where a coordinate starts unless told otherwise: 0, or the limit nearest to it."""
    return min(max(0.0, coordinate.lower), coordinate.upper)


def random_value(coordinate: Coordinate, generator: np.random.Generator) -> float:
    """Return a value of a coordinate: anywhere on a circle, within the limits on a line."""
    if coordinate.topology == "circle":
        return float(generator.uniform(-np.pi, np.pi))
    lower, upper = coordinate.lower, coordinate.upper
    if not np.isfinite(lower):
        lower = (upper if np.isfinite(upper) else coordinate.scale) - 2 * coordinate.scale
    if not np.isfinite(upper):
        upper = lower + 2 * coordinate.scale
    return float(generator.uniform(lower, upper))
