"""Who is to blame for what a compiled loop refused.

The loop counts causes and does not ask for names. So motions like its own are made again, a few of
them, by the propagator that does.
"""

from __future__ import annotations

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.search.planner import Budget
from kinolab.search.tree.tree import Tree
from kinolab.simulation import Propagator

MAX_MOTIONS = 100  # that are made
MAX_SECONDS = 0.02  # [s] that they may take after the search's time


def rejection_sources(
    problem: PlanningTask, nodes: Tree, max_steps: int, budget: Budget
) -> dict[str, dict[str, float]]:
    """Return by cause and culprit the share of what is refused, as ``Rejections.shares``.

    Args:
        problem: What was planned.
        nodes: That motions begin from, one at least.
        max_steps: For how many steps an input is held at most.
        budget: Of the search that is over; few motions are made where no time is left.
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
