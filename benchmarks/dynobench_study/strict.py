"""The stricter judgement: kinolab's verifier, and a goal thirty times as small."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinolab.problem import PlanningTask
from kinolab.scenario.dynobench import MACHINES

EXACTLY = 1e-3  # largest sum of the weighted deviations from the goal's centre
ROTATION = 2.0  # goals measure the whole angle of a turn, the benchmark half of it


def strictly(problem: PlanningTask) -> PlanningTask:
    """Return a problem whose goal region is where the weighted deviations add up to EXACTLY.

    The weights are those of the benchmark's distance; that takes the Euclidean norm of some of the
    deviations, which is never larger than their sum.
    """
    weights, goal = MACHINES[problem.system.name].weights, problem.goal
    named = [problem.model.state_names[k] for k in goal.indices]
    attitudes = tuple(
        replace(one, tolerance=ROTATION * EXACTLY / weights[one.part.name]) for one in goal.parts
    )
    tolerances = np.array([EXACTLY / weights[name] for name in named])
    return replace(problem, goal=replace(goal, tolerances=tolerances, parts=attitudes, norm="sum"))


def miss(problem: PlanningTask, x: np.ndarray) -> float:
    """Return the sum of the weighted deviations of a state (nx,) from the goal's centre."""
    return EXACTLY * strictly(problem).goal_excess(x)
