"""Check that the motion ends in the goal region, as it is followed and as it is stored."""

from __future__ import annotations

import math

import numpy as np

from kinolab.problem.goals_reached import ends
from kinolab.verification.checks.check import Check, CheckContext, judged


def goal(context: CheckContext) -> Check:
    """Check the final state; the value is its goal error in units of the tolerance.

    Of the one that is followed and the one that is stored, whichever is farther away: who carries a
    plan out reads the latter. A motion that is given has no rows of its own.
    """
    problem, followed = context.problem, context.motion.x[-1]
    problem = min(ends(problem), key=lambda one: one.goal_excess(followed))
    stored = followed if context.known_motion is not None else context.trajectory.x[-1]
    final = max((followed, stored), key=problem.goal_excess)
    wanted, errors = problem.goal, np.abs(problem.goal_errors(final))
    named = [(problem.model.state_names[i], "") for i in wanted.indices]
    named += [(one.part.name, " rad") for one in wanted.parts]
    parts = [
        f"{name} is off by {error:.4g}{unit}"
        for (name, unit), error, tolerance in zip(
            named, errors, wanted.error_tolerances, strict=False
        )
        if not error <= tolerance
    ]
    other = "a point or an axis misses its target"
    if wanted.together and not wanted.needs_frames:
        whole = "sum" if wanted.norm == "sum" else "Euclidean norm"
        other = f"each deviation is within its tolerance, their {whole} is not"
    where = "the last row: " if final is stored is not followed else ""
    return judged("goal", problem.goal_excess(final), 1.0, where + ("; ".join(parts) or other))


def goals_on_the_way(context: CheckContext) -> Check | None:
    """Check that each of several goals is reached; the value counts those that are not."""
    times = context.reached
    if not times:
        return None
    missed = [k for k, time in enumerate(times, start=1) if math.isnan(time)]
    order = "" if context.problem.scenario.goal.order == "any" else " after those before it"
    detail = f"goal {missed[0]} of {len(times)} is not reached{order}" if missed else ""
    return judged("goals on the way", float(len(missed)), 0.0, detail)
