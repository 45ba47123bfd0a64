"""A planned motion made exact: its end is the goal's centre, and every knot follows.

Of a long true motion the last part alone is changed, so that it takes no longer than a short one.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from kinolab.cancel import never_cancelled
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import even_knots
from kinolab.trajopt.nlp.dynamics_constraint import (
    is_motion,
    repeatable,
    true_trajectory,
)
from kinolab.trajopt.nlp.feasibility_check import satisfies_all, satisfies_all_at_knots
from kinolab.trajopt.nlp.goal_constraint import meets_centre
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.options import SHORT
from kinolab.trajopt.segments import Segments, is_long
from kinolab.trajopt.sqp.restoration import make_knots_exact


def make_exact(
    problem: PlanningTask,
    trajectory: Trajectory,
    cancelled: Callable[[], bool] = lambda: False,
    iterations: int = 40,
    *,
    held: bool = False,
) -> Trajectory | None:
    """Return a motion near a given one that ends in the goal's centre, or None.

    It keeps all limits, requirements and gaps as far as samples show; whether it truly does is for
    the verifier to say.

    Args:
        problem: That the trajectory solves, more or less.
        trajectory: To begin with; its start is replaced by the problem's.
        cancelled: Whether to give up.
        iterations: Largest number of subproblems, for each of a few reserves of room.
        held: Whether steps keep their length.
    """
    landing = None if held else _in_the_end(problem, trajectory, cancelled)  # its steps are its own
    if landing is not None:
        return landing
    for clearance in SHORT.exact_clearances:
        task = TrajectoryProblem(problem, clearance)
        if cancelled() or not len(trajectory.inputs):
            return None
        knots = make_knots_exact(
            task, even_knots(problem, trajectory), cancelled, iterations, held=held
        )
        if knots is None:
            continue
        made = true_trajectory(task.problem, knots)
        if made is None or not repeatable(task.problem, made):
            return None  # more room does not help
        if satisfies_all(task, made):
            return made
    return None


def _in_the_end(
    problem: PlanningTask, trajectory: Trajectory, cancelled: Callable[[], bool]
) -> Trajectory | None:
    """Return a long true motion made exact by its last part alone, or None."""
    if not is_long(problem, trajectory) or not is_motion(problem, trajectory):
        return None
    return connect_to_goal(problem, trajectory, cancelled)


def connect_to_goal(
    problem: PlanningTask, motion: Trajectory, cancelled: Callable[[], bool] = never_cancelled
) -> Trajectory | None:
    """Return a motion that ends in the goal's centre and differs in its last steps alone, or None.

    What comes before its last steps is looked at from knot to knot, no closer than that.

    Args:
        problem: That the motion solves.
        motion: A true one from its start.
        cancelled: Whether to give up.
    """
    paths = [Segments(problem, clearance, cancelled) for clearance in SHORT.segment_clearances]
    for segments, steps in product(paths, SHORT.tail_steps):
        if cancelled():
            break
        begin = int(np.searchsorted(motion.t, motion.t[-1] - steps * problem.step))
        tail = segments.ended(motion.piece(begin, len(motion.u)))
        if tail is not None and meets_centre(problem, tail.x[-1]):
            whole = motion.with_piece(begin, len(motion.u), tail, problem.space)
            return whole if satisfies_all_at_knots(segments.task, whole) else None
    return None
