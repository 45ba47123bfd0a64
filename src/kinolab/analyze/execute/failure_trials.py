"""Runs that failed, made again with one thing changed: what is it that fails them?"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np

from kinolab.analyze.execute.execution import Execution, ExecutionRun, Executor
from kinolab.analyze.execute.failure import FailureGroup
from kinolab.errors import KinolabError
from kinolab.steering.tracker import Tracker

STIFFER, STRONGER = 4.0, 2.0  # factors on how stiff the gains, and how strong the inputs are
TRIAL_SECONDS = 15.0  # for all changes together, as a diagnosis of a search takes

What: TypeAlias = Literal[
    "nominal", "parameter", "parameters", "built", "noise", "disturbance", "tracked", "gains",
    "limits",
]  # fmt: skip


@dataclass(frozen=True)
class FailureTrial:
    """What came of failed runs with one thing changed.

    Attributes:
        what: Which kind of thing.
        words: The change, as one types it where that is possible.
        reached: How many reached the goal.
        made: Of how many.
        name: Of the parameter, if it is one.
    """

    what: What
    words: str
    reached: int
    made: int
    name: str = ""

    @property
    def helps(self) -> bool:
        """Whether most of them reach the goal."""
        return 2 * self.reached > self.made


@dataclass(frozen=True)
class _Change:
    what: What
    words: str
    make: Callable[[], Executor]
    name: str = ""


def failure_trials(
    executor: Executor,
    execution: Execution,
    group: FailureGroup,
    *,
    seconds: float = TRIAL_SECONDS,
    say: Callable[[str], None] = lambda _: None,
) -> tuple[FailureTrial, ...]:
    """Make failed runs again with one thing changed at a time.

    Args:
        executor: What made them.
        execution: All runs.
        group: Which of those that failed.
        seconds: After which no further change is tried.
        say: Receives progress messages.
    """
    end, numbers = time.monotonic() + seconds, failed_runs(execution, group)
    found = []
    for change in _changes(executor, execution, group):
        if time.monotonic() > end:
            break
        say(f"trying again {change.words}")
        # The machine that was planned for is one machine, and without noise always the same.
        tried = numbers[:1] if change.what == "nominal" else numbers
        reached = _reached(change.make(), tried)
        found.append(FailureTrial(change.what, change.words, reached, len(tried), change.name))
    return tuple(found)


def failed_runs(execution: Execution, group: FailureGroup) -> list[int]:
    """Return the numbers of the first runs that failed alike, from 0."""
    alike = (k for k, run in enumerate(execution.runs) if _alike(run, group))
    # 6 runs of a group that are made again with each change
    return [k for _, k in zip(range(6), alike, strict=False)] or [group.run]


def _alike(run: ExecutionRun, group: FailureGroup) -> bool:
    return run.failure is not None and run.failure.kind == group.first.kind


def _reached(executor: Executor, numbers: Sequence[int]) -> int:
    try:
        return sum(executor.run(k).failure is None for k in numbers)
    except KinolabError:  # with this change no such machine exists, or no gains
        return 0


def _changes(executor: Executor, execution: Execution, group: FailureGroup) -> Iterator[_Change]:
    """Yield what may be changed; first nothing may be other than planned."""
    now = executor.conditions
    shares = now.shares(executor.actual.system)
    exact = replace(now, parameters=0.0, vary={}, keep=())
    planned = replace(exact, noise=0.0, disturbance=0.0, built={})

    def under(**changed: object) -> Callable[[], Executor]:
        return lambda: executor.under(replace(now, **changed))  # type: ignore[arg-type]

    if shares or now.noise or now.disturbance or now.built:
        yield _Change("nominal", "with all as planned", lambda: executor.under(planned))
    if shares:
        yield _Change("parameters", "with exact parameters", lambda: executor.under(exact))
    for name in _suspects(execution, group, shares) if len(shares) > 1 else shares:
        rest = {n: share for n, share in now.vary.items() if n != name}
        change = under(vary=rest, keep=(*now.keep, name))
        yield _Change("parameter", f"with --keep {name}", change, name)
    for name in now.built:
        rest = {n: value for n, value in now.built.items() if n != name}
        yield _Change("built", f"without --set {name}", under(built=rest), name)
    if now.noise:
        yield _Change("noise", "without --noise", under(noise=0.0))
    if now.disturbance:
        yield _Change("disturbance", "without --disturbance", under(disturbance=0.0))
    if not now.tracked:
        yield _Change("tracked", "without --untracked", under(tracked=True))
        return
    for large in (executor.large / STIFFER, min(executor.large * STIFFER, 1.0)):
        if large != executor.large:
            words = f"with --large {large:.3g} instead of {executor.large:.3g}"
            yield _Change("gains", words, lambda large=large: _with_gains(executor, large))  # type: ignore[misc]
    if wanting := most_wanted(execution, group):
        words = f"with {STRONGER:g} times the limits of {' and '.join(wanting)}"
        yield _Change("limits", words, lambda: _stronger(executor))


def _suspects(execution: Execution, group: FailureGroup, shares: dict[str, float]) -> list[str]:
    """Return the parameters in which these runs differ most from those that reached the goal."""
    failed = [run.parameters for run in execution.runs if _alike(run, group)]
    others = [run.parameters for run in execution.runs if run.failure is None]

    def apart(name: str) -> float:
        mine, theirs = ([values[name] for values in of] for of in (failed, others))
        if not mine or not theirs:
            return 0.0
        return float(
            abs(np.mean(mine) - np.mean(theirs)) / (shares[name] * np.ptp(mine + theirs) + 1e-300)
        )

    # Eight are kept, one at a time: those in which failed runs differ most
    return sorted(shares, key=lambda name: -apart(name))[:8]


def most_wanted(execution: Execution, group: FailureGroup) -> dict[str, float]:
    """Return of which inputs the feedback wanted more than there is, in these runs.

    By name, with the mean share of the steps, the largest first.
    """
    runs = [run for run in execution.runs if _alike(run, group)]
    names = dict.fromkeys(name for run in runs for name in run.wanting)
    shares = {n: float(np.mean([run.wanting.get(n, 0.0) for run in runs])) for n in names}
    return dict(sorted(shares.items(), key=lambda entry: -entry[1]))


def _with_gains(executor: Executor, large: float) -> Executor:
    asked = executor.conditions.track
    return executor.tracked_by(
        Tracker.along(executor.problem, executor.plan, large=large, asked=asked)
    )


def _stronger(executor: Executor) -> Executor:
    tracker = executor.tracker
    return executor.tracked_by(replace(tracker, limits=STRONGER * tracker.limits))
