"""Sequential convex programming: one subproblem after another, each within a trust region.

Source: Conn, Gould, Toint, Trust-region methods, 2000, chapter 15 (exact penalties); Mao, Szmuk,
Acikmese, Successive convexification, CDC 2016.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from kinolab.optimize.knots import Knots
from kinolab.optimize.subproblem import Scaling, Weights, solve
from kinolab.optimize.transcription import Transcription, cost

ACCEPTED, GOOD = 0.1, 0.7  # shares of the promise: what is kept, and what lets the region grow
SMALLEST = 1e-7  # trust region, as a share of what counts as large
LARGEST = 4.0
NARROW, WIDE, AMPLE = 0.02, 1.0, 10.0  # first region: its limits, and times what is missing
STILL = 1e-4  # promise, as a share of the cost, that is not worth another subproblem
EXACT = 1e-9  # sum of all that is missing, in scales, that counts as nothing


@dataclass(frozen=True, eq=False)
class Descent:
    """Where a sequence ended.

    Attributes:
        knots: The best that was found.
        missing: Sums of defects, of what is missing in the goal and in inequalities.
        iterations: Subproblems that were solved.
    """

    knots: Knots
    missing: tuple[float, float, float]
    iterations: int


def descend(
    transcription: Transcription,
    knots: Knots,
    scaling: Scaling,
    weights: Weights,
    *,
    iterations: int = 60,
    enough: float = EXACT,
    late: Callable[[], bool] = lambda: False,
) -> Descent:
    """Improve knots until nothing is missing and no more is gained.

    Args:
        transcription: The equations.
        knots: To begin with; within the limits of states and inputs.
        scaling: Of the variables.
        weights: Of what counts; without a weight of time only what is missing counts.
        iterations: Largest number of subproblems.
        enough: Sum of all that is missing, in scales, that counts as nothing.
        late: Whether to stop.
    """
    missing = transcription.missing(knots)
    made, local = 0, None
    if not math.isfinite(sum(missing)):
        return Descent(knots, missing, made)
    # What misses little needs no large change, and what is far away need not be looked at then.
    radius = min(max(AMPLE * sum(missing), NARROW), WIDE)
    while made < iterations and not late():
        if sum(missing) <= enough and not (weights.time or weights.effort):
            break
        if local is None:
            local = transcription.local(knots, radius)
        made += 1
        change = solve(local, scaling, weights, radius)
        if change is None:
            radius /= 4
            if radius < SMALLEST:
                break
            continue
        before = cost(knots, scaling, weights)
        merit = before + weights.penalty * sum(missing)
        candidate = knots.moved(change.dx, change.du, change.dh)
        found = transcription.missing(candidate)
        now = cost(candidate, scaling, weights) + weights.penalty * sum(found)
        gained = merit - now if math.isfinite(now) else -math.inf
        ratio = gained / change.promised if change.promised > 0 else -math.inf
        if ratio > ACCEPTED:
            knots, missing, local = candidate, found, None
        if change.promised <= STILL * before and sum(missing) <= enough:
            break
        radius = _radius(radius, ratio, change.length)
        if radius < SMALLEST:
            break
    return Descent(knots, missing, made)


def _radius(radius: float, ratio: float, length: float) -> float:
    """Return the next region: larger where it was in the way, smaller where it was not needed."""
    if ratio > GOOD:
        return min(max(2 * length, NARROW), LARGEST)
    return radius if ratio > ACCEPTED else radius / 4
