"""From a guess that breaks everything to a motion that breaks nothing: direct multiple shooting.

First with few knots, between which the inputs are held for several steps of the problem; then with
a knot after every step. Where a motion would make errors grow too much to be repeated, a faster one
is looked for in between.

Source: Bock, Plitt, A multiple shooting algorithm for direct solution of optimal control problems,
IFAC 1984.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from kinolab.problem import Problem
from kinolab.simulation.reference import trajectory_under
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact import make_exact
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.options import GUESS, SQP
from kinolab.trajopt.sqp.minimum_time import minimize_time
from kinolab.trajopt.sqp.restoration import restore_feasibility


def shoot(
    problem: Problem,
    guess: Knots,
    block: int,
    iterations: int,
    cancelled: Callable[[], bool] = lambda: False,
) -> Trajectory | None:
    """Return a motion from the start exactly into the goal's centre, or None.

    Args:
        problem: To solve.
        guess: To begin with.
        block: Steps of the problem from knot to knot.
        iterations: Largest number of subproblems with few knots.
        cancelled: Whether to give up.
    """
    task = TrajectoryProblem(problem, GUESS.clearance)
    knots = _closed(task, guess, block, iterations, cancelled)
    if knots is None:
        return None
    given = _step_by_step(task, knots, block)
    motion = given if task.repeatable(given) else _faster(task, knots, block, cancelled)
    return (
        None
        if motion is None
        else make_exact(problem, motion, cancelled, GUESS.fine_iterations, held=True)
    )


def _closed(
    task: TrajectoryProblem,
    guess: Knots,
    block: int,
    iterations: int,
    cancelled: Callable[[], bool],
) -> Knots | None:
    """Return knots of the same step length from which hardly anything is missing, or None."""
    return restore_feasibility(
        task, guess, cancelled, iterations=iterations, times=block,
        enough=GUESS.few_knots_tolerance / 10, most=GUESS.few_knots_tolerance,
        pace=SQP.min_decrease,
    )  # fmt: skip


def _step_by_step(task: TrajectoryProblem, knots: Knots, block: int) -> Trajectory:
    fine, model = task.refined(knots, block), task.problem.model
    t = fine.h * np.arange(len(fine.u) + 1.0)
    return trajectory_under(model, t, fine.x, fine.u)


def _faster(
    task: TrajectoryProblem, knots: Knots, block: int, cancelled: Callable[[], bool]
) -> Trajectory | None:
    """Return a faster motion in whole steps of the problem, fewer per knot; or None."""
    exact = _closed(task, knots, block, GUESS.fine_iterations, cancelled)
    if exact is None:
        return None
    scaling = task.scaling(GUESS.min_repeatable * knots.h, knots.h)
    fast = minimize_time(task.transcription(exact, block), exact, scaling, cancelled=cancelled)
    h = task.problem.step
    block = max(1, math.floor(fast.h / h))
    steps = math.ceil(fast.duration / (block * h))
    guess = fast.in_steps(steps, task.problem.space)
    found = _closed(
        task, Knots(guess.x, guess.u, block * h), block, GUESS.fine_iterations, cancelled
    )
    return None if found is None else _step_by_step(task, found, block)
