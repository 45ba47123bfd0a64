"""States, inputs and references of a plan as plots, with the units that the machine gives them."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.dynamics import Model, System
from kinolab.dynamics.symbols import Coordinate
from kinolab.render.page import Series
from kinolab.trajectory import Trajectory


def plotted(model: Model, trajectory: Trajectory) -> list[Series]:
    """Return what is plotted of a plan: its states, then what is held from knot to knot."""
    units = state_units(model)
    names = trajectory.state_names
    found = [Series("States", names, tuple(units[name] for name in names), trajectory.x)]
    if len(trajectory.u):
        found.append(_held("Inputs", model.plant, trajectory.control_names, trajectory.u))
        if trajectory.reference_names:
            names = trajectory.reference_names
            found.append(_held("References", model, names, trajectory.references))
    return found


def _held(title: str, model: Model, names: tuple[str, ...], values: object) -> Series:
    system, feedback = model.system, model.system.feedback
    chosen = system.inputs if model.plant is model else getattr(feedback, "references", ())
    units = {entry.name: entry.unit for entry in chosen}
    return Series(title, names, tuple(units.get(name, "") for name in names), values, held=True)  # type: ignore[arg-type]


def state_units(model: Model) -> dict[str, str]:
    """Return the unit of every state by its name; empty for pure numbers."""
    return dict(_units(model.system, model))


def _units(system: System, model: Model) -> Iterator[tuple[str, str]]:
    for coordinate in system.coordinates:
        if isinstance(coordinate, Coordinate):
            yield coordinate.name, coordinate.unit
        else:
            yield from ((entry.name, "") for entry in coordinate.quaternion)
    rates = [
        f"{coordinate.unit}/s"
        for coordinate in system.coordinates
        for _ in range(1 if isinstance(coordinate, Coordinate) else 3)
    ]
    yield from zip(model.rate_names, rates, strict=True)
    yield from ((state.name, state.unit) for state in system.states)
