"""A long motion made short: detours left out, then every piece made quicker, over and over."""

from __future__ import annotations

from collections.abc import Callable

from kinolab.problem import Problem
from kinolab.simulation.reference import DivergedError, resimulate
from kinolab.trajectory import Trajectory
from kinolab.trajopt.connect_to_goal import connect_to_goal, in_the_centre, is_motion
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.options import SHORT
from kinolab.trajopt.segments import Segments
from kinolab.trajopt.shortening.cycles import CycleRemoval
from kinolab.trajopt.shortening.shortcuts import Shortcuts
from kinolab.trajopt.shortening.sliding_window import SlidingWindow
from kinolab.trajopt.variable_step_motion import variable_step_motion


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
    task = TrajectoryProblem(
        problem,
        SHORT.segment_clearances[0],
        fraction=SHORT.segment_limit_fraction,
        near=SHORT.near_gaps,
    )
    if not is_motion(task, given):
        return given
    pieces = Segments(task, cancelled)
    shortcuts, splices = Shortcuts(task, pieces, cancelled), CycleRemoval(task, pieces, cancelled)
    windows = SlidingWindow(task, pieces, cancelled)
    course = variable_step_motion(given)
    while not cancelled():
        before = course.duration
        course = windows.sweep(splices.without_cycles(shortcuts.with_shortcuts(course)))
        if course.duration > (1 - SHORT.min_sweep_gain) * before:
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
