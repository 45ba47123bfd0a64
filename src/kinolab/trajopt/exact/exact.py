"""Make a trajectory exact: dynamically feasible, and ending in the goal's centre.

Only the tail of a long feasible trajectory is changed, so that it takes no longer than a short one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from kinolab.concurrency.cancel import never_cancelled
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import trajectory_under
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.segments import Segments, is_long
from kinolab.trajopt.exact.single_shooting import end_by_single_shooting
from kinolab.trajopt.nlp.decision import Knots, even_knots
from kinolab.trajopt.nlp.dynamics_constraint import (
    is_motion,
    repeatable,
    smooth_pieces,
    true_trajectory,
)
from kinolab.trajopt.nlp.feasibility_check import (
    excess_between_knots,
    satisfies_all,
    satisfies_all_at_knots,
)
from kinolab.trajopt.nlp.goal_constraint import meets_centre
from kinolab.trajopt.nlp.options import END, SHORT
from kinolab.trajopt.nlp.problem import NO_EXCESS, TrajectoryProblem, usual_room
from kinolab.trajopt.sqp.restoration import make_knots_exact

SLOWER = 1.2  # times as many steps, for a motion too quick to end in the goal's centre


def make_exact(
    problem: PlanningTask,
    trajectory: Trajectory,
    cancelled: Callable[[], bool] = lambda: False,
    iterations: int = 40,
    *,
    held: bool = False,
) -> Trajectory | None:
    """Return a nearby trajectory that ends in the goal's centre, or None.

    Limits, requirements and clearances are satisfied at samples; the verifier decides whether they
    are satisfied in between.

    Args:
        problem: The problem that the trajectory solves approximately.
        trajectory: Initial guess; its start is replaced by the problem's.
        cancelled: Whether to give up.
        iterations: Maximum number of subproblems per clearance margin.
        held: Whether the step length is fixed.
    """
    if problem.model.nx >= END.many_states:
        return end_by_single_shooting(problem, trajectory, cancelled)
    if problem.machine.modes:
        return _after_last_transition(problem, trajectory, cancelled, iterations)
    return _smooth(problem, trajectory, cancelled, iterations, held=held)


def _after_last_transition(
    problem: PlanningTask,
    trajectory: Trajectory,
    cancelled: Callable[[], bool],
    iterations: int,
) -> Trajectory | None:
    """Make a motion exact by changing only what follows its last transition between modes."""
    last = len(trajectory.u)
    pieces = smooth_pieces(problem, trajectory)
    begin = pieces[-1][0] if pieces and pieces[-1][1] == last else last
    piece = _held(problem, trajectory.piece(begin, last))
    if not len(piece.u):
        return None  # a transition is the last that happens
    made = _smooth(replace(problem, start=piece.x[0]), piece, cancelled, iterations)
    return None if made is None else trajectory.with_piece(begin, last, made, problem.space)


def _held(problem: PlanningTask, piece: Trajectory) -> Trajectory:
    """Return a short motion that stands still at its end for some steps, if the machine can."""
    # 12 steps that a machine has for its last way into the goal's centre, standing if need be
    return _standing(problem, piece, piece.x[-1], 12 - len(piece.u)) or piece


def _standing(problem: PlanningTask, motion: Trajectory, x: Array, steps: int) -> Trajectory | None:
    """Return a motion that stands in a state (nx,) for some more steps; None if that moves on."""
    model = problem.model
    idle = model.null_control()
    if steps <= 0 or np.abs(model.f(x, idle)).max() > 0.0:
        return None
    t = motion.t[-1] + problem.step * np.arange(1, steps + 1)
    states = np.vstack([motion.x, np.tile(x, (steps, 1))])
    u = np.vstack([motion.inputs, np.tile(idle, (steps, 1))])
    return trajectory_under(model, np.append(motion.t, t), states, u)


def _standing_in_goal(problem: PlanningTask, motion: Trajectory) -> Trajectory | None:
    """Return a motion that stands in the goal's centre for some steps, None if the machine cannot.

    What is left of fast motions, such as the slip of tyres, dies away while it stands: no input
    takes it away in the last step.
    """
    end = motion.x[-1]
    centre = problem.space.nearest(end, problem.goal.centre(end))
    # steps after which slip has died away: tyres creep for some hundredths of a second
    return _standing(problem, motion, centre, 4)


def _smooth(
    problem: PlanningTask,
    trajectory: Trajectory,
    cancelled: Callable[[], bool],
    iterations: int,
    *,
    held: bool = False,
) -> Trajectory | None:
    """Make a motion exact in which no transition takes place."""
    varied = not held and is_long(problem, trajectory)  # in the steps of its tail alone
    if varied and is_motion(problem, trajectory):
        landing = connect_to_goal(problem, trajectory, cancelled)
        if landing is not None:
            return landing
    if not len(trajectory.inputs):
        return None
    guesses = [even_knots(problem, trajectory)]
    if not held and (standing := _standing_in_goal(problem, trajectory)) is not None:
        guesses.append(even_knots(problem, standing))
    if not held and problem.goal_excess(trajectory.x[-1]) <= 1.0:
        guesses.append(_slower(problem, guesses[0]))  # time is what it may lack
    excess, reserves = NO_EXCESS, _reserves(problem, SHORT.exact_clearances)
    for guess, (clearance, room) in product(guesses, reserves):
        task = TrajectoryProblem(problem, clearance, room=room, cancelled=cancelled)
        task = task.tightened(excess)
        if cancelled():
            return None
        knots = make_knots_exact(task, guess, iterations, held=held)
        if knots is None:
            continue
        made = true_trajectory(task.problem, knots)
        if made is None or not repeatable(task.problem, made):
            return None  # more clearance does not help
        if satisfies_all(task, made):
            return made
        excess += excess_between_knots(task, made)
    return None


def _reserves(problem: PlanningTask, clearances: Sequence[float]) -> Sequence[tuple[float, float]]:
    """Return reserves of gaps, as fractions and in [m] at least: the first leaves usual room."""
    return [
        (clearance, 0.0 if k else usual_room(problem)) for k, clearance in enumerate(clearances)
    ]


def _slower(problem: PlanningTask, knots: Knots) -> Knots:
    """Return knots of the same path that take more steps."""
    guess = knots.in_steps(math.ceil(SLOWER * len(knots.u)), problem.space)
    x, rates = guess.x.copy(), slice(problem.model.nq, problem.model.nq + problem.model.nv)
    x[:, rates] /= SLOWER
    return Knots(x, guess.u, knots.h)


def connect_to_goal(
    problem: PlanningTask, motion: Trajectory, cancelled: Callable[[], bool] = never_cancelled
) -> Trajectory | None:
    """Return a trajectory that differs only in its tail and ends in the goal's centre, or None.

    Everything before the tail is checked at the knots only.

    Args:
        problem: The problem that the motion solves.
        motion: A dynamically feasible trajectory from its start.
        cancelled: Whether to give up.
    """
    reserves = _reserves(problem, SHORT.segment_clearances)
    paths = [Segments(problem, clearance, cancelled, room) for clearance, room in reserves]
    standing = _standing_in_goal(problem, motion)
    motions = [motion] if standing is None else [standing, motion]
    for segments, steps, given in product(paths, SHORT.tail_steps, motions):
        if cancelled():
            break
        begin = int(np.searchsorted(given.t, given.t[-1] - steps * problem.step))
        tail = segments.ended(given.piece(begin, len(given.u)))
        if tail is not None and meets_centre(problem, tail.x[-1]):
            whole = given.with_piece(begin, len(given.u), tail, problem.space)
            return whole if satisfies_all_at_knots(segments.task, whole) else None
    return None
