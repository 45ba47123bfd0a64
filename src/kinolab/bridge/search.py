"""Run a control planner of OMPL on a problem and read its path."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import util as ou

from kinolab.bridge.bridge import Bridge
from kinolab.problem import Problem
from kinolab.search import Budget, Outcome, SearchResult


def search(
    problem: Problem,
    make: Callable[[Any], Any],
    seed: int,
    budget: Budget,
    *,
    min_steps: int,
    max_steps: int,
) -> SearchResult:
    """Search with the planner that ``make`` returns for a space information.

    The random numbers are seeded before the planner exists, which is what makes OMPL's paths
    repeatable.
    """
    ou.RNG.setSeed(_seed(seed))
    bridge = Bridge(problem, min_steps=min_steps, max_steps=max_steps)
    planner = make(bridge.space_information)
    planner.setProblemDefinition(bridge.problem_definition)
    planner.setup()
    budget.restart()  # code for this machine was compiled and loaded until here
    planner.solve(ob.PlannerTerminationCondition(budget.spent))
    definition = bridge.problem_definition
    durations, controls = _path(definition)
    outcome = _outcome(definition, len(durations), budget)
    t, u = _rows(problem, durations, controls)
    statistics = {f"rejected_by_{cause}": float(n) for cause, n in bridge.rejections.items()}
    return SearchResult(outcome, t, u, budget.iterations, statistics)


def _seed(seed: int) -> int:
    """Return a seed for OMPL, which takes 32 bits and ignores 0."""
    mixed = int(np.random.SeedSequence(seed).generate_state(1)[0])
    return mixed or 1


def _outcome(definition: Any, segments: int, budget: Budget) -> Outcome:
    if definition.hasExactSolution():
        return Outcome.SOLVED
    if budget.interrupted:
        return Outcome.INTERRUPTED
    return Outcome.APPROXIMATE if segments else Outcome.NOT_FOUND


def _path(definition: Any) -> tuple[list[float], list[Any]]:
    if not definition.hasSolution():
        return [], []
    path = definition.getSolutionPath()
    return list(path.getControlDurations()), [
        path.getControl(k) for k in range(path.getControlCount())
    ]


def _rows(problem: Problem, durations: list[float], controls: list[Any]) -> tuple[Any, Any]:
    """Return times and inputs with one row per propagation step."""
    held = []
    for duration, control in zip(durations, controls, strict=True):
        values = [control[i] for i in range(problem.model.nu)]
        held += [values] * round(duration / problem.step)
    u = np.array(held, dtype=float).reshape(len(held), problem.model.nu)
    return problem.step * np.arange(len(held) + 1), u
