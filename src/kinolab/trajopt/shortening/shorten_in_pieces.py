"""A long motion made short: detours left out, then every piece made quicker, over and over."""

from __future__ import annotations

from collections.abc import Callable

from kinolab.problem import Problem
from kinolab.simulation.reference import DivergedError, resimulate
from kinolab.trajectory import Trajectory
from kinolab.trajopt.connect_to_goal import in_the_centre, is_true, landed
from kinolab.trajopt.nlp.problem import Task
from kinolab.trajopt.segments import NEAR_GAPS, Pieces
from kinolab.trajopt.shortening.cycles import Splices
from kinolab.trajopt.shortening.shortcuts import Shortcuts
from kinolab.trajopt.shortening.sliding_window import Windows
from kinolab.trajopt.variable_step_motion import course_of

ROOM = 4e-2  # of the machine's size, for gaps between few knots
SHARE = 0.5  # of that, for limits of states
GAIN = 0.03  # share of the duration that is worth another round


def condensed(
    problem: Problem, given: Trajectory, late: Callable[[], bool], over: Callable[[], bool]
) -> Trajectory:
    """Return a shorter motion, or the one that was given.

    It ends in the goal's centre, but where neither the given one does nor one near it could be
    found: then it ends somewhere in the goal.

    Args:
        problem: That the motion solves.
        given: A true motion; one that is not true stays as it is.
        late: Whether to stop making it shorter.
        over: Whether to stop making what is shorter exact.
    """
    task = Task(problem, ROOM, share=SHARE, near=NEAR_GAPS)
    if not is_true(task, given):
        return given
    pieces = Pieces(task, late)
    shortcuts, splices = Shortcuts(task, pieces, late), Splices(task, pieces, late)
    windows = Windows(task, pieces, late)
    course = course_of(given)
    while not late():
        before = course.duration
        course = windows.sweep(splices.taken(shortcuts.taken(course)))
        if course.duration > (1 - GAIN) * before:
            break
    if not course.duration < given.duration:
        return given
    try:
        motion = resimulate(problem, course.times, course.u)
    except DivergedError:
        return given
    exact = landed(problem, motion, over)
    if (
        exact is None
        and not in_the_centre(problem, given.x[-1])
        and task.keeps_all_at_knots(motion)
    ):
        exact = motion
    return exact if exact is not None and exact.duration < given.duration else given
