"""What a plan is, in lines of text: for the terminal and for ``print``."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kinolab.problem import PlanningTask
    from kinolab.solve.plan import PlanResult


def progress_text(found: PlanResult, *, anytime: bool) -> str:
    """Describe a plan that improves on all previous ones."""
    first, last = found.improvements[0], found.improvements[-1]  # longer, if it is exact at last
    if first.price is not None and last.price is not None:
        return (
            f"optimising: a cost of {last.price:.4g} (first found: {first.price:.4g}), "
            f"after {last.after:.1f} s"
        )
    if anytime:
        best = min(found.improvements, key=lambda one: one.duration)
        return f"seed {best.seed}: {best.duration:.2f} s of motion, after {best.after:.1f} s"
    if first is last:
        return f"optimising a motion of {first.duration:.2f} s"
    if last.duration > first.duration:
        return f"optimising: it ends in the goal's centre now, and takes {last.duration:.2f} s"
    return (
        f"optimising: {last.duration:.2f} s (first found: {first.duration:.2f} s), "
        f"after {last.after:.1f} s"
    )


def summary(problem: PlanningTask, found: PlanResult, sentences: Sequence[str] = ()) -> str:
    """Return the summary of a plan.

    Args:
        problem: What it solves.
        sentences: Of a diagnosis, if there is one; those of the plan's message are left out.
    """
    from kinolab.problem.goal_entries import distance_text
    from kinolab.problem.goals_reached import nearest_end

    lines = [f"{found.status}: {found.message}"]
    if found.interrupted and found.status != "interrupted":
        lines[0] += " Interrupted before the time was over."
    if found.trajectory is not None:
        x = found.trajectory.x[-1]
        lines.append(
            f"  motion of {found.trajectory.duration:.2f} s{_before(found)}, ending "
            f"{distance_text(nearest_end(problem, x), x)} from the goal's centre, "
            f"{found.iterations} iterations in "
            f"{found.timings['search']:.2f} s"
        )
    if found.certificate is not None and len(found.certificate.reached) > 1:
        lines.append(f"  {goals_text(problem, found.certificate.reached)}")
    if found.price is not None:
        first = found.improvements[0].price if found.improvements else found.price
        before = "" if first in {None, found.price} else f" (first found: {first:.4g})"
        lines.append(f"  by [objective] it costs {found.price:.4g}{before}")
    if found.refused:
        lines.append(f"  {_refusals(found.refused)}")
    if len(found.attempts) > 1:
        lines.append(f"  seed {found.seed} of {_ends(found)}")
    if found.certificate is not None:
        lines.append(f"  {found.certificate}")
    if found.claim is not None:
        lines += [f"  {line}" for line in found.claim.lines()]
    lines += [f"  warning: {sentence}" for sentence in found.warnings]
    if found.status == "solved" and found.statistics.get("improvement_unfinished"):
        lines.append(_more_time(found.statistics, "shorter" if found.price is None else "cheaper"))
    lines += [f"  {sentence}" for sentence in sentences if sentence not in found.message]
    return "\n".join(lines)


def goals_text(problem: PlanningTask, reached: Sequence[float]) -> str:
    """Say when each of several goals is reached, the first that is first.

    Args:
        reached: When each is, in the order written, in [s].
    """
    from kinolab.scenario.locations import place_text

    names = [place_text(place) for place in problem.scenario.goals]
    rows = sorted(zip(reached, names, strict=True))
    return "reaches " + ", ".join(f"{name} at {time:.2f} s" for time, name in rows)


def _more_time(statistics: Mapping[str, float], better: str) -> str:
    """Say what gives the improvement of a plan more time, and what it may become by that."""
    if limit := statistics["improvement_out_of_time"]:
        return (
            f"  the time limit of {limit:g} s ended its improvement: "
            f"--time-limit {4 * limit:g} may make it {better}"
        )
    seconds, gain = statistics["improvement_seconds"], statistics.get("last_half_gain", 0.0)
    more = f"--set planner.improve={math.ceil(4 * seconds)}"
    if gain >= 0.01:  # gain of the second half of improvement that is told
        return f"  it was still becoming {better} after {seconds:.3g} s: {more} goes on"
    return f"  with more time than {seconds:.3g} s it may become {better}: {more}"


def _before(found: PlanResult) -> str:
    """Describe the duration before optimisation, if it was shortened."""
    raw = found.statistics.get("raw_duration")
    return f" (first found: {raw:.2f} s)" if raw not in {None, found.duration} else ""


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


def plan_text(problem: PlanningTask, found: PlanResult) -> str:
    """Return what ``print`` shows of a plan, its summary and what it holds: ten lines at most."""
    lines = summary(problem, found).splitlines()
    motion = found.trajectory
    lines.append(
        f"  {problem.machine.name} in {problem.name}, planner {found.planner}, seed {found.seed}"
    )
    if motion is not None:
        lines.append(f"  {len(motion.t)} knots of {_names(motion.state_names)}")
        lines.append(f"  inputs {_names(motion.control_names)}")
        if motion.reference_names:
            lines.append(f"  references {_names(motion.reference_names)}")
    if found.timings:
        spent = ", ".join(f"{stage} {seconds:.2f}" for stage, seconds in found.timings.items())
        lines.append(f"  seconds: {spent}")
    return "\n".join(lines[:10])


def _names(names: Sequence[str]) -> str:
    more = f" and {len(names) - 12} more" if len(names) > 12 else ""
    return ", ".join(names[:12]) + more if names else "none"
