"""Feasibility restoration: remove all constraint violation with the least change to the knots.

Knots may be several steps of the problem apart (move blocking): inputs are constant in between, and
the motion is the same as in single steps.

Source: Martinez, Pilotta, Inexact-restoration algorithm for constrained optimization, Journal of
Optimization Theory and Applications 104(1), 2000; Cagienard, Grieder, Kerrigan, Morari, Move
blocking strategies in receding horizon control, Journal of Process Control 17(6), 2007.
"""

from __future__ import annotations

from kinolab.numerics.arrays import Array
from kinolab.trajopt.nlp.decision import Knots, Weights
from kinolab.trajopt.nlp.dynamics_constraint import refined
from kinolab.trajopt.nlp.options import SQP
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.sqp.solver import minimize


def restoration_weights(penalty: float = SQP.violation_penalty) -> Weights:
    """Return weights for the least change that restores feasibility."""
    return Weights(time=0.0, effort=0.0, stay=1.0, penalty=penalty)


def restore_feasibility(
    task: TrajectoryProblem,
    knots: Knots,
    *,
    iterations: int,
    times: int = 1,
    lengths: tuple[float | Array, float | Array] | None = None,
    enough: float = SQP.exact_violation,
    most: float = SQP.rounding_violation,
    pace: float = 0.0,
    penalty: float = SQP.violation_penalty,
) -> Knots | None:
    """Return feasible knots near given ones; None if none are found.

    Args:
        knots: Initial guess, clipped first to the limits of states and inputs.
        iterations: Maximum number of subproblems.
        times: Steps of the problem per knot interval.
        lengths: Bounds of the step lengths in [s], of all or each (P,); fixed if None.
        enough: Total scaled violation at which to stop.
        most: Total scaled violation accepted of the result, or ``enough`` where that is more.
        pace: Fraction of the violation that every few subproblems must remove.
        penalty: Weight of the violation relative to the change.
    """
    knots = task.within_limits(knots)
    scaling = task.scaling(*(lengths or (knots.lengths, knots.lengths)))
    transcription = task.transcription(knots, times)
    descent = minimize(
        transcription, knots, scaling, restoration_weights(penalty),
        iterations=iterations, enough=enough, pace=pace,
    )  # fmt: skip
    return descent.knots if sum(descent.violation) <= max(most, enough) else None


def coarse_to_fine(task: TrajectoryProblem, knots: Knots) -> Knots:
    """Return nearly feasible knots of the same duration from a coarse grid, or the given ones.

    The motion under inputs held constant for several steps is the same as in single steps, so the
    smaller program, which is faster and has fewer local minima, leaves little to do.

    Args:
        knots: Within the limits of states and inputs.
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
    found = restore_feasibility(task, coarse, iterations=SQP.coarse_iterations, times=times)
    return knots if found is None else refined(task.problem, found, times)


def make_knots_exact(
    task: TrajectoryProblem, knots: Knots, iterations: int = 40, *, held: bool = False
) -> Knots | None:
    """Return feasible knots near given ones; None if none are found.

    The step length is fixed if ``held`` and in discrete problems.
    """
    knots = coarse_to_fine(task, task.within_limits(knots))
    free = (0.5 * knots.h, max(task.problem.step, knots.h))
    lengths = None if held or task.discrete else free
    return restore_feasibility(task, knots, iterations=iterations, lengths=lengths)
