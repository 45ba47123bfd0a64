"""The same problem in a world that stands still: without the obstacles that move, and without time."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from kinolab.problem.goal import Goal
from kinolab.problem.task import PlanningTask


@lru_cache(maxsize=8)
def standing(problem: PlanningTask) -> PlanningTask | None:
    """Return the problem whose machine is alone with what stands still; None where nothing moves."""
    if problem.alone is None:
        return None
    whole, model = problem.alone
    (clock,) = problem.model.clocks
    return replace(
        problem,
        machine=whole.machine,
        model=model,
        whole=whole,
        alone=None,
        start=np.delete(problem.start, clock),
        goal=_shifted(problem.goal, clock),
        via=tuple(_shifted(one, clock) for one in problem.via),
        bounds=np.delete(problem.bounds, clock, axis=0),
        rate_bounds=problem.rate_bounds[[n != f"{problem.model.state_names[clock]}_dot" for n in problem.model.rate_names]],
        scales=np.delete(problem.scales, clock),
        weights=np.delete(problem.weights, clock),
        circular=np.delete(problem.circular, clock),
    )


def _shifted(goal: Goal, clock: int) -> Goal:
    """Return a goal in states without the time."""
    return replace(goal, indices=tuple(i - (i > clock) for i in goal.indices))
