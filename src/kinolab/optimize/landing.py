"""A motion that ends near the goal's centre, made to end in it by its last part alone.

What comes before is true already and stays as it is, so that this takes no longer for a long motion
than for a short one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
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

TAILS = (50, 150)  # steps of the problem, tried one after the other
TRUE = 1e-6  # of a scale: by how much a state may miss where the step before leads
ITERATIONS = 15  # subproblems for each


def landed(
    tasks: Sequence[Task], motion: Trajectory, late: Callable[[], bool] = lambda: False
) -> Trajectory | None:
    """Return a motion that ends in the goal's centre and differs in its last steps alone, or None.

    What comes before its last steps is looked at from knot to knot, no closer than that.

    Args:
        tasks: The same problem with several reserves of room, tried one after the other.
        motion: A true one from its start.
        late: Whether to give up.
    """
    given = course_of(motion)
    times = given.times
    for steps in TAILS:
        begin = int(np.searchsorted(times, times[-1] - steps * tasks[0].problem.step))
        for task in tasks:
            tail = None if late() else _exact_tail(task, given.piece(begin, len(given.spans)), late)
            if tail is not None:
                return _joined(task, given, begin, tail)
    return None


def _joined(task: Task, given: Course, begin: int, tail: Course) -> Trajectory | None:
    """Return a motion with another tail, None where the whole breaks anything."""
    attitudes = tuple(task.problem.model.attitudes.values())
    course = given.with_piece(begin, len(given.spans), tail, attitudes)
    made = trajectory_under(task.problem.model, course.times, course.x, course.u)
    return made if task.keeps_all_at_knots(made) else None


def _exact_tail(task: Task, tail: Course, late: Callable[[], bool]) -> Course | None:
    own = task.of(replace(task.problem, start=tail.x[0]))
    attitudes = tuple(task.problem.model.attitudes.values())
    count = max(1, math.ceil(tail.duration / task.problem.step - 1e-9))
    knots = exact(own, tail.in_steps(count, attitudes), late, ITERATIONS)
    made = None if knots is None else own.trajectory(knots)
    return course_of(made) if made is not None and own.keeps_all(made) else None


def is_true(task: Task, motion: Trajectory) -> bool:
    """Say whether a motion begins at the start and every step leads to the next state."""
    away = np.abs(motion.x[0] - task.problem.start) / task.problem.scales
    return bool(away.max(initial=0.0) <= TRUE) and task.defect(motion) <= TRUE
