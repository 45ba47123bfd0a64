"""What the checks depend on and a scenario or a machine may choose."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from kinolab.problem import PlanningTask
from kinolab.scenario import SystemSection


@dataclass(frozen=True)
class CheckConditions:
    """How strict the checks of a trajectory are.

    Attributes:
        truth: Whether the equations of motion count, "continuous", or the integrator's steps.
        goal_tolerances: How far each target of the goal may be missed, in its own unit.
        clearance: That must be kept from every obstacle, in [m].
        obstacles: How many there are.
        bodies_with_shapes: How many bodies can touch anything.
        scales: Of the entries of the state: differences are small beside them.
        parameters: Of the machine, those that the scenario sets.
        bounds: Limits of inputs, coordinates and rates that the scenario sets, lower and upper.
        requirements: Names of what the machine demands of a plan, and a goal by a predicate.
        sensed: What stands for what a sensor saw: walls on cells, balls around points.
    """

    truth: str
    goal_tolerances: dict[str, float]
    clearance: float
    obstacles: int
    bodies_with_shapes: int
    scales: dict[str, float]
    parameters: dict[str, float]
    bounds: dict[str, tuple[float, float]]
    requirements: tuple[str, ...]
    sensed: tuple[str, ...]

    @classmethod
    def of(cls, problem: PlanningTask) -> CheckConditions:
        """Return the conditions of a problem."""
        scenario = problem.scenario
        asked = () if problem.goal.predicate is None else ("a predicate of the goal's end",)
        tolerances = zip(_targets(problem), problem.goal.error_tolerances.tolist(), strict=True)
        return cls(
            truth=scenario.integration.truth,
            goal_tolerances=dict(tolerances),
            clearance=problem.world.clearance,
            obstacles=len(problem.world.obstacles) + sum(b.prescribed for b in problem.bodies),
            bodies_with_shapes=sum(bool(b.shapes) and not b.prescribed for b in problem.bodies),
            scales=dict(zip(problem.model.state_names, problem.scales.tolist(), strict=True)),
            parameters=_parameters(scenario.system),
            bounds=dict(scenario.bounds),
            requirements=(*(r.name for r in problem.machine.requirements), *asked),
            sensed=problem.world.sensed,
        )

    def __str__(self) -> str:
        """Say all of them in a few lines."""
        shaped, obstacles = self.bodies_with_shapes, self.obstacles
        limits = {name: "{:g} to {:g}".format(*pair) for name, pair in self.bounds.items()}
        return "\n".join(
            [
                f"truth: {self.truth}",
                f"goal within {_listed(self.goal_tolerances)}",
                f"clearance of {self.clearance:g} m asked for; obstacles: {obstacles}; bodies with "
                f"shapes: {shaped}",
                f"scales: {_listed(self.scales)}",
                f"parameters set: {_listed(self.parameters)}",
                f"bounds set: {_listed(limits)}",
                f"requirements of the machine: {', '.join(self.requirements) or 'none'}",
                *self.sensed,
            ]
        )


def _parameters(section: SystemSection) -> dict[str, float]:
    """Return the parameters that a scenario sets, of several machines by their names there."""
    found = dict(section.parameters)
    for name, one in (section.machines or {}).items():
        found |= {f"{name}_{key}": value for key, value in one.parameters.items()}
    return found


def _listed(values: Mapping[str, float | str]) -> str:
    each = (value if isinstance(value, str) else f"{value:g}" for value in values.values())
    return ", ".join(map(" ".join, zip(values, each, strict=True))) or "none"


def _targets(problem: PlanningTask) -> Iterator[str]:
    """Yield names of all targets of the goal, in the order of its errors."""
    goal, bodies = problem.goal, problem.bodies
    yield from (problem.model.state_names[i] for i in goal.indices)
    yield from (target.part.name for target in goal.parts)
    for k, point in enumerate(goal.points, start=1):
        yield f"point {k} ({bodies[point.body].name})"
    for k, direction in enumerate(goal.directions, start=1):
        yield f"direction {k} ({bodies[direction.body].name})"
    yield from (bodies[one.body].name for one in goal.formulas)
