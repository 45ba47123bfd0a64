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
from kinolab.trajopt.nlp.transcription import Transcription, cost
from kinolab.trajopt.sqp.qp import solve
from kinolab.trajopt.sqp.solver import LARGEST, descend

FIRST = 0.5  # trust region, as a share of what counts as large
KEPT = 0.1  # share of a promise that is worth a step
CLOSING = 8  # subproblems to close what a faster motion opened
HOPE = 0.7  # share that one of them may leave open, for the next one to be worth it
ROUGH = 1e-6  # accuracy of a change whose errors are closed afterwards
NEAR = 1e-8  # sum of all that is missing, in scales, on the way to a final repair
PENALTY = 10.0  # of what is missing, against a cost of about 1


@dataclass(frozen=True)
class Patience:
    """How long to go on making a motion faster.

    Attributes:
        region: Trust region below which nothing is gained.
        promise: Share of the cost that must be promised for another step to be tried.
        gain: Share of the cost that a step must have gained for another one to be tried.
    """

    region: float = 1e-3
    promise: float = 1e-3
    gain: float = 0.0


THOROUGH = Patience()


def closing(penalty: float = PENALTY) -> Weights:
    """Return the weights that change a trajectory as little as exactness allows."""
    return Weights(time=0.0, effort=0.0, stay=1.0, penalty=penalty)


def quicken(
    transcription: Transcription,
    knots: Knots,
    scaling: Scaling,
    *,
    effort: float = 1e-3,
    patience: Patience = THOROUGH,
    late: Callable[[], bool] = lambda: False,
) -> Knots:
    """Return exact knots of a shorter duration, or the same ones.

    Args:
        transcription: The equations.
        knots: Exact ones.
        scaling: With the range of the step length.
        effort: Weight of the mean square input, where the duration given weighs 1.
        patience: How long to go on.
        late: Whether to stop.
    """
    weights = Weights(time=1 / knots.duration, effort=effort, stay=effort, penalty=PENALTY)
    radius = FIRST
    local = transcription.local(knots, radius)
    while radius > patience.region and not late():
        change = solve(local, scaling, weights, radius, ROUGH)
        if change is None:
            radius /= 3
            continue
        before = cost(knots, scaling, weights)
        if change.promised < patience.promise * before:
            break
        tried = knots.moved(change.dx, change.du, change.dh)
        held = replace(scaling, h_bounds=(tried.h, tried.h))
        closed = descend(
            transcription,
            tried,
            held,
            closing(),
            iterations=CLOSING,
            enough=NEAR,
            worth=HOPE,
            late=late,
        )
        gained = before - cost(closed.knots, scaling, weights)
        if sum(closed.missing) <= NEAR and gained > KEPT * change.promised:
            knots, radius = closed.knots, min(2 * radius, LARGEST)
            if gained < patience.gain * before:
                break
            local = transcription.local(knots, radius)
        else:
            radius /= 3
    return knots
