"""A motion that ends near the goal's centre, made to end in it by its last part alone.

What comes before is true already and stays as it is, so that this takes no longer for a long motion
than for a short one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.motion import trajectory_under
from kinolab.optimize.course import Course, course_of
from kinolab.optimize.exactness import exact
from kinolab.optimize.task import Task
from kinolab.trajectory import Trajectory

Array: TypeAlias = NDArray[np.float64]

TAILS = (50, 150, 450)  # steps of the problem, tried one after the other
TRUE = 1e-6  # of a scale: by how much a state may miss where the step before leads
ITERATIONS = 15  # subproblems for each


def landed(task: Task, motion: Trajectory, late: Callable[[], bool]) -> Trajectory | None:
    """Return a motion that ends in the goal's centre and differs in its last steps alone, or None.

    What comes before its last steps is looked at in samples, no more than that.

    Args:
        task: The problem.
        motion: A true one from its start.
        late: Whether to give up.
    """
    given, step = course_of(motion), task.problem.step
    times = given.times
    for steps in TAILS:
        begin = int(np.searchsorted(times, times[-1] - steps * step))
        if late():
            return None
        tail = _exact_tail(task, given.piece(begin, len(given.spans)), late)
        if tail is not None:
            attitudes = task.problem.model.attitudes.values()
            whole = given.with_piece(begin, len(given.spans), tail, attitudes)
            made = trajectory_of(task, whole)
            return made if task.keeps_samples(made) else None
        if begin == 0:
            return None
    return None


def _exact_tail(task: Task, tail: Course, late: Callable[[], bool]) -> Course | None:
    own = task.of(replace(task.problem, start=tail.x[0]))
    attitudes = tuple(task.problem.model.attitudes.values())
    count = max(1, int(np.ceil(tail.duration / task.problem.step - 1e-9)))
    knots = exact(own, tail.in_steps(count, attitudes), late, ITERATIONS)
    made = None if knots is None else own.trajectory(knots)
    return course_of(made) if made is not None and own.keeps_all(made) else None


def trajectory_of(task: Task, course: Course) -> Trajectory:
    """Return a course as a trajectory."""
    return trajectory_under(task.problem.model, course.times, course.x, course.u)


def is_true(task: Task, motion: Trajectory) -> bool:
    """Say whether a motion begins at the start and every step leads to the next state."""
    away = np.abs(motion.x[0] - task.problem.start) / task.problem.scales
    return bool(away.max(initial=0.0) <= TRUE) and task.defect(motion) <= TRUE
