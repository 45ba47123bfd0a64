"""Why executions fail and what to change, in sentences, with the changes tried."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from kinolab.analyze.execute.execution import Execution, Executor
from kinolab.analyze.execute.failure import FailureGroup
from kinolab.analyze.execute.failure_trials import (
    TRIAL_SECONDS,
    FailureTrial,
    failed_runs,
    failure_trials,
    most_wanted,
)
from kinolab.analyze.execute.run_monitor import hit_obstacles
from kinolab.errors import KinolabError

MOST_GROUPS = 2  # that are looked into, the most frequent ones
DEEPEST = 0.2  # [m] by which the machine is made slimmer at most, to see how much room is missing
ROOM = 1.5  # factor on the room that was missing in the runs that were looked at
NOTABLE = 0.05  # share of the steps in which an input is at its limit


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
        execution: The runs.
        say: Receives progress messages.
    """
    sentences, trials = list[str](), dict[str, tuple[FailureTrial, ...]]()
    groups = execution.failures[:MOST_GROUPS]
    for group in groups:
        seconds = TRIAL_SECONDS / len(groups)
        tried = failure_trials(executor, execution, group, seconds=seconds, say=say)
        trials[group.first.phrase] = tried
        told = list(_sentences(executor, execution, group, tried))
        sentences += [f"{_subject(group)}: {told[0]}", *told[1:]] if told else []
    return ExecutionDiagnosis(tuple(dict.fromkeys(sentences)), trials)


def _subject(group: FailureGroup) -> str:
    return f"Those that {group.first.phrase.replace(': ', ' (', 1)})"


def _sentences(
    executor: Executor, execution: Execution, group: FailureGroup, tried: tuple[FailureTrial, ...]
) -> Iterator[str]:
    """Yield what these runs fail by, what was tried, and what to change."""
    nominal = next((trial for trial in tried if trial.what == "nominal"), None)
    if (nominal and not nominal.helps) or not tried:
        yield (
            "the machine that was planned for fails, too, with nothing disturbed, so that the plan "
            "or its feedback is what does not hold."
        )
    helping = sorted((t for t in tried if t.helps), key=lambda t: (-t.reached, _ORDER.index(t.what)))
    helping = [t for t in helping if t.what != "nominal"]
    single = [t for t in helping if t.what != "parameters"]
    if single:
        yield f"tried again, {_results(single)}."
        yield from _advice(executor, group, single[0])
    elif helping:
        yield f"tried again, {_results(helping)}, but no single parameter is to blame."
    elif tried:
        words = ", ".join(t.words for t in tried if t.what != "nominal")
        if words:
            yield f"tried again, no single change lets most of them reach the goal ({words})."
    yield from _wanting(execution, group)
    yield from _room(executor, execution, group)


_ORDER = ("built", "parameter", "noise", "disturbance", "tracked", "gains", "limits", "parameters", "nominal")


def _results(trials: list[FailureTrial]) -> str:
    return ", ".join(f"{t.reached} of {t.made} reach the goal {t.words}" for t in trials[:3])


def _advice(executor: Executor, group: FailureGroup, best: FailureTrial) -> Iterator[str]:
    """Say what to change where a change helped."""
    first = group.first
    if best.what == "parameter" and first.outcome == "collided" and first.at_start:
        yield (
            f"So {best.name} moves the machine into it before the plan begins: a shape whose size is "
            f"a number does not follow {best.name}. Give the shape's size, or its place, by "
            f"{best.name}, as in Cylinder({best.name}, …)."
        )
    elif best.what == "parameter":
        yield (
            f"So {best.name} is what decides: know it better, or plan with more to spare "
            "([world] clearance, [goal] reserve, [bounds] of the inputs)."
        )
    elif best.what == "built":
        yield f"So the plan does not know {best.name}: give its value in [system] parameters."
    elif best.what == "noise":
        yield "So it is the noise of the measurements: better sensors, or gains that do less."
    elif best.what == "disturbance":
        yield "So it is the disturbance of the inputs: more to spare, or stiffer gains."
    elif best.what == "tracked":
        yield "So the plan needs feedback: leave --untracked out."
    elif best.what == "gains":
        yield f"So the gains are what fails it: execute {best.words}."
    elif best.what == "limits":
        yield from ()


def _wanting(execution: Execution, group: FailureGroup) -> Iterator[str]:
    """Say which inputs the plan leaves no room to correct with."""
    for name, share in list(most_wanted(execution, group).items())[:1]:
        if share >= NOTABLE:
            yield (
                f"In {share:.0%} of the steps the feedback wants more of {name} than there is: plan "
                f"with less of it ([bounds] {name}), or give the machine more."
            )


def _room(executor: Executor, execution: Execution, group: FailureGroup) -> Iterator[str]:
    """Say how much more room, tolerance or reserve would do."""
    first, problem = group.first, executor.problem
    if first.outcome == "collided" and not first.at_start:
        yield from _clearance(executor, execution, group)
    if first.outcome == "missed":
        alike = [r.excess for r in execution.runs if r.failure and r.failure.kind == first.kind]
        worst = max(alike, default=math.inf) / executor.monitor.enough
        if "mode" in first.cause:
            yield (
                "A transition did not take place: look at what its `until` and `provided` ask for, "
                "and let the plan pass them by more."
            )
        elif math.isfinite(worst):
            yield f"With {math.ceil(20 * worst) / 20:g} times the goal's tolerance all of them would be in it."
    if first.outcome == "strayed":
        yield (
            "Plan with more to spare there: narrower [world] bounds for the plan than for the "
            "execution, or the clearance of a [[keep_out]]."
        )
    if first.outcome == "lost":
        yield "The equations end there: keep the plan away from it by [bounds], or use other coordinates."
    del problem


def _clearance(executor: Executor, execution: Execution, group: FailureGroup) -> Iterator[str]:
    """Say how much further from obstacles the plan would have to keep."""
    depths, passing = [], 0
    for k in failed_runs(execution, group):
        try:
            built, motion = executor.motion(k)
            depths.append(executor.monitor.depth(motion.x, built, DEEPEST))
        except KinolabError:
            continue
        passing += motion.failure is None
    if not depths or not np.isfinite(depths).all():
        return
    missing = max(depths)
    yield (
        f"They are {1000 * missing:.3g} mm too wide at most, and {passing} of {len(depths)} would "
        "then reach the goal."
    )
    if hit_obstacles(iter([group.first])):
        room = executor.problem.scenario.world.clearance + ROOM * missing
        room = math.ceil(1000 * room) / 1000
        yield f"Plan with more room: --set world.clearance={room:g}."
