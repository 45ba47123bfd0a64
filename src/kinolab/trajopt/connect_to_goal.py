"""A motion that ends near the goal's centre, made to end in it by its last part alone.

What comes before is true already and stays as it is, so that this takes no longer for a long motion
than for a short one.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.cancel import never_cancelled
from kinolab.problem import Problem
from kinolab.simulation.reference import trajectory_under
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.goal_constraint import GoalConstraint
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.segments import NEAR_GAPS, Segments
from kinolab.trajopt.variable_step_motion import VariableStepMotion, variable_step_motion

Array: TypeAlias = NDArray[np.float64]

TAIL_LENGTHS = (100, 200, 50, 400)  # steps of the problem, tried one after the other
# of the machine's size, for gaps between few knots; tried likewise
CLEARANCE_FRACTIONS = (4e-2, 5e-3)
LIMIT_FRACTION = 0.5  # of that, for limits of states
DEFECT_TOLERANCE = 1e-6  # of a scale: by how much a state may miss where the step before leads
CENTRE_TOLERANCE = 1e-6  # sum of all that may be missing in the goal, in scales


def connect_to_goal(
    problem: Problem, motion: Trajectory, cancelled: Callable[[], bool] = never_cancelled
) -> Trajectory | None:
    """Return a motion that ends in the goal's centre and differs in its last steps alone, or None.

    What comes before its last steps is looked at from knot to knot, no closer than that.

    Args:
        problem: That the motion solves.
        motion: A true one from its start.
        cancelled: Whether to give up.
    """
    given, times = variable_step_motion(motion), motion.t - motion.t[0]
    tasks = [
        TrajectoryProblem(problem, clearance, fraction=LIMIT_FRACTION, near=NEAR_GAPS)
        for clearance in CLEARANCE_FRACTIONS
    ]
    paths = [(task, Segments(task, cancelled)) for task in tasks]
    for (task, pieces), steps in product(paths, TAIL_LENGTHS):
        if cancelled():
            break
        begin = int(np.searchsorted(times, times[-1] - steps * problem.step))
        tail = pieces.ended(given.piece(begin, len(given.spans)))
        if tail is not None and in_the_centre(problem, tail.x[-1]):
            return _joined(task, given, begin, tail)
    return None


def in_the_centre(problem: Problem, end: Array) -> bool:
    """Say whether a motion that ends so, shape (nx,), needs no landing."""
    return bool(np.abs(GoalConstraint(problem, end).residual(end)).sum() <= CENTRE_TOLERANCE)


def _joined(
    task: TrajectoryProblem, given: VariableStepMotion, begin: int, tail: VariableStepMotion
) -> Trajectory | None:
    """Return a motion with another tail, None where the whole breaks anything."""
    course = given.with_piece(begin, len(given.spans), tail, task.problem.space)
    made = trajectory_under(task.problem.model, course.times, course.x, course.u)
    return made if task.satisfies_all_at_knots(made) else None


def is_motion(task: TrajectoryProblem, motion: Trajectory) -> bool:
    """Say whether a motion begins at the start and every step leads to the next state."""
    away = np.abs(motion.x[0] - task.problem.start) / task.problem.scales
    return (
        bool(away.max(initial=0.0) <= DEFECT_TOLERANCE) and task.defect(motion) <= DEFECT_TOLERANCE
    )
