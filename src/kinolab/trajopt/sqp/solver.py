"""Sequential convex programming: one subproblem after another, each within a trust region.

Source: Conn, Gould, Toint, Trust-region methods, 2000, chapter 15 (exact penalties); Mao, Szmuk,
Acikmese, Successive convexification, CDC 2016.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.scaling import Scaling, Weights
from kinolab.trajopt.nlp.transcription import MultipleShooting, cost
from kinolab.trajopt.sqp.feasibility_step import feasibility_step
from kinolab.trajopt.sqp.qp import solve

ACCEPTED, GOOD = 0.1, 0.7  # shares of the promise: what is kept, and what lets the region grow
MIN_RADIUS = 1e-7  # trust region, as a share of what counts as large
MAX_RADIUS = 4.0
NARROW, WIDE, AMPLE = 0.02, 1.0, 10.0  # first region: its limits, and times what is missing
# promise, as a share of the cost, that is not worth another subproblem
MIN_PREDICTED_REDUCTION = 1e-4
# share of what was missing where it could not be closed at once, to try that again
NEAR_FRACTION = 0.3
PACE_ITERATIONS = 3  # subproblems after which the pace is looked at
EXACT_VIOLATION = 1e-11  # sum of all that is missing, in scales, that counts as nothing
NEARLY_EXACT_VIOLATION = 1e-8  # of the same: a subproblem that does not halve it is the last one


@dataclass(frozen=True, eq=False)
class SqpResult:
    """Where a sequence ended.

    Attributes:
        knots: The best that was found.
        violation: Sums of defects, of what is missing in the goal and in inequalities.
        iterations: Subproblems that were solved.
    """

    knots: Knots
    violation: tuple[float, float, float]
    iterations: int


def minimize(
    transcription: MultipleShooting,
    knots: Knots,
    scaling: Scaling,
    weights: Weights,
    *,
    iterations: int = 60,
    enough: float = EXACT_VIOLATION,
    worth: float = math.inf,
    pace: float = 0.0,
    cancelled: Callable[[], bool] = lambda: False,
) -> SqpResult:
    """Improve knots until nothing is missing and no more is gained.

    Args:
        transcription: The equations.
        knots: To begin with; within the limits of states and inputs.
        scaling: Of the variables.
        weights: Of what counts; without a weight of time only what is missing counts.
        iterations: Largest number of subproblems.
        enough: Sum of all that is missing, in scales, that counts as nothing.
        worth: Share of what was missing above which a subproblem's rest ends the sequence.
        pace: Share of what is missing that every few subproblems must get rid of.
        cancelled: Whether to stop.
    """
    missing = transcription.violation(knots)
    made, linearization, refused = 0, None, math.inf
    course = [sum(missing)]
    restoring = not (weights.time or weights.effort)  # only what is missing counts
    if not math.isfinite(sum(missing)):
        return SqpResult(knots, missing, made)
    # What misses little needs no large change, and what is far away need not be looked at then.
    radius = min(max(AMPLE * sum(missing), NARROW), WIDE)
    while made < iterations and not cancelled():
        if restoring and sum(missing) <= enough:
            break
        if linearization is None:
            linearization = transcription.linearization(knots, radius)
        made += 1
        change = None
        if restoring and sum(missing) <= NEAR_FRACTION * refused:
            change = feasibility_step(linearization, scaling, weights, radius)
            refused = refused if change is not None else sum(missing)
        if change is None:
            change = solve(linearization, scaling, weights, radius)
        if change is None:
            radius /= 4
            if radius < MIN_RADIUS:
                break
            continue
        before = cost(knots, scaling, weights)
        merit = before + weights.penalty * sum(missing)
        candidate = knots.moved(change.dx, change.du, change.dh)
        so_far, found = sum(missing), transcription.violation(candidate)
        now = cost(candidate, scaling, weights) + weights.penalty * sum(found)
        gained = merit - now if math.isfinite(now) else -math.inf
        if sum(found) > max(worth * sum(missing), enough):
            break
        ratio = gained / change.predicted if change.predicted > 0 else -math.inf
        if ratio > ACCEPTED:
            knots, missing, linearization = candidate, found, None
        done = change.predicted <= MIN_PREDICTED_REDUCTION * before and sum(missing) <= enough
        stuck = restoring and so_far < NEARLY_EXACT_VIOLATION and sum(found) > 0.5 * so_far
        radius = _radius(radius, ratio, change.length)
        # else a region has yet to be found
        if ratio > ACCEPTED or len(course) > 1 or made > PACE_ITERATIONS:
            course.append(sum(missing))
        stuck |= (
            len(course) > PACE_ITERATIONS and course[-1] > (1 - pace) * course[-1 - PACE_ITERATIONS]
        )
        if done or stuck or radius < MIN_RADIUS:
            break
    return SqpResult(knots, missing, made)


def _radius(radius: float, ratio: float, length: float) -> float:
    """Return the next region: larger where it was in the way, smaller where it was not needed."""
    if ratio > GOOD:
        return min(max(2 * length, NARROW), MAX_RADIUS)
    return radius if ratio > ACCEPTED else radius / 4
