"""Check that the re-simulated motion ends in the goal region."""

from __future__ import annotations

import numpy as np

from kinolab.verification.check import Check, CheckContext, judged


def goal(context: CheckContext) -> Check:
    """Check the final state; the value is its goal error in units of the tolerance."""
    problem, final = context.problem, context.motion.x[-1]
    wanted, errors = problem.goal, np.abs(problem.goal_errors(final))
    named = [(problem.model.state_names[i], "") for i in wanted.indices]
    named += [(attitude.name, " rad") for attitude in wanted.attitudes]
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
    return judged("goal", problem.goal_excess(final), 1.0, "; ".join(parts) or other)
