"""Summary of a plan for the terminal."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from kinolab.problem import PlanningTask
    from kinolab.solve import PlanResult


def progress_text(found: PlanResult, *, anytime: bool) -> str:
    """Describe a plan that improves on all previous ones."""
    first, last = found.improvements[0], min(found.improvements, key=lambda one: one.duration)
    if anytime:
        return f"seed {last.seed}: {last.duration:.2f} s of motion, after {last.after:.1f} s"
    if first is last:
        return f"optimising {first.duration:.2f} s of motion"
    return (
        f"optimising: {first.duration:.2f} s -> {last.duration:.2f} s of motion, "
        f"after {last.after:.1f} s"
    )


def summary(problem: PlanningTask, found: PlanResult, report: Mapping[str, Any]) -> str:
    """Return the summary of a plan.

    Args:
        report: As written to the folder, with a diagnosis if there is one.
    """
    from kinolab.problem.goal_entries import distance_text

    lines = [f"{found.status}: {found.message}"]
    if found.interrupted and found.status != "interrupted":
        lines[0] += " Interrupted before the time was over."
    if found.trajectory is not None:
        lines.append(
            f"  motion of {found.trajectory.duration:.2f} s{_before(found)}, ending "
            f"{distance_text(problem, found.trajectory.x[-1])} from the goal's centre, "
            f"{found.iterations} iterations in "
            f"{found.timings['search']:.2f} s"
        )
    if found.refused:
        lines.append(f"  {_refusals(found.refused)}")
    if len(found.attempts) > 1:
        lines.append(f"  seed {found.seed} of {_ends(found)}")
    if found.certificate is not None:
        passed = sum(check.passed for check in found.certificate.checks)
        lines.append(f"  {passed} of {len(found.certificate.checks)} checks passed")
        lines += [f"  {check}" for check in found.certificate.failures]
    if found.status == "solved" and found.statistics.get("improvement_unfinished"):
        seconds = problem.scenario.planner.improve
        lines.append(
            f"  it may become shorter: all {seconds:g} s for improving it were used; "
            f"--set planner.improve={4 * seconds:g} gives it more"
        )
    lines += [f"  {sentence}" for sentence in _further(found, report)]
    return "\n".join(lines)


def _before(found: PlanResult) -> str:
    """Describe the duration before optimisation, if it was shortened."""
    raw = found.statistics.get("raw_duration")
    return f" (found with {raw:.2f} s)" if raw not in {None, found.cost} else ""


def _refusals(refused: Mapping[str, int]) -> str:
    """Describe how many motions the verifier rejected, and why."""
    count = sum(refused.values())
    causes = "; ".join(f"{checks}: {times}" for checks, times in sorted(refused.items()))
    return f"{count} {'motion' if count == 1 else 'motions'} refused by verification ({causes})"


def _ends(found: PlanResult) -> str:
    """Describe how many seeds ended with which status."""
    counts = Counter(attempt.status for attempt in found.attempts)
    ends = ", ".join(f"{count} {status}" for status, count in sorted(counts.items()))
    return f"{len(found.attempts)} ({ends})"


def _further(found: PlanResult, report: Mapping[str, Any]) -> list[str]:
    """Return the sentences of the diagnosis that are not in the plan's message."""
    sentences = report["diagnosis"].get("sentences", ())
    return [sentence for sentence in sentences if sentence not in found.message]
