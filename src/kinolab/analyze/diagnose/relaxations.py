"""Relaxations of a problem, one at a time, that may make it solvable."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import copy
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.problem.goal import Goal
from kinolab.problem.machines.standing import standing
from kinolab.search import AbstractPlanner
from kinolab.simulation import stiffness

OBSTACLES = "obstacles"  # name of the change that leaves them out
TOLERANCE_FACTOR = 3.0  # factor on the goal's tolerances
INPUT_LIMIT_FACTOR = 2.0  # factor on the inputs' limits
STEP_DIVISOR = 4  # by which a step is divided


@dataclass(frozen=True, eq=False)
class Relaxation:
    """A problem with one change.

    Attributes:
        name: What was changed, in a word or two.
        words: The change as one types or says it, after "with" or "without".
        problem: The changed problem.
        settings: Planner settings that differ.
    """

    name: str
    words: str
    problem: PlanningTask
    settings: Mapping[str, Any]


def relaxations(problem: PlanningTask, planner: AbstractPlanner) -> Iterator[Relaxation]:
    """Yield every change that applies to a problem and to the planner that failed on it.

    If steps are unstable, only changes of the integration are meaningful.
    """
    if stiffness(problem) is not None:
        words = "with --set integration.method=rosenbrock"  # for stiff machines
        yield Relaxation("method", words, _integrated(problem, method="rosenbrock"), {})
        yield _finer_steps(problem, planner)
        return
    still, names = standing(problem), moving_obstacles(problem)
    if problem.world.obstacles:
        empty, which = replace(problem.world, obstacles=()), " that stand" if names else ""
        words = f"without the obstacles{which}"
        yield Relaxation(OBSTACLES, words, replace(problem, world=empty), {})
    if still is not None:
        moving = f"without {' and '.join(names)}, which move{'s' if len(names) == 1 else ''},"
        yield Relaxation("moving obstacles", moving, still, {})
    wider = replace(problem, goal=_wider_goal(problem.goal))
    yield Relaxation(
        "tolerance", f"with {TOLERANCE_FACTOR:g} times the goal's tolerances", wider, {}
    )
    strong = copy(problem.model)
    strong.control_bounds = INPUT_LIMIT_FACTOR * strong.control_bounds  # one-sided ones remain so
    words = f"with {INPUT_LIMIT_FACTOR:g} times the inputs' limits"
    yield Relaxation("limits", words, replace(problem, model=strong), {})
    longest = getattr(planner, "max_steps", None)
    if longest is not None:
        longer = {"max_steps": 3 * longest}  # factor on how long a control may last
        words = f"with {_options(longer)} instead of {longest}"
        yield Relaxation("longer controls", words, problem, longer)
    if problem.scenario.integration.truth == "continuous":
        yield _finer_steps(problem, planner)


def moving_obstacles(problem: PlanningTask) -> tuple[str, ...]:
    """Return the names of the obstacles that move."""
    return tuple(body.name for body in problem.bodies if body.prescribed)


def _wider_goal(goal: Goal) -> Goal:
    return replace(
        goal,
        tolerances=TOLERANCE_FACTOR * goal.tolerances,
        points=tuple(replace(p, tolerance=TOLERANCE_FACTOR * p.tolerance) for p in goal.points),
        formulas=tuple(replace(p, tolerance=TOLERANCE_FACTOR * p.tolerance) for p in goal.formulas),
        directions=tuple(replace(d, tolerance=_turn(d.tolerance)) for d in goal.directions),
        parts=tuple(replace(part, tolerance=_turn(part.tolerance)) for part in goal.parts),
    )


def _turn(tolerance: float) -> float:
    return min(TOLERANCE_FACTOR * tolerance, np.pi)


def _finer_steps(problem: PlanningTask, planner: AbstractPlanner) -> Relaxation:
    """Return the problem with shorter steps and the same control durations."""
    step = problem.step / STEP_DIVISOR
    known = {field.name for field in fields(planner)}
    settings: dict[str, Any] = {
        name: STEP_DIVISOR * getattr(planner, name)
        for name in ("min_steps", "max_steps")
        if name in known
    }
    words = f"with --set integration.step={step:g} instead of {problem.step:g}"
    if settings:
        words += f" (and {_options(settings)}, so that controls last as long)"
    return Relaxation("step", words, _integrated(problem, step=step), settings)


def _options(settings: Mapping[str, Any]) -> str:
    """Return the options of the command line that change settings of the planner."""
    return " ".join(f"--set planner.{name}={value}" for name, value in settings.items())


def _integrated(problem: PlanningTask, **update: Any) -> PlanningTask:
    """Return the problem with other settings of [integration]."""
    scenario = problem.scenario
    integration = scenario.integration.model_copy(update=update)
    changed = scenario.model_copy(update={"integration": integration})
    return replace(problem, scenario=changed.located(scenario.origin))
