"""When a motion reaches each of several goals, in the order written or in any."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.problem.task import PlanningTask

SAME_TIME = 1e-9  # [s]: rounding of sums of steps


def in_legs(problem: PlanningTask) -> bool:
    """Whether there are goals on the way, of which any will do, or in which the machine stays."""
    return bool(problem.via or problem.goal.any_of or problem.scenario.goal.hold)


def each_goal(problem: PlanningTask) -> list[PlanningTask]:
    """Return the problem with each of its goals alone, in the order written."""
    found, goals = list[PlanningTask](), (*problem.via, problem.goal)
    for goal, section in zip(goals, problem.scenario.goals.values(), strict=True):
        alone = section.model_copy(update={"hold": 0.0, "order": "written"})
        scenario = problem.scenario.model_copy(update={"via": (), "goal": alone})
        found.append(replace(problem, goal=goal, via=(), scenario=scenario))
    return found


def ends(problem: PlanningTask) -> list[PlanningTask]:
    """Return the problem with each goal alone of those of which a motion may end in any."""
    any_order = problem.via and problem.scenario.goal.order == "any"
    last = each_goal(problem) if any_order else [problem]
    return [replace(one, goal=goal) for one in last for goal in one.goal.each]


def nearest_end(problem: PlanningTask, x: Array) -> PlanningTask:
    """Return the problem with that goal alone in which a motion to a state (nx,) ends."""
    own = ends(problem)
    return own[0] if len(own) == 1 else min(own, key=lambda one: one.goal_excess(x))


def goals_reached(problem: PlanningTask, t: Array, x: Array) -> list[float]:
    """Return when a motion reaches each goal and stays as long as it must, in [s]; NaN if never.

    The last one of those in an order is reached at the end.

    Args:
        problem: With goals on the way.
        t: Times in [s], shape (N+1,).
        x: States, shape (N+1, nx).
    """
    holds = [section.hold for section in problem.scenario.goals.values()]
    inside = [np.array([one.goal_excess(s) <= 1.0 for s in x]) for one in each_goal(problem)]
    stays = [_stays(t, own, hold) for own, hold in zip(inside, holds, strict=True)]
    if problem.scenario.goal.order == "any":
        return [float(t[np.argmax(one)]) if one.any() else math.nan for one in stays]
    found, after = list[float](), -math.inf
    for one, hold in zip(stays[:-1], holds, strict=False):
        there = one & (t >= after - SAME_TIME)
        found.append(float(t[np.argmax(there)]) if there.any() else math.nan)
        after = found[-1] + hold
    end = float(t[-1]) - holds[-1]
    last = inside[-1][t >= end - SAME_TIME].all() and not end < after - SAME_TIME
    return [*found, end if last else math.nan]


def _stays(t: Array, inside: NDArray[np.bool_], hold: float) -> NDArray[np.bool_]:
    """Return at which times a motion is in a goal, and remains there for so many [s]."""
    leaves = np.append(np.flatnonzero(~inside), len(t))  # knots outside, and none after the end
    first = leaves[np.searchsorted(leaves, np.arange(len(t)))]
    until = np.append(t, t[-1])[first] - np.where(first < len(t), 2 * SAME_TIME, 0.0)
    stays: NDArray[np.bool_] = inside & (until >= t + hold - SAME_TIME)
    return stays
