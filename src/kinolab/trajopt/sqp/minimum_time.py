"""A shorter duration for the same number of steps, from one exact trajectory to the next.

Every step solves the subproblem that makes the motion faster and then closes what that opened, with
the step length held. Without the second part a trust region that trusts the dynamics gets tiny (the
Maratos effect); with it every trajectory on the way is one that may be kept.

Source: Martinez, Pilotta, Inexact-restoration algorithm for constrained optimization, Journal of
Optimization Theory and Applications 104(1), 2000.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.scaling import Scaling, Weights
from kinolab.trajopt.nlp.transcription import MultipleShooting, cost
from kinolab.trajopt.sqp.qp import solve
from kinolab.trajopt.sqp.solver import MAX_RADIUS, minimize

FIRST_RADIUS = 0.5  # trust region, as a share of what counts as large
MIN_RATIO = 0.1  # share of a promise that is worth a step
CLOSURE_ITERATIONS = 8  # subproblems to close what a faster motion opened
MAX_CONTRACTION = 0.7  # share that one of them may leave open, for the next one to be worth it
STEP_ACCURACY = 1e-6  # accuracy of a change whose errors are closed afterwards
CLOSURE_TOLERANCE = 1e-8  # sum of all that is missing, in scales, on the way to a final repair
VIOLATION_PENALTY = 10.0  # of what is missing, against a cost of about 1


@dataclass(frozen=True)
class StoppingTolerances:
    """How long to go on making a motion faster.

    Attributes:
        min_radius: Trust region below which nothing is gained.
        min_predicted: Share of the cost that must be promised for another step to be tried.
        min_gain: Share of the cost that a step must have gained for another one to be tried.
    """

    min_radius: float = 1e-3
    min_predicted: float = 1e-3
    min_gain: float = 0.0


TIGHT_TOLERANCES = StoppingTolerances()


def restoration_weights(penalty: float = VIOLATION_PENALTY) -> Weights:
    """Return the weights that change a trajectory as little as exactness allows."""
    return Weights(time=0.0, effort=0.0, stay=1.0, penalty=penalty)


def minimize_time(
    transcription: MultipleShooting,
    knots: Knots,
    scaling: Scaling,
    *,
    effort: float = 1e-3,
    tolerances: StoppingTolerances = TIGHT_TOLERANCES,
    cancelled: Callable[[], bool] = lambda: False,
) -> Knots:
    """Return exact knots of a shorter duration, or the same ones.

    Args:
        transcription: The equations.
        knots: Exact ones.
        scaling: With the range of the step length.
        effort: Weight of the mean square input, where the duration given weighs 1.
        tolerances: How long to go on.
        cancelled: Whether to stop.
    """
    weights = Weights(
        time=1 / knots.duration, effort=effort, stay=effort, penalty=VIOLATION_PENALTY
    )
    radius = FIRST_RADIUS
    linearization = transcription.linearization(knots, radius)
    while radius > tolerances.min_radius and not cancelled():
        change = solve(linearization, scaling, weights, radius, STEP_ACCURACY)
        if change is None:
            radius /= 3
            continue
        before = cost(knots, scaling, weights)
        if change.predicted < tolerances.min_predicted * before:
            break
        tried = knots.moved(change.dx, change.du, change.dh)
        held = replace(scaling, h_bounds=(tried.h, tried.h))
        closed = minimize(
            transcription,
            tried,
            held,
            restoration_weights(),
            iterations=CLOSURE_ITERATIONS,
            enough=CLOSURE_TOLERANCE,
            worth=MAX_CONTRACTION,
            cancelled=cancelled,
        )
        gained = before - cost(closed.knots, scaling, weights)
        if sum(closed.violation) <= CLOSURE_TOLERANCE and gained > MIN_RATIO * change.predicted:
            knots, radius = closed.knots, min(2 * radius, MAX_RADIUS)
            if gained < tolerances.min_gain * before:
                break
            linearization = transcription.linearization(knots, radius)
        else:
            radius /= 3
    return knots
