"""The units in which a machine's states and inputs are counted."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.dynamics.model import Model
from kinolab.dynamics.symbols import Coordinate


def state_units(model: Model) -> tuple[str, ...]:
    """Return the unit of each state, in their order; empty for pure numbers."""
    units = dict(_units(model))
    return tuple(units[name] for name in model.state_names)


def control_units(model: Model) -> tuple[str, ...]:
    """Return the unit of each input, in their order: of references where a machine has feedback."""
    feedback = model.system.feedback
    chosen = model.system.inputs if feedback is None else feedback.references
    units = {entry.name: entry.unit for entry in chosen}
    return tuple(units[name] for name in model.control_names)


def _units(model: Model) -> Iterator[tuple[str, str]]:
    turning = []
    for coordinate in model.system.coordinates:
        if isinstance(coordinate, Coordinate):
            yield coordinate.name, coordinate.unit
            turning.append(f"{coordinate.unit}/s")
        else:
            yield from ((entry.name, "") for entry in coordinate.quaternion)
            turning += ["rad/s"] * 3
    yield from zip(model.rate_names, turning, strict=True)
    yield from ((state.name, state.unit) for state in model.system.states)
