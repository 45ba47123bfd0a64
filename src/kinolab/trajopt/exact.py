"""Make a trajectory exact: dynamically feasible, and ending in the goal's centre.

Only the tail of a long feasible trajectory is changed, so that it takes no longer than a short one.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

from kinolab.concurrency.cancel import never_cancelled
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
    landing = None if held else _in_the_end(problem, trajectory, cancelled)  # it varies the steps
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
            return None  # more clearance does not help
        if satisfies_all(task, made):
            return made
    return None


def _in_the_end(
    problem: PlanningTask, trajectory: Trajectory, cancelled: Callable[[], bool]
) -> Trajectory | None:
    """Make a long feasible trajectory exact by changing only its tail; None if that fails."""
    if not is_long(problem, trajectory) or not is_motion(problem, trajectory):
        return None
    return connect_to_goal(problem, trajectory, cancelled)


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
