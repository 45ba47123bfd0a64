"""Why executions fail and what to change, in sentences, with the changes tried."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

from kinolab.analyze.execute.execution import Execution, Executor
from kinolab.analyze.execute.failure import FailureGroup
from kinolab.analyze.execute.failure_trials import (
    TRIAL_SECONDS,
    FailureTrial,
    failed_runs,
    failure_trials,
    most_wanted,
)
from kinolab.errors import EndpointError, row_of


@dataclass(frozen=True)
class ExecutionDiagnosis:
    """What fails executions, and what to change.

    Attributes:
        sentences: The findings, the most frequent failure first.
        trials: What was tried for each group of failures that was looked into, by its phrase.
    """

    sentences: tuple[str, ...]
    trials: dict[str, tuple[FailureTrial, ...]]


def diagnose_execution(
    executor: Executor,
    execution: Execution,
    *,
    say: Callable[[str], None] = lambda _: None,
) -> ExecutionDiagnosis:
    """Look into the most frequent failures; takes about as long as the runs, 15 s at most.

    Args:
        executor: What made the runs.
        say: Receives progress messages.
    """
    sentences, trials = list[str](), dict[str, tuple[FailureTrial, ...]]()
    groups = execution.failures[:2]  # that are looked into, the most frequent ones
    for group in groups:
        seconds = TRIAL_SECONDS / len(groups)
        tried = failure_trials(executor, execution, group, seconds=seconds, say=say)
        trials[group.first.phrase] = tried
        told = list(_sentences(executor, execution, group, tried))
        if told:
            sentences += [f"{group.first.cause}: {told[0]}", *told[1:]]
    return ExecutionDiagnosis(tuple(dict.fromkeys(sentences)), trials)


def _sentences(
    executor: Executor, execution: Execution, group: FailureGroup, tried: tuple[FailureTrial, ...]
) -> Iterator[str]:
    """Yield what these runs fail by, what was tried, and what to change."""
    if any(t.what == "nominal" and not t.helps for t in tried) or not tried:
        yield (
            "the machine that was planned for fails, too, with nothing disturbed: the plan or its "
            "gains are what does not hold."
        )
    else:
        yield from _tried(group, [t for t in tried if t.what != "nominal"])
    if group.first.slip:
        yield (
            f"{group.first.slip[0].upper()}{group.first.slip[1:]}: a transition did not take place "
            "when it was due. Look at what its `until` and `provided` ask for, and let the plan "
            "pass them by more."
        )
    yield from shortages(execution, group)
    yield from _more_room(executor, execution, group)


def _tried(group: FailureGroup, tried: Sequence[FailureTrial]) -> Iterator[str]:
    """Say which changes help, and what the best of them tells."""
    helping = sorted((t for t in tried if t.helps), key=lambda t: (-t.reached, ORDER.index(t.what)))
    single = [t for t in helping if t.what != "parameters"]
    if single:
        yield f"tried again, {_results(single)}."
        best = single[0]
        yield from _advice(
            group,
            best,
            [t.name for t in single if (t.what, t.reached) == (best.what, best.reached)],
        )
    elif helping:
        yield f"tried again, {_results(helping)}; no single parameter is to blame."
    elif tried:
        words = ", ".join(t.words for t in tried)
        yield f"tried again, no single change lets most of them reach the goal ({words})."


# Of changes that help alike, the one that says most comes first.
ORDER = ("built", "parameter", "noise", "disturbance", "tracked", "gains", "limits", "parameters")


def _results(trials: Sequence[FailureTrial]) -> str:
    first, *rest = trials[:3]  # changes that help
    more = "".join(f", {t.reached} of {t.made} {t.words}" for t in rest)
    return f"{first.reached} of {first.made} reach the goal {first.words}{more}"


def _advice(group: FailureGroup, best: FailureTrial, alike: Sequence[str]) -> Iterator[str]:
    """Say what to change where a change helped, and others of its kind as much."""
    name, first = best.name, group.first
    decides = f"{name} is what decides: know it"
    if len(alike) > 1:
        decides = f"{row_of(alike)} decide alike: know them"
    if best.what == "parameter" and first.outcome == "collided" and first.at_start:
        yield (
            f"So {name} moves the machine into it before anything else does: a shape whose size is "
            f"a number does not follow {name}. Write its size, or its place, with {name}, as in "
            f"Cylinder({name}, …)."
        )
        return
    told = {
        "built": f"So the plan does not know {name}: give its value in [system] parameters.",
        "parameter": f"So {decides} better, or plan with more to spare "
        "([world] clearance, [goal] reserve, [bounds] of the inputs).",
        "noise": "So it is the noise of the measurements: better sensors, or gains that answer it "
        "less (--large).",
        "disturbance": "So it is the disturbance of the inputs: plan with more to spare, or "
        "stiffer gains (--large).",
        "tracked": "So the plan needs feedback: leave --untracked out.",
        "gains": "So the gains decide.",
    }
    if best.what in told:
        yield told[best.what]


def shortages(execution: Execution, group: FailureGroup) -> Iterator[str]:
    """Say of which input the plan leaves too little to correct with."""
    for name, share in list(most_wanted(execution, group).items())[:1]:
        if share >= 0.05:  # share of the steps in which an input is at its limit
            yield (
                f"In {share:.0%} of the steps the feedback wants more of {name} than there is: "
                f"plan with less of it ([bounds] {name}), or give the machine more."
            )


def _more_room(executor: Executor, execution: Execution, group: FailureGroup) -> Iterator[str]:
    """Say how much more room or tolerance would do."""
    first = group.first
    if first.outcome == "collided" and not first.at_start:
        yield from _clearance(executor, execution, group)
    elif first.outcome == "strayed":
        yield (
            "Plan with more to spare there: "
            + "a [[keep_out]] takes a clearance, and " * bool(executor.problem.keep_outs)
            + "[world] bounds may be narrower for the plan than the room is."
        )
    elif first.outcome == "lost":
        yield "The equations end there: keep the plan away from it ([bounds])."
    elif first.outcome == "missed" and not first.slip:
        alike = [r.excess for r in execution.runs if r.failure and r.failure.kind == first.kind]
        factor = math.ceil(20 * max(alike, default=math.inf) / executor.monitor.enough) / 20
        if factor <= 2.0:  # on the goal's tolerance, up to which it is called too tight
            yield f"All of them would be within {factor:g} times the goal's tolerance."


def _clearance(executor: Executor, execution: Execution, group: FailureGroup) -> Iterator[str]:
    """Say how much further from what they touch the plan would have to keep."""
    depths, passing = list[float](), 0
    for k in failed_runs(execution, group):
        built, motion = executor.motion(k)
        # 0.2 [m] by which the machine is made slimmer at most, to see how much room is missing
        depths.append(executor.monitor.depth(motion.x, built, 0.2))
        passing += motion.failure is None
    missing = max(depths)
    if not math.isfinite(missing) or 2 * passing <= len(depths):
        return  # they would not reach the goal either if nothing stood in their way
    yield (
        f"With {1000 * missing:.3g} mm more room {passing} of {len(depths)} "
        "pass and reach the goal."
    )
    problem = executor.problem
    obstacles = {obstacle.name for obstacle in problem.world.obstacles}
    if obstacles.isdisjoint(group.first.bodies):
        return
    # 1.5: factor on the room that was missing in the runs that were looked at
    room = math.ceil(1000 * (problem.scenario.world.clearance + 1.5 * missing)) / 1000  # mm
    roomy = replace(problem, world=replace(problem.world, clearance=room))
    try:
        roomy.check_endpoints()
    except EndpointError:
        yield (
            "Where the plan begins or ends it is nearer to something than that, so that no plan "
            "keeps it: make room there, or give the obstacle the numbers that the machine has."
        )
    else:
        yield f"Plan with it: --set world.clearance={room:g}."
