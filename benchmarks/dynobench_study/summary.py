"""What all problems together come to."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from statistics import median

from .published import IDBASTAR, Others, published
from .records import Run
from .tables import times_to_first

NEAR = 1.05  # times the best published cost
ROOM = 0.02  # [m] to obstacles, with which a better cost is no matter of shaving corners


def summary(runs: Sequence[Run], limit: float) -> Iterator[str]:
    """Yield sentences that count problems."""
    others = published()
    groups = {name: [run for run in runs if run.problem == name] for name in others}
    tried = {name: own for name, own in groups.items() if own}
    count = f"of {len(tried)} problems"
    if len(tried) < len(others):
        count += f" (the benchmark has {len(others)})"
    every = sum(all(run.counts for run in own) for own in tried.values())
    once = sum(any(run.counts for run in own) for own in tried.values())
    yield f"Solved with every seed: {every} {count}; with at least one: {once}."
    count = f"of {len(tried)}"
    quick = sum(_quick(own, others[name], limit) for name, own in tried.items())
    timed = sum(others[name].by[IDBASTAR].time is not None for name in tried)
    yield (
        f"Median time to the first exact motion at or below iDb-A*'s published one, whose machine "
        f"is another: {quick} of {timed}."
    )
    near = sum(_cost(own) <= NEAR * others[name].best for name, own in tried.items())
    yield f"Median cost within 5 % of the best published: {near} {count}."
    better = sum(_better(own, others[name]) for name, own in tried.items())
    yield f"Below it in the median, every run with {ROOM:g} m to obstacles: {better} {count}."


def _quick(runs: Sequence[Run], others: Others, limit: float) -> bool:
    theirs = others.by[IDBASTAR].time
    own = median(times_to_first(runs, limit))
    return theirs is not None and own < limit and own <= theirs


def _cost(runs: Sequence[Run]) -> float:
    """Return the median final cost in [s]; a run that is not solved counts as infinite."""
    return median(run.final.duration if run.counts and run.final else math.inf for run in runs)


def _better(runs: Sequence[Run], others: Others) -> bool:
    """Say whether the median is below the best published cost, and no solved run comes too near."""
    solved = [run for run in runs if run.counts]
    roomy = all(run.clearance is None or run.clearance >= ROOM for run in solved)
    return _cost(runs) < others.best and roomy
