"""What one should know about a problem before a search, in sentences."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.dynamics.codegen.state_space import TURN
from kinolab.problem import PlanningTask
from kinolab.problem.static_holding import rest_warnings


def problem_warnings(problem: PlanningTask) -> tuple[str, ...]:
    """Return what may not be meant as it is written, and where the machine cannot rest."""
    return (*problem.world.warnings, *_degrees(problem), *rest_warnings(problem))


def _degrees(problem: PlanningTask) -> Iterator[str]:
    """Yield angles of start and goal that look like degrees: whole numbers beyond a turn."""
    goal, scenario = problem.scenario.goal.model_extra or {}, problem.scenario
    angles = [
        name
        for name, circular in zip(problem.model.state_names, problem.circular, strict=True)
        if circular
    ]
    for section, values in (("start", scenario.start), ("goal", goal)):
        for name in angles:
            value = values.get(name)
            if isinstance(value, int | float) and abs(value) > TURN and value == round(value):
                yield (
                    f"[{section}] {name} = {value:g} is in rad, more than a whole turn; "
                    f'"{value:g} deg" is in degrees.'
                )
