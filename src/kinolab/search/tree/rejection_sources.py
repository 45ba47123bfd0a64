"""Rejection sources of a compiled search.

The compiled loop counts causes but records no sources. So a few similar motions are repeated by the
propagator, which records them.
"""

from __future__ import annotations

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.search.planner import Budget
from kinolab.search.tree.tree import Tree
from kinolab.simulation import Propagator

MAX_MOTIONS = 100  # to repeat
MAX_SECONDS = 0.02  # [s] allowed for them beyond the search's time limit


def rejection_sources(
    problem: PlanningTask, nodes: Tree, max_steps: int, budget: Budget
) -> dict[str, dict[str, float]]:
    """Estimate the fractions of rejections by cause and source, as ``Rejections.shares``.

    Args:
        problem: The planning problem.
        nodes: Nodes that motions begin from, at least one.
        max_steps: Maximum control duration in steps.
        budget: Of the finished search; if no time is left, few motions are made.
    """
    with budget.preparing():
        generator, judge = np.random.default_rng(0), Propagator(problem)
    lower, upper = problem.model.control_bounds.T
    for node in generator.integers(nodes.size[0], size=MAX_MOTIONS):
        if budget.elapsed > budget.time_limit + MAX_SECONDS:
            break
        x, u = nodes.x[node].tolist(), generator.uniform(lower, upper).tolist()
        for _ in range(generator.integers(max_steps) + 1):
            x, free = judge.step(x, u, problem.step)
            if not free:
                break
    return judge.rejections.shares()
