"""Least time or cost with a fixed number of steps, by inexact restoration: all are feasible.

Each iteration solves the optimal subproblem and then restores feasibility at a fixed step
length. Without restoration the trust region shrinks to where the linearised dynamics hold (the
Maratos effect); with it every iterate is a feasible trajectory.

Source: Martinez, Pilotta, Inexact-restoration algorithm for constrained optimization, Journal of
Optimization Theory and Applications 104(1), 2000.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import Knots, cost, even_knots
from kinolab.trajopt.nlp.dynamics_constraint import derived_map
from kinolab.trajopt.nlp.options import END, SQP, TIGHT, StoppingTolerances
from kinolab.trajopt.nlp.problem import TrajectoryProblem, linearization_seconds
from kinolab.trajopt.sqp.qp import program_seconds, solve
from kinolab.trajopt.sqp.restoration import restoration_weights
from kinolab.trajopt.sqp.solver import minimize
from kinolab.trajopt.sqp.subproblem import subproblem


def subproblem_seconds(problem: PlanningTask, trajectory: Trajectory) -> float:
    """Return the work of one subproblem of a whole motion, without inequalities, in [s].

    Infinite with so many states that no such subproblem is solved.

    Args:
        problem: The problem that it solves.
        trajectory: The motion.
    """
    if problem.model.nx >= END.many_states:
        return math.inf
    model, steps = problem.model, len(trajectory.inputs)
    program = program_seconds(steps, model.nx + model.nu, 0)
    if not steps:
        return program
    knots = even_knots(problem, trajectory)
    step = derived_map(problem, knots, 1)
    return linearization_seconds(step, steps) + program


def minimize_cost(
    task: TrajectoryProblem,
    knots: Knots,
    lengths: tuple[float | Array, float | Array],
    *,
    times: int = 1,
    tolerances: StoppingTolerances = TIGHT,
) -> Knots:
    """Return feasible knots that take less time, or cost less, or the given ones.

    Args:
        knots: Feasible initial guess.
        lengths: Bounds of the step lengths in [s], of all or each, shape (P,).
        times: Time steps of the problem per knot interval.
        tolerances: Stopping criteria.
    """
    if not task.problem.cost_of(knots) > 0.0:
        return knots  # nothing costs less
    transcription, scaling = task.transcription(knots, times), task.scaling(*lengths)
    weights, radius = task.weights(knots), SQP.time_radius
    linearization = transcription.linearization(knots, radius)
    curvature = task.curvature(knots, scaling, weights)
    durations = [knots.duration]
    while radius > tolerances.min_radius and not task.cancelled():
        change = solve(
            subproblem(linearization, scaling, weights, radius, curvature), SQP.step_accuracy
        )
        if change is None:
            radius /= 3
            continue
        before = cost(knots, scaling, weights)
        if change.predicted < tolerances.min_predicted * before:
            break
        tried = knots.moved(change.dx, change.du, change.dh)
        least = most = tried.lengths
        if len(most) > 1:  # how long a free fall lasts cannot be chosen: half the gain will do
            half = (most + knots.lengths) / 2
            least, most = np.minimum(least, half), np.maximum(most, half)
        held = replace(scaling, h_bounds=(least, most))
        closed = minimize(
            transcription,
            tried,
            held,
            restoration_weights(),
            iterations=SQP.closure_iterations,
            enough=SQP.closure_tolerance,
            worth=SQP.max_contraction,
        )
        gained = before - cost(closed.knots, scaling, weights)
        if (
            sum(closed.violation) <= SQP.closure_tolerance
            and gained > SQP.accept_ratio * change.predicted
        ):
            knots, radius = closed.knots, min(2 * radius, SQP.max_radius)
            durations.append(knots.duration)
            if gained < tolerances.min_gain * before:
                break
            linearization = transcription.linearization(knots, radius)
            curvature = task.curvature(knots, scaling, weights)
        else:
            radius /= 3
    if len(durations) > 1 or not task.cancelled():
        last_half = 1.0 - durations[-1] / durations[(len(durations) - 1) // 2]
        task.minimised(knots.duration, last_half if task.cancelled() else 0.0)
    return knots
