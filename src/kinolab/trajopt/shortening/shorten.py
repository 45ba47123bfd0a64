"""Shorten a trajectory: minimise time at a fixed number of steps, then reduce the number of steps.

This starts on a coarse grid, where most is gained in little time. Long motions first undergo
rounds of shortcuts, cycle removal and minimum-time segments.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

from kinolab.concurrency.cancel import throttled
from kinolab.numerics.work import counted_work
from kinolab.problem import PlanningTask
from kinolab.problem.time_steps import covering_steps
from kinolab.search.budget import Budget
from kinolab.simulation.reference import DivergedError, resimulate
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.exact import connect_to_goal
from kinolab.trajopt.exact.segments import Segments, SlidingWindow, is_long
from kinolab.trajopt.nlp.decision import Knots, even_knots, resampled
from kinolab.trajopt.nlp.dynamics_constraint import is_motion, refined, true_trajectory
from kinolab.trajopt.nlp.feasibility_check import (
    excess_between_knots,
    satisfies_all,
    satisfies_all_at_knots,
)
from kinolab.trajopt.nlp.goal_constraint import meets_centre
from kinolab.trajopt.nlp.options import END, SHORT, SQP
from kinolab.trajopt.nlp.problem import (
    NO_EXCESS,
    Excess,
    Minimised,
    TrajectoryProblem,
    nobody_asks,
    usual_room,
)
from kinolab.trajopt.shortening.cycles import cycles_removed
from kinolab.trajopt.shortening.phases import phases_of, shortened_phases
from kinolab.trajopt.shortening.shortcuts import Shortcuts
from kinolab.trajopt.sqp.minimum_cost import minimize_cost
from kinolab.trajopt.sqp.restoration import make_knots_exact, restore_feasibility


def shorten(
    problem: PlanningTask, trajectory: Trajectory, seconds: float | Callable[[], float]
) -> Trajectory:
    """Return a shorter motion, or the given one.

    Args:
        problem: The problem that the trajectory solves.
        trajectory: Exact or not; a shorter result is exact.
        seconds: Budget in [s] of work, which an idle computer takes about; or a function that
            returns the fraction of the budget spent, called before each subproblem.
    """
    with counted_work() as work:
        if isinstance(seconds, int | float):
            seconds = Budget(seconds, clock=lambda: work.seconds).fraction()
        exact = trajectory
        for short in shortened(problem, trajectory, seconds):
            if short.duration < trajectory.duration and (
                meets_centre(problem, short.x[-1]) or not meets_centre(problem, trajectory.x[-1])
            ):
                exact = short
    return exact


def shortened(
    problem: PlanningTask,
    trajectory: Trajectory,
    spent: Callable[[], float],
    minimised: Minimised = nobody_asks,
) -> Iterator[Trajectory]:
    """Yield shorter and shorter motions, each as soon as there is one.

    The last one ends in the goal's centre, if such a motion is found.

    Args:
        problem: The problem that the trajectory solves.
        trajectory: Exact or not.
        spent: Returns the fraction of the budget spent; called before each subproblem.
        minimised: As in ``TrajectoryProblem``.
    """
    if problem.model.nx >= END.many_states:
        return  # one subproblem takes 10 s and more
    phases = phases_of(problem, trajectory) if problem.machine.modes else []
    if len(phases) > 1:
        yield from shortened_phases(problem, phases, spent, minimised)
    else:
        yield from shortened_smooth(problem, trajectory, spent, minimised)


def shortened_smooth(
    problem: PlanningTask,
    trajectory: Trajectory,
    spent: Callable[[], float],
    minimised: Minimised = nobody_asks,
) -> Iterator[Trajectory]:
    """Do what ``shortened`` does for a motion in which no transition takes place."""

    def over() -> bool:
        return spent() >= 1.0

    if not len(trajectory.inputs):
        return
    if is_long(problem, trajectory) and is_motion(problem, trajectory):
        exact = meets_centre(problem, trajectory.x[-1])
        budget = SHORT.segment_budget if exact else SHORT.inexact_segment_budget
        enough = throttled(lambda: spent() >= budget, SHORT.segment_subproblems)
        at_all = throttled(over, SHORT.segment_subproblems)
        for short in _shortened_segments(problem, trajectory, enough, at_all):
            trajectory = short
            yield short
    begun = spent()
    if begun >= 1.0:
        return
    few, first = (begun + part * (1.0 - begun) for part in SHORT.whole_budgets)
    whole = _shorten_whole(
        problem, trajectory, lambda: spent() >= few, lambda: spent() >= first, over, minimised
    )
    if whole is not trajectory:
        yield whole


def _true(problem: PlanningTask, spliced: Trajectory) -> Trajectory | None:
    """Return the true motion under the same inputs; None where it diverges."""
    try:
        return resimulate(problem, spliced.t, spliced.inputs)
    except DivergedError:
        return None


def _shortened_segments(
    problem: PlanningTask,
    given: Trajectory,
    cancelled: Callable[[], bool],
    over: Callable[[], bool],
) -> Iterator[Trajectory]:
    """Shorten a long motion segment by segment; yield what is gained when it is.

    Args:
        problem: The problem that the motion solves.
        given: A dynamically feasible motion.
        cancelled: Whether to stop shortening.
        over: Whether to stop making the shorter motion exact.
    """
    reserve, room = SHORT.segment_clearances[0], usual_room(problem)
    segments, short, last = Segments(problem, reserve, cancelled, room), given, given
    for short in _cut(segments, given):
        motion = _true(problem, short)
        if motion is None or not satisfies_all_at_knots(segments.task, motion):
            continue
        if motion.duration < (1 - SHORT.min_round_gain) * last.duration:
            last = motion
            yield motion
    if short is given or (meets_centre(problem, last.x[-1]) and last.duration <= short.duration):
        return
    motion = _true(problem, short)
    exact = None if motion is None else connect_to_goal(problem, motion, over)
    if exact is not None and (
        exact.duration < last.duration or not meets_centre(problem, last.x[-1])
    ):
        yield exact


def _cut(segments: Segments, given: Trajectory) -> Iterator[Trajectory]:
    """Yield a motion with ever more shortcuts, without loops and with faster segments.

    Where segments join, there may be small defects.
    """
    shortcuts, windows, short = Shortcuts(segments), SlidingWindow(segments), given
    cuts: list[Callable[[Trajectory], Iterator[Trajectory]]] = [
        shortcuts.taken,
        partial(cycles_removed, segments),
        windows.sweep,
    ]
    while not segments.cancelled():
        before = short.duration
        for cut in tuple(cuts):
            last = short
            for shorter in cut(short):
                short = shorter
                yield short
            if short is last:  # it gains nothing the next time either, and takes as long
                cuts.remove(cut)
        if short.duration > (1 - SHORT.min_sweep_gain) * before:
            break


def _shorten_whole(
    problem: PlanningTask,
    given: Trajectory,
    few_enough: Callable[[], bool],
    cancelled: Callable[[], bool],
    over: Callable[[], bool],
    minimised: Minimised,
) -> Trajectory:
    """Shorten a motion as a whole; return the given one if that fails.

    Args:
        problem: The problem that the motion solves.
        given: Exact or not.
        few_enough: Whether to stop doing so on a coarse grid.
        cancelled: Whether to stop shortening.
        over: Whether to stop making the shorter motion exact.
        minimised: As ``shortened`` has it.
    """
    guess, best, excess = _with_few_knots(problem, given, few_enough, minimised), given, NO_EXCESS
    room, most, reserves = usual_room(problem), given.duration, list(SHORT.short_clearances)
    while reserves and not over():
        task = TrajectoryProblem(
            problem, reserves[0], room=room, cancelled=over, minimised=minimised
        )
        task = task.tightened(excess)
        knots = guess and make_knots_exact(task, guess, iterations=20)
        knots = knots or (guess and _in_steps(task, guess, len(given.inputs)))
        knots = knots or make_knots_exact(task, even_knots(problem, given))
        passed = NO_EXCESS
        if knots is not None:
            best, _ = _better(task, knots, best, most)
            guess = _shorter(task.until(cancelled), knots)
            best, passed = _better(task, guess, best, most)
        if passed:  # again, with limits tightened
            excess += passed
        elif best is not given:
            break
        else:  # with smaller gaps
            reserves.pop(0)
            room, most = 0.0, (1 - SHORT.min_reserve_gain) * given.duration
    return best


def _with_few_knots(
    problem: PlanningTask,
    trajectory: Trajectory,
    cancelled: Callable[[], bool],
    minimised: Minimised,
) -> Knots | None:
    """Minimise time on a coarse grid; return the result refined to single steps, or None."""
    room, (t, x, u) = usual_room(problem), (trajectory.t, trajectory.x, trajectory.inputs)
    task = TrajectoryProblem(
        problem, SHORT.coarse_clearance, room=room, cancelled=cancelled, minimised=minimised
    )
    block = round(len(u) / SHORT.coarse_knots)
    while block > 1 and not cancelled():
        few = resampled(t, x, u, math.ceil(len(u) / block), problem.space)
        eased, enough = (SHORT.eased[0] * few.h, SHORT.eased[1] * few.h), SQP.closure_tolerance
        knots = restore_feasibility(
            task, few, iterations=15, times=block, lengths=eased, enough=enough
        )
        if knots is not None:
            lengths = (SHORT.min_duration * knots.h, knots.h)
            return refined(problem, minimize_cost(task, knots, lengths, times=block), block)
        block //= 2
    return None


def _shorter(task: TrajectoryProblem, knots: Knots) -> Knots:
    """Return feasible knots of a shorter duration, or the same ones."""
    for _ in range(SHORT.max_rounds):
        if task.cancelled():
            break
        before = knots.duration
        longest = task.problem.step
        lengths = (min(SHORT.step_reduction * longest, knots.h), longest)
        knots = _with_fewer_steps(task, minimize_cost(task, knots, lengths), knots)
        if knots.duration > before * (1 - SHORT.min_round_gain):
            break
    return knots


def _with_fewer_steps(task: TrajectoryProblem, fast: Knots, slow: Knots) -> Knots:
    """Resample the fast motion to fewer steps; else keep it, or the slow one if discrete."""
    h = task.problem.step
    fewest = max(covering_steps(fast.duration, h), SHORT.min_steps)
    if not task.discrete:
        if fewest > 0.8 * len(fast.u):
            return fast
        return _in(task, fast, fewest) or fast
    return _in_steps(task, fast, len(slow.u)) or slow


def _in_steps(task: TrajectoryProblem, fast: Knots, most: int) -> Knots | None:
    """Return a motion of fewer than ``most`` steps, each at most the problem's; or None."""
    count = max(covering_steps(fast.duration, task.problem.step), SHORT.min_steps)
    for attempt in range(SHORT.max_step_counts):
        if count >= most or task.cancelled():
            break
        found = _in(task, fast, count)
        if found is not None:
            return found
        count += max(1, math.ceil(0.02 * 2**attempt * count))
    return None


def _in(task: TrajectoryProblem, fast: Knots, count: int) -> Knots | None:
    """Return a motion of ``count`` steps, each at most the problem's; None if that fails."""
    guess = fast.in_steps(count, task.problem.space)
    h = task.problem.step if task.discrete else guess.h
    return make_knots_exact(task, Knots(guess.x, guess.u, h), iterations=20)


def _better(
    task: TrajectoryProblem, knots: Knots, best: Trajectory, most: float
) -> tuple[Trajectory, Excess]:
    """Re-simulate knots; return the result if it is feasible and shorter than the best so far.

    Args:
        knots: Of a motion.
        best: What is returned otherwise.
        most: Duration in [s] below which the result must be, too.

    Returns:
        That motion, and how far a refused one passes limits between its knots.
    """
    if not knots.duration < min(best.duration, most):
        return best, NO_EXCESS
    made = true_trajectory(task.problem, knots)
    if made is None:
        return best, NO_EXCESS
    if satisfies_all(task, made):
        return made, NO_EXCESS
    return best, excess_between_knots(task, made)
