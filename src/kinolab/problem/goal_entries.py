"""Goal entries for reports: value, target, error and tolerance, each in its own unit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.codegen.state_space import wrapped
from kinolab.dynamics.model.units import state_units
from kinolab.numerics.arrays import Array
from kinolab.problem.task import PlanningTask


@dataclass(frozen=True)
class GoalEntry:
    """One target of the goal and the value reached.

    Attributes:
        name: A coordinate, rate or measured quantity, such as ``distance of hook``.
        value: Value reached, in its SI unit.
        target: Target value; 0 for distances and angles.
        error: Distance from the target; on the circle for angles that wrap.
        tolerance: Largest error within the goal.
        unit: Of all these; empty if dimensionless.
    """

    name: str
    value: float
    target: float
    error: float
    tolerance: float
    unit: str

    @property
    def reached(self) -> bool:
        """Whether the error is within the tolerance."""
        return self.error <= self.tolerance

    def __str__(self) -> str:
        wanted = f"{self.target:.4g} ± {self.tolerance:.3g}"
        return f"{self.name} = {self.value:.4g} (wanted {wanted})"


def goal_entries(
    problem: PlanningTask, x: Array, frames: Array | None = None
) -> tuple[GoalEntry, ...]:
    """Return the goal's entries at a state, largest violation in tolerances first.

    Args:
        x: State, shape (nx,).
        frames: Poses of the bodies, shape (bodies, 12), where they are not those of the problem's
            machine.
    """
    entries = _entries(problem, x, frames)
    return tuple(sorted(entries, key=lambda entry: -entry.error / entry.tolerance))


def _entries(problem: PlanningTask, x: Array, frames: Array | None = None) -> Iterator[GoalEntry]:
    model, bodies, frames = (
        problem.model,
        problem.bodies,
        problem.frames(x) if frames is None else frames,
    )
    goal = min(problem.goal.each, key=lambda one: one.excess(x, frames))
    units = state_units(model)
    values = np.where(problem.circular, wrapped(x), x)
    told = [
        (model.state_names[i], float(values[i]), float(target), units[i])
        for i, target in zip(goal.indices, goal.targets, strict=True)
    ]
    measured = [(f"turn of {one.part.name}", "rad") for one in goal.parts]
    measured += [(f"distance of {bodies[point.body].name}", "m") for point in goal.points]
    measured += [(f"angle of {bodies[axis.body].name}", "rad") for axis in goal.directions]
    measured += [(f"distance to {bodies[one.body].name}", "") for one in goal.formulas]
    found = goal.errors(x, frames)
    errors = np.abs(found).tolist()
    sizes = errors[len(told) :]
    told += [(name, size, 0.0, unit) for (name, unit), size in zip(measured, sizes, strict=True)]
    rows = zip(told, errors, goal.error_tolerances.tolist(), strict=True)
    for (name, value, target, unit), error, tolerance in rows:
        yield GoalEntry(name, value, target, error, tolerance, unit)


def distance_by_unit(entries: Iterable[GoalEntry]) -> dict[str, float]:
    """Return the norm of the errors of each unit; the norm of all is the goal's distance.

    Metres and radians do not add up, so reports list each unit separately.
    """
    squares: dict[str, float] = {}
    for entry in entries:
        squares[entry.unit] = squares.get(entry.unit, 0.0) + entry.error**2
    places_first = sorted(squares, key=lambda unit: (unit.endswith("/s"), unit))
    return {unit: math.sqrt(squares[unit]) for unit in places_first}


def distance_text(problem: PlanningTask, x: Array) -> str:
    """Print the distance of a state (nx,) to the goal's centre: ``1.2e-09 m and 3.4e-10 rad``.

    What has no unit, such as a mode, is told where it is missed.
    """
    norms = distance_by_unit(_entries(problem, x))
    norms = {unit: norm for unit, norm in norms.items() if unit or norm} or norms
    parts = [f"{norm:.3g} {unit}".rstrip() for unit, norm in norms.items()]
    head, last = ", ".join(parts[:-1]), parts[-1]
    return f"{head} and {last}" if head else last
