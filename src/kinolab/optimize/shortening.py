"""A motion made shorter: faster with the same number of steps, then as fast with fewer of them."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from kinolab.optimize.allowance import Spent, seconds_of_this_thread
from kinolab.optimize.knots import Knots, resampled
from kinolab.optimize.quickening import quicken
from kinolab.optimize.repairing import FEWEST, ROOMS, exact, knots_of
from kinolab.optimize.task import Task
from kinolab.problem import Problem
from kinolab.trajectory import Trajectory

FIRST = 0.8  # share of the time for the first try; later ones begin with what it found
AT_ONCE = 0.7  # share of the step length below which there are fewer steps before it goes on
ROUNDS = 20
TRIES = 4  # numbers of steps that are tried at most
GAIN = 1e-3  # share of the duration that is worth another round


def shorten(problem: Problem, trajectory: Trajectory, seconds: float | Spent) -> Trajectory:
    """Return a shorter motion, or the one that was given.

    Args:
        problem: That the trajectory solves.
        trajectory: Exact or not; what is returned in its place is exact.
        seconds: Of this thread's time that may be spent; or what tells the share that is spent of
            whatever is allowed, and is asked before each subproblem.
    """
    if isinstance(seconds, int | float):
        seconds = seconds_of_this_thread(seconds).part()
    spent: Spent = seconds

    def late() -> bool:
        return spent() >= FIRST

    def over() -> bool:
        return spent() >= 1.0

    guess = None
    for room in ROOMS:
        task = Task(problem, room)
        if not task.possible or not len(trajectory.u) or over():
            break
        knots = exact(task, guess or knots_of(problem, trajectory), over)
        if knots is None:
            continue
        guess = _shorter(task, knots, late)
        made = task.trajectory(guess)
        shorter = made is not None and made.duration < trajectory.duration
        if made is not None and shorter and task.keeps_all(made):
            return made
    return trajectory


def _shorter(task: Task, knots: Knots, late: Callable[[], bool]) -> Knots:
    """Return exact knots of a shorter duration, or the same ones."""
    for _ in range(ROUNDS):
        if late():
            break
        before = knots.duration
        longest = task.problem.step
        scaling = task.scaling(min(AT_ONCE * longest, knots.h), longest)
        fast = quicken(task.transcription(knots), knots, scaling, late=late)
        knots = _with_fewer_steps(task, fast, knots, late)
        if knots.duration > before * (1 - GAIN):
            break
    return knots


def _with_fewer_steps(task: Task, fast: Knots, slow: Knots, late: Callable[[], bool]) -> Knots:
    """Return the fast motion in steps of the problem's length, the slow one where that fails."""
    h = task.problem.step
    fewest = max(math.ceil(fast.duration / h - 1e-6), FEWEST)
    if not task.discrete:
        if fewest > 0.8 * len(fast.u):
            return fast
        return _in(task, fast, fewest, late) or fast
    count, most = fewest, len(slow.u)
    for attempt in range(TRIES):
        if count >= most or late():
            break
        found = _in(task, fast, count, late)
        if found is not None:
            return found
        count += max(1, math.ceil(0.02 * 2**attempt * count))
    return slow


def _in(task: Task, fast: Knots, count: int, late: Callable[[], bool]) -> Knots | None:
    """Return a motion in so many steps, each as long as the problem's or less; None if it fails."""
    steps = fast.h * np.arange(len(fast.u) + 1.0)
    attitudes = tuple(task.problem.model.attitudes.values())
    guess = resampled(steps, fast.x, fast.u, count, attitudes)
    h = task.problem.step if task.discrete else guess.h
    return exact(task, Knots(guess.x, guess.u, h), late, iterations=20)
