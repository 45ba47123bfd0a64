"""Why motions of a search are rejected, and by what."""

from __future__ import annotations

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.budget import Budget
from kinolab.simulation import Propagator


def rejection_sources(
    problem: PlanningTask, states: Array, max_steps: int, budget: Budget
) -> dict[str, dict[str, float]]:
    """Estimate the fractions of rejections by cause and source, as ``Rejections.shares``.

    Args:
        states: From which motions begin, shape (n, nx), at least one.
        max_steps: Maximum control duration in steps.
        budget: Of the finished search; if no time is left, few motions are made.
    """
    with budget.preparing():
        generator, judge = np.random.default_rng(0), Propagator(problem)
    lower, upper = problem.model.control_bounds.T
    # a few similar motions are repeated: the compiled loop counts causes, not their sources
    for node in generator.integers(len(states), size=100):
        # [s] allowed for them beyond the search's time limit
        if budget.elapsed > budget.time_limit + 0.02:
            break
        x, u = states[node].tolist(), generator.uniform(lower, upper).tolist()
        for _ in range(generator.integers(max_steps) + 1):
            x, free = judge.step(x, u, problem.step)
            if not free:
                break
    return judge.rejections.shares()
