"""Make a motion cost less, where its cost is a state of the machine: its duration is free.

It begins with few knots, where most is gained in little time, and takes longer and longer ways of
the same motion while that pays: a motion of least time is rarely near one of least effort.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from kinolab.concurrency.cancel import never_cancelled
from kinolab.problem import PlanningTask
from kinolab.problem.objective.costed import costed
from kinolab.problem.time_steps import covering_steps
from kinolab.simulation.reference import DivergedError, resimulate, trajectory_under
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.exact import connect_to_goal
from kinolab.trajopt.exact.segments import Segments, SlidingWindow, is_long
from kinolab.trajopt.nlp.decision import Knots, even_knots, resampled
from kinolab.trajopt.nlp.dynamics_constraint import refined, true_trajectory
from kinolab.trajopt.nlp.feasibility_check import (
    excess_between_knots,
    satisfies_all,
    satisfies_all_at_knots,
)
from kinolab.trajopt.nlp.goal_constraint import meets_centre
from kinolab.trajopt.nlp.options import SHORT, SQP
from kinolab.trajopt.nlp.problem import NO_EXCESS, TrajectoryProblem, most_time, usual_room
from kinolab.trajopt.shortening.phases import phases_of, shortened_phases
from kinolab.trajopt.sqp.minimum_cost import minimize_cost
from kinolab.trajopt.sqp.restoration import make_knots_exact, restore_feasibility


def cheapened(
    problem: PlanningTask, trajectory: Trajectory, over: Callable[[], bool]
) -> Iterator[Trajectory]:
    """Yield motions that cost less and less, each as soon as there is one.

    Args:
        problem: The problem that they solve, with an [objective].
        trajectory: A motion that solves it, its cost not among its states.
        over: Whether to give up; asked before each subproblem.
    """
    priced = costed(problem)
    if priced is None or not len(trajectory.inputs):
        return
    try:
        given = resimulate(priced, trajectory.t, trajectory.inputs)
    except DivergedError:
        return
    cost = priced.cost_of(given)
    if not cost > 0.0:
        return  # nothing costs less
    scales = priced.scales.copy()
    scales[priced.cost_entry] = cost
    priced = replace(priced, scales=scales)
    if problem.machine.modes:
        phases = phases_of(priced, given)
        found = shortened_phases(priced, phases, lambda: math.inf if over() else 0.0)
        yield from (without_cost(problem, motion) for motion in found)
        return
    whole = _whole(problem, priced, given, over)
    if whole is not None:
        yield whole
    elif is_long(priced, given):
        yield from _swept(problem, priced, given, over)


def _whole(
    problem: PlanningTask, priced: PlanningTask, given: Trajectory, over: Callable[[], bool]
) -> Trajectory | None:
    """Return a motion that costs less, all of it optimised at once; None if that fails.

    What is cheaper by the time that it is over is still made exact, which takes little longer.
    """
    cost, excess, clearances = priced.cost_of(given), NO_EXCESS, list(SHORT.short_clearances)
    guess, room = _with_few_knots(priced, given, over), usual_room(problem)
    if guess is None and is_long(priced, given):
        return None
    while clearances:
        late = over()
        task = TrajectoryProblem(
            priced, clearances[0], room=room, cancelled=never_cancelled if late else over
        ).tightened(excess)
        knots = guess and make_knots_exact(task, guess, iterations=20)
        if knots is None and not late:
            knots = make_knots_exact(task, even_knots(priced, given))
        passed = NO_EXCESS
        if knots is not None:
            guess = knots if late else _cheaper(task, knots)
            made = true_trajectory(priced, guess)
            if made is not None and priced.cost_of(made) < cost:
                if satisfies_all(task, made):
                    return without_cost(problem, made)
                passed = excess_between_knots(task, made)
        if passed:
            excess += passed
        elif late:
            break
        else:
            clearances.pop(0)
            room = 0.0
    return None


def _swept(
    problem: PlanningTask, priced: PlanningTask, given: Trajectory, over: Callable[[], bool]
) -> Iterator[Trajectory]:
    """Yield motions that cost less, after each sweep over their segments."""
    room, clearance = usual_room(problem), SHORT.segment_clearances[0]
    segments, motion = Segments(priced, clearance, over, room), given
    window, best = SlidingWindow(segments), priced.cost_of(given)
    while not over():
        before = priced.cost_of(motion)
        segments.spare = most_time(problem) - motion.duration
        for cheaper in window.sweep(motion):
            motion = cheaper
            segments.spare = most_time(problem) - motion.duration
        try:
            motion = resimulate(priced, motion.t, motion.inputs)
        except DivergedError:
            return
        if not meets_centre(priced, motion.x[-1]):
            ended = connect_to_goal(priced, motion, over)
            if ended is None:
                return
            motion = ended
        cost = priced.cost_of(motion)
        if cost < best and satisfies_all_at_knots(segments.task, motion):
            best = cost
            yield without_cost(problem, motion)
        if cost > (1 - SHORT.min_sweep_gain) * before:
            return


def without_cost(problem: PlanningTask, motion: Trajectory) -> Trajectory:
    """Return a motion of a problem's own machine: of the same, its cost so far no state."""
    priced = costed(problem)
    assert priced is not None
    x = np.delete(motion.x, priced.cost_entry or 0, axis=1)
    return trajectory_under(problem.model, motion.t, x, motion.inputs)


def _with_few_knots(
    problem: PlanningTask, given: Trajectory, over: Callable[[], bool]
) -> Knots | None:
    """Make a motion cheap on a coarse grid; return the result in single steps, or None."""
    room, (t, x, u) = usual_room(problem), (given.t, given.x, given.inputs)
    task = TrajectoryProblem(problem, SHORT.coarse_clearance, room=room, cancelled=over)
    block = max(round(len(u) / SHORT.coarse_knots), 1)
    while not over():
        few = resampled(t, x, u, math.ceil(len(u) / block), problem.space)
        knots = _exact(task, few, block)
        if knots is not None:
            return refined(problem, _cheaper(task, knots, block), block)
        if block == 1 or is_long(problem, given):
            break  # the rest takes as long as sweeping over its segments does
        block //= 2
    return None


def _exact(task: TrajectoryProblem, guess: Knots, block: int) -> Knots | None:
    eased = SHORT.eased[0] * guess.h, min(SHORT.eased[1] * guess.h, _longest(task, guess, block))
    return restore_feasibility(
        task, guess, iterations=15, times=block, lengths=eased, enough=SQP.closure_tolerance
    )


def _longest(task: TrajectoryProblem, knots: Knots, block: int) -> float:
    """Return how long the steps between so many knots may be in [s]."""
    most, step = most_time(task.problem), block * task.problem.step
    return max(min(step, most / len(knots.u)), knots.h)


def _cheaper(task: TrajectoryProblem, knots: Knots, block: int = 1) -> Knots:
    """Return feasible knots that cost less, or the same ones; of any duration, if that is free."""
    price, best = task.problem.cost_of, knots
    for _ in range(SHORT.max_rounds):
        if task.cancelled():
            break
        longest = _longest(task, knots, block)
        shortest = knots.h if task.discrete else SHORT.min_duration * knots.h
        made = minimize_cost(task, knots, (shortest, longest), times=block)
        gained = price(made) < (1 - SHORT.min_round_gain) * price(best)
        best = made if price(made) < price(best) else best
        if task.discrete or not gained or made.h < (1 - SHORT.min_round_gain) * longest:
            break  # it would not take longer if it might
        longer = _slower(task, made, block)
        if longer is None:
            break
        knots = longer
    return best


def _slower(task: TrajectoryProblem, knots: Knots, block: int) -> Knots | None:
    """Return a motion with more knots on the same path that takes longer, if it may."""
    step, model = block * task.problem.step, task.problem.model
    # The next guess is 1.3 times as long, while motions that may take their time cost less
    most = min(1.3 * knots.duration, most_time(task.problem))
    if most <= (1 + SHORT.min_round_gain) * knots.duration:
        return None
    count = max(covering_steps(most, step), len(knots.u))
    guess = knots.in_steps(count, task.problem.space)
    x, rates = guess.x.copy(), slice(model.nq, model.nq + model.nv)
    x[:, rates] *= knots.duration / most
    return _exact(task, Knots(x, guess.u, most / count), block)
