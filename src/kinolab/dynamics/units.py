"""Units of a machine's states and inputs."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.dynamics.model import Model


def state_units(model: Model) -> tuple[str, ...]:
    """Return the unit of each state entry; empty if dimensionless."""
    units = dict(_units(model))
    return tuple(units[name] for name in model.state_names)


def control_units(model: Model) -> tuple[str, ...]:
    """Return the unit of each input, or of each reference where the machine has feedback."""
    return tuple(entry.unit for entry in model.machine.chosen)


def _units(model: Model) -> Iterator[tuple[str, str]]:
    for c in model.machine.coordinates:
        yield from ((name, "" if c.quaternion else c.unit) for name in c.entries)
        yield from ((name, f"{c.unit}/s") for name in c.rates)
    yield from ((entry.name, entry.unit) for entry in model.quasi_velocities)
    yield from ((state.name, state.unit) for state in model.machine.states)
