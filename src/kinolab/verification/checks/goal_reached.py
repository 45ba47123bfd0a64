"""Does the true motion end in the goal?"""

from __future__ import annotations

from kinolab.verification.check import Check, CheckContext, judged


def goal(context: CheckContext) -> Check:
    """Check the last state; the value is how far outside the goal it is, in tolerances."""
    problem, final = context.problem, context.motion.x[-1]
    wanted, violation = problem.goal, problem.goal_excess(final)
    rows = zip(wanted.indices, wanted.deviations(final), wanted.tolerances, strict=True)
    parts = [
        f"{problem.model.state_names[i]} is off by {abs(deviation):.4g}"
        for i, deviation, tolerance in rows
        if not abs(deviation) <= tolerance
    ]
    parts += [
        f"{attitude.name} is off by {attitude.turn(final):.4g} rad"
        for attitude in wanted.attitudes
        if not attitude.turn(final) <= attitude.tolerance
    ]
    other = "a point or an axis misses its target"
    if wanted.together and not wanted.needs_frames:
        whole = "sum" if wanted.norm == "sum" else "Euclidean norm"
        other = f"each deviation is within its tolerance, their {whole} is not"
    return judged("goal", violation, 1.0, "; ".join(parts) or other)
