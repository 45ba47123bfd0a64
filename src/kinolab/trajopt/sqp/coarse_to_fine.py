"""What is far from exact is made exact with inputs that are held for several steps at once.

The motion under them is the same as in single steps, so that the smaller program, which is faster
and has fewer wrong ways to go, leaves little or nothing to do for the whole one.

Source: Cagienard, Grieder, Kerrigan, Morari, Move blocking strategies in receding horizon control,
Journal of Process Control 17(6), 2007.
"""

from __future__ import annotations

from collections.abc import Callable

from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.options import SQP
from kinolab.trajopt.sqp.restoration import restore_feasibility


def coarse_to_fine(task: TrajectoryProblem, knots: Knots, cancelled: Callable[[], bool]) -> Knots:
    """Return knots of the same duration from which little is missing, or the given ones.

    Args:
        task: The problem.
        knots: Within the limits of states and inputs.
        cancelled: Whether to give up.
    """
    steps = len(knots.u)
    times = next(
        (k for k in SQP.coarsening_factors if steps % k == 0 and steps >= k * SQP.min_coarse_steps),
        1,
    )
    if times == 1 or not sum(task.transcription(knots).violation(knots)) > SQP.coarse_violation:
        return knots
    held = knots.u.reshape(steps // times, times, -1).mean(axis=1)
    coarse = Knots(knots.x[::times], held, times * knots.h)
    found = restore_feasibility(
        task, coarse, cancelled, iterations=SQP.coarse_iterations, times=times
    )
    return knots if found is None else task.refined(found, times)
