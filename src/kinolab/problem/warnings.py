"""What one should know about a problem before a search, in sentences."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.dynamics.codegen.state_space import TURN
from kinolab.dynamics.facts.machine_facts import MachineFacts
from kinolab.problem import PlanningTask
from kinolab.problem.static_holding import rest_warnings
from kinolab.scenario.locations import place_text
from kinolab.scenario.schema import ALL


def problem_warnings(problem: PlanningTask) -> tuple[str, ...]:
    """Return what may not be meant as it is written, and where the machine cannot rest."""
    return (
        *problem.world.warnings,
        *_degrees(problem),
        *_tolerances_of_nothing(problem),
        *_rest_where_it_may_not_end(problem),
        *_without_derivative(problem),
        *machine_warnings(problem.machine),
        *rest_warnings(problem),
    )


def machine_warnings(machine: MachineFacts) -> Iterator[str]:
    """Yield what readers of files know: what they do not read, and which bodies may touch."""
    yield from (sentence for name, sentence in machine.notes if not name)
    pairs = [f"{a} and {b}" for a, b in machine.unwatched]
    if pairs:
        rest = f", and {len(pairs) - 5} further pairs" if len(pairs) > 5 else ""
        yield f"These bodies may touch each other unnoticed: {'; '.join(pairs[:5])}{rest}."


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


def _without_derivative(problem: PlanningTask) -> Iterator[str]:
    """Yield that planning by derivatives cannot begin at the start, such as from rest."""
    slopes = np.hstack(problem.model.jacobian(problem.start, problem.model.null_control()))
    for k in np.flatnonzero(~np.isfinite(slopes).all(axis=1))[:1]:
        yield (
            f"The rate of {problem.model.state_names[k]} has no derivative at the start, which "
            "planning needs: write sqrt(v**2 + epsilon**2) for sqrt(v**2), with a small epsilon."
        )


def _tolerances_of_nothing(problem: PlanningTask) -> Iterator[str]:
    """Yield tolerances of what the goal leaves free."""
    section, names = problem.scenario.goal, problem.model.state_names
    wanted = {*(names[i] for i in problem.goal.indices), *section.values}
    for name in section.tolerance if isinstance(section.tolerance, dict) else ():
        begun = name.removesuffix(ALL)
        if name not in wanted and not (begun != name and any(w.startswith(begun) for w in wanted)):
            yield (
                f"[goal] tolerance.{name} counts for nothing, since the goal leaves {name} free; "
                f"write {name} = value below [goal]."
            )


def _rest_where_it_may_not_end(problem: PlanningTask) -> Iterator[str]:
    """Yield that of several goals in any order the last may be one that asks for no rest."""
    *on_the_way, last = problem.scenario.goals.items()
    moving = [place_text(place) for place, goal in on_the_way if not goal.at_rest]
    if last[1].at_rest and last[1].order == "any" and moving:
        yield (
            f"In any order the motion may end in {' or '.join(moving)}, and need not be at rest "
            "there: write at_rest = true in each goal where it shall be."
        )
