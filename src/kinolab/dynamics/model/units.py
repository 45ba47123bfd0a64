"""Units of a machine's states and inputs, and numbers as they stand before one."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.dynamics.facts.machine_facts import MachineFacts
from kinolab.dynamics.model.model import Model


def state_units(model: Model) -> tuple[str, ...]:
    """Return the unit of each state entry; empty if dimensionless."""
    units = dict(_units(model.machine))
    units |= {entry.name: entry.unit for entry in model.quasi_velocities}
    return tuple(units[name] for name in model.state_names)


def control_units(model: Model) -> tuple[str, ...]:
    """Return the unit of each input, or of each reference where the machine has feedback."""
    return tuple(entry.unit for entry in model.machine.chosen)


def units_by_name(machine: MachineFacts) -> dict[str, str]:
    """Return the unit of all that a scenario may give a value: coordinates, rates, inputs, …"""
    whole = {c.name: c.unit for c in machine.coordinates}  # an attitude, as a whole, is an angle
    chosen = (*machine.inputs, *(machine.references or ()))
    return {**whole, **dict(_units(machine)), **{entry.name: entry.unit for entry in chosen}}


def in_digits(value: float, digits: int = 3) -> str:
    """Return a number rounded to some digits: 3000, and not 3e+03, up to a thousand million."""
    return f"{float(f'{value:.{digits}g}'):.9g}"


def _units(machine: MachineFacts) -> Iterator[tuple[str, str]]:
    for c in machine.coordinates:
        yield from ((name, c.unit if len(c.entries) == 1 else "") for name in c.entries)
        yield from ((name, f"{c.unit}/s") for name in c.rates)
    yield from ((state.name, state.unit) for state in machine.states)
