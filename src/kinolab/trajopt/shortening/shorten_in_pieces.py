"""A long motion made short: detours left out, then every piece made quicker, over and over."""

from __future__ import annotations

from collections.abc import Callable

from kinolab.problem import Problem
from kinolab.simulation.reference import DivergedError, resimulate
from kinolab.trajectory import Trajectory
from kinolab.trajopt.connect_to_goal import connect_to_goal, in_the_centre, is_motion
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.segments import NEAR_GAPS, Segments
from kinolab.trajopt.shortening.cycles import CycleRemoval
from kinolab.trajopt.shortening.shortcuts import Shortcuts
from kinolab.trajopt.shortening.sliding_window import SlidingWindow
from kinolab.trajopt.variable_step_motion import variable_step_motion

CLEARANCE_RESERVE = 4e-2  # of the machine's size, for gaps between few knots
LIMIT_FRACTION = 0.5  # of that, for limits of states
MIN_GAIN = 0.03  # share of the duration that is worth another round


def shorten_segments(
    problem: Problem, given: Trajectory, cancelled: Callable[[], bool], over: Callable[[], bool]
) -> Trajectory:
    """Return a shorter motion, or the one that was given.

    It ends in the goal's centre, but where neither the given one does nor one near it could be
    found: then it ends somewhere in the goal.

    Args:
        problem: That the motion solves.
        given: A true motion; one that is not true stays as it is.
        cancelled: Whether to stop making it shorter.
        over: Whether to stop making what is shorter exact.
    """
    task = TrajectoryProblem(problem, CLEARANCE_RESERVE, fraction=LIMIT_FRACTION, near=NEAR_GAPS)
    if not is_motion(task, given):
        return given
    pieces = Segments(task, cancelled)
    shortcuts, splices = Shortcuts(task, pieces, cancelled), CycleRemoval(task, pieces, cancelled)
    windows = SlidingWindow(task, pieces, cancelled)
    course = variable_step_motion(given)
    while not cancelled():
        before = course.duration
        course = windows.sweep(splices.without_cycles(shortcuts.with_shortcuts(course)))
        if course.duration > (1 - MIN_GAIN) * before:
            break
    if not course.duration < given.duration:
        return given
    try:
        motion = resimulate(problem, course.times, course.u)
    except DivergedError:
        return given
    exact = connect_to_goal(problem, motion, over)
    if (
        exact is None
        and not in_the_centre(problem, given.x[-1])
        and task.satisfies_all_at_knots(motion)
    ):
        exact = motion
    return exact if exact is not None and exact.duration < given.duration else given
