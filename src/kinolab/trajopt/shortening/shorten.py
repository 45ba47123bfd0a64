"""A motion made shorter: faster with the same number of steps, then as fast with fewer of them.

It is made faster with few knots first, where most is gained in little time.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from kinolab.problem import Problem
from kinolab.search.budget import Spent, seconds_of_this_thread, seldom
from kinolab.trajectory import Trajectory
from kinolab.trajopt.connect_to_goal import in_the_centre
from kinolab.trajopt.exact import FEWEST, exact, is_long, knots_of
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.problem import Task
from kinolab.trajopt.shortening.shorten_in_pieces import condensed
from kinolab.trajopt.sqp.minimum_time import NEAR, quicken
from kinolab.trajopt.sqp.restoration import restored

ROOMS = (7e-2, 2e-2, 4e-2, 2e-3)  # of the machine's size, tried one after the other
FEW = 50  # knots, more or less, of the first motion that is made faster
SHORTEST = 0.1  # times its duration: how short it may get
PIECEWISE = 0.9  # share of the time for pieces of a long motion, as long as they get shorter
UNTIL_EXACT = 0.7  # the same where its end is not exact yet, which takes time too
SMALL = 5  # subproblems of pieces count as one
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

    if not len(trajectory.inputs):
        return trajectory
    if is_long(problem, trajectory):
        share = PIECEWISE if in_the_centre(problem, trajectory.x[-1]) else UNTIL_EXACT
        enough = seldom(lambda: spent() >= share, SMALL)
        trajectory = condensed(problem, trajectory, enough, seldom(over, SMALL))
        if late():
            return trajectory
    guess, best = _with_few_knots(problem, trajectory, late), trajectory
    for room in ROOMS:
        if over():
            break
        task = Task(problem, room)
        knots = guess and _in_steps(task, guess, len(trajectory.inputs), over)
        knots = knots or exact(task, knots_of(problem, trajectory), over)
        if knots is None:
            continue
        first = _better(task, knots, best)
        guess = _shorter(task, knots, late)
        best = _better(task, guess, first)
        if first is not trajectory or best is not trajectory:
            break
    return best


def _better(task: Task, knots: Knots, best: Trajectory) -> Trajectory:
    """Return the true motion under the inputs of knots where it is shorter and keeps everything."""
    if not knots.duration < best.duration:
        return best
    made = task.trajectory(knots)
    return made if made is not None and task.keeps_all(made) else best


def _with_few_knots(
    problem: Problem, trajectory: Trajectory, late: Callable[[], bool]
) -> Knots | None:
    """Return a fast motion under inputs that are held for several steps each, step by step."""
    task, block = Task(problem, ROOMS[1]), round(len(trajectory.inputs) / FEW)
    while block > 1 and not late():
        knots = _closed(task, trajectory, block, late)
        if knots is not None:
            scaling = task.scaling(SHORTEST * knots.h, knots.h)
            fast = quicken(task.transcription(knots, block), knots, scaling, late=late)
            return task.refined(fast, block)
        block //= 2
    return None


def _closed(
    task: Task, trajectory: Trajectory, block: int, late: Callable[[], bool]
) -> Knots | None:
    """Return exact knots of so many steps each, None where there are none near a motion."""
    count = math.ceil(len(trajectory.inputs) / block)
    space = task.problem.space
    few = resampled(trajectory.t, trajectory.x, trajectory.inputs, count, space)
    lengths = (0.9 * few.h, 1.1 * few.h)
    return restored(
        task, few, late, iterations=15, times=block, lengths=lengths, enough=NEAR, most=NEAR
    )


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
    return _in_steps(task, fast, len(slow.u), late) or slow


def _in_steps(task: Task, fast: Knots, most: int, late: Callable[[], bool]) -> Knots | None:
    """Return a motion in steps of the problem's length, fewer than a number of them; or None."""
    count = max(math.ceil(fast.duration / task.problem.step - 1e-6), FEWEST)
    for attempt in range(TRIES):
        if count >= most or late():
            break
        found = _in(task, fast, count, late)
        if found is not None:
            return found
        count += max(1, math.ceil(0.02 * 2**attempt * count))
    return None


def _in(task: Task, fast: Knots, count: int, late: Callable[[], bool]) -> Knots | None:
    """Return a motion in so many steps, each as long as the problem's or less; None if it fails."""
    guess = fast.in_steps(count, task.problem.space)
    h = task.problem.step if task.discrete else guess.h
    return exact(task, Knots(guess.x, guess.u, h), late, iterations=20)
