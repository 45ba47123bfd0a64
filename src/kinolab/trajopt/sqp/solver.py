"""Sequential convex programming with an exact penalty and a trust region.

Source: Conn, Gould, Toint, Trust-region methods, 2000, chapter 15 (exact penalties); Mao, Szmuk,
Acikmese, Successive convexification, CDC 2016.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from kinolab.trajopt.nlp.decision import Knots, Scaling, Weights, cost
from kinolab.trajopt.nlp.options import SQP
from kinolab.trajopt.nlp.problem import MultipleShooting
from kinolab.trajopt.sqp.feasibility_step import feasibility_step
from kinolab.trajopt.sqp.qp import solve
from kinolab.trajopt.sqp.subproblem import subproblem


@dataclass(frozen=True, eq=False)
class SqpResult:
    """Result of the SQP solver.

    Attributes:
        knots: The last accepted iterate.
        violation: Summed scaled violations of dynamics (defects), goal and inequalities.
    """

    knots: Knots
    violation: tuple[float, float, float]


def minimize(
    transcription: MultipleShooting,
    knots: Knots,
    scaling: Scaling,
    weights: Weights,
    *,
    iterations: int = 60,
    enough: float = SQP.exact_violation,
    worth: float = math.inf,
    pace: float = 0.0,
) -> SqpResult:
    """Improve knots until they are feasible and the cost no longer falls.

    Args:
        knots: Initial guess within the limits of states and inputs.
        weights: Of the merit function; without time and effort only feasibility is restored.
        iterations: Maximum number of subproblems.
        enough: Total scaled violation that counts as feasible.
        worth: Stop if a step leaves more than this fraction of the violation.
        pace: Fraction of the violation that every few subproblems must remove.
    """
    missing = transcription.violation(knots)
    made, linearization, refused = 0, None, math.inf
    course = [sum(missing)]
    restoring = not (weights.time or weights.effort)  # feasibility only
    if not math.isfinite(sum(missing)):
        return SqpResult(knots, missing)
    # A small violation needs only a small step, and then distant obstacles need not be considered.
    radius = min(
        max(SQP.radius_per_violation * sum(missing), SQP.min_good_radius), SQP.max_first_radius
    )
    while made < iterations and not transcription.cancelled():
        if restoring and sum(missing) <= enough:
            break
        if linearization is None:
            linearization = transcription.linearization(knots, radius)
        made += 1
        change, within = None, subproblem(linearization, scaling, weights, radius)
        if restoring and sum(missing) <= SQP.retry_ratio * refused:
            change = feasibility_step(within)
            refused = refused if change is not None else sum(missing)
        if change is None:
            change = solve(within)
        if change is None:
            radius /= 4
            if radius < SQP.min_radius:
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
        if ratio > SQP.accept_ratio:
            knots, missing, linearization = candidate, found, None
        done = change.predicted <= SQP.min_predicted * before and sum(missing) <= enough
        stuck = restoring and so_far < SQP.nearly_exact_violation and sum(found) > 0.5 * so_far
        radius = _radius(radius, ratio, change.length)
        # otherwise the trust region is still being sized
        if ratio > SQP.accept_ratio or len(course) > 1 or made > SQP.pace_iterations:
            course.append(sum(missing))
        stuck |= (
            len(course) > SQP.pace_iterations
            and course[-1] > (1 - pace) * course[-1 - SQP.pace_iterations]
        )
        if done or stuck or radius < SQP.min_radius:
            break
    return SqpResult(knots, missing)


def _radius(radius: float, ratio: float, length: float) -> float:
    """Return the next trust-region radius: about twice a good step, a quarter after a bad one."""
    if ratio > SQP.expand_ratio:
        return min(max(2 * length, SQP.min_good_radius), SQP.max_radius)
    return radius if ratio > SQP.accept_ratio else radius / 4
