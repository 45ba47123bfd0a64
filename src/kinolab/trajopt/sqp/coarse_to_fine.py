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
from kinolab.trajopt.sqp.restoration import restore_feasibility

MIN_VIOLATION = 1.0  # sum of all that is missing, in scales, from which on it is worth a try
COARSENING_FACTORS = (4, 3, 2)  # steps for which inputs are held
MIN_STEPS = 50  # of such steps that leave inputs enough freedom
MAX_ITERATIONS = 30  # subproblems


def coarse_to_fine(task: TrajectoryProblem, knots: Knots, cancelled: Callable[[], bool]) -> Knots:
    """Return knots of the same duration from which little is missing, or the given ones.

    Args:
        task: The problem.
        knots: Within the limits of states and inputs.
        cancelled: Whether to give up.
    """
    steps = len(knots.u)
    times = next((k for k in COARSENING_FACTORS if steps % k == 0 and steps >= k * MIN_STEPS), 1)
    if times == 1 or not sum(task.transcription(knots).violation(knots)) > MIN_VIOLATION:
        return knots
    held = knots.u.reshape(steps // times, times, -1).mean(axis=1)
    coarse = Knots(knots.x[::times], held, times * knots.h)
    found = restore_feasibility(task, coarse, cancelled, iterations=MAX_ITERATIONS, times=times)
    return knots if found is None else task.refined(found, times)
