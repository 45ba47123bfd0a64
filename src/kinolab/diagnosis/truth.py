"""What the truth said about a motion that a planner took for a plan."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.planning import Plan

MISSES = "missed_the_goal_in_truth"  # what planners call it in their statistics


def truth_sentences(plan: Plan) -> Iterator[str]:
    """Say where the planner's steps and the true motion disagreed."""
    if plan.status == "verification_failed":
        checks = plan.certificate.failures if plan.certificate is not None else ()
        failed = ", ".join(check.name for check in checks) or plan.message
        yield f"The motion found is not true ({failed}): shorten [integration] step."
    misses = int(plan.statistics.get(MISSES, 0))
    if misses:
        times = "once" if misses == 1 else f"{misses} times"
        yield (
            f"The planner's steps reached the goal {times} where the true motion misses it: "
            "shorten [integration] step."
        )
