"""SST and its like by what a motion costs, for as long as the processor's time lasts."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

import kinolab
from kinolab import planners
from kinolab.search import Budget, Outcome
from kinolab.simulation.machine import states_under

from .cpp import Baseline
from .ours import load
from .runs import AS_IN_OMPL
from .tables import markdown
from .verdict import Array, Judge

PER_SECOND = 0.1  # beside the inputs' squares, as in ompl_cpp/baseline.cpp
EFFORT = {"effort": 1.0, "time": PER_SECOND}


@dataclass(frozen=True)
class Cost:
    """What the best motion costs that a search has found within its limit; infinite for none."""

    problem: str
    planner: str
    seed: int
    cost: float
    fault: str = ""

    def __str__(self) -> str:
        fault = f"; {self.fault}" if self.fault else ""
        return f"{self.problem}, {self.planner}, seed {self.seed}: {self.cost:.4g}{fault}"


def cheapest(
    baseline: Baseline, problems: Sequence[str], ours: Sequence[str], seeds: int, limit: float
) -> Iterator[Cost]:
    """Search for as long as the limit of CPU time, OMPL's SST and kinolab's planners in turn."""
    asked = {name: kinolab.Problem.of(load(name)).replace(objective=EFFORT) for name in problems}
    judges = {name: Judge(problem) for name, problem in asked.items()}
    for name, judge in judges.items():
        for planner in ours:  # code is compiled and loaded, and not counted
            _searched(judge, name, planner, 0, 0.2)
    for seed in range(1, seeds + 1):
        for name, judge in judges.items():
            found = baseline.report(name, "effort:SST", seed, limit)
            held = [row for steps, *row in found.get("motion", []) for _ in range(steps)]
            yield _judged(judge, name, "OMPL SST", seed, np.array(held))
            for planner in ours:
                yield _searched(judge, name, planner, seed, limit)


def _searched(judge: Judge, name: str, planner: str, seed: int, limit: float) -> Cost:
    kind = planners.get(planner)
    known = AS_IN_OMPL if planner == "sst" else {}
    budget = Budget(limit, improve=limit, clock=time.process_time)
    found = kind(**known).solve(judge.problem, seed, budget)
    solved = found.outcome is Outcome.SOLVED
    return _judged(judge, name, f"kinolab {planner}", seed, found.u if solved else np.zeros(0))


def _judged(judge: Judge, name: str, planner: str, seed: int, u: Array) -> Cost:
    """Return what inputs (N, nu) cost, in closed form; OMPL looks at the knots alone."""
    if not len(u):
        return Cost(name, planner, seed, np.inf)
    step = judge.problem.step
    assert np.isfinite(states_under(judge.problem, u)).all()
    cost = step * float((u**2).sum() + PER_SECOND * len(u))
    return Cost(name, planner, seed, cost, judge.at_knots(u) or judge.between(u))


def costs(found: Sequence[Cost]) -> str:
    """Return a table of medians and quartiles, and in how many seeds kinolab's costs no more."""
    rows = []
    for name, planner in dict.fromkeys((one.problem, one.planner) for one in found):
        own = {one.seed: one for one in found if (one.problem, one.planner) == (name, planner)}
        theirs = {o.seed: o.cost for o in found if (o.problem, o.planner) == (name, "OMPL SST")}
        values = np.array([one.cost for one in own.values()])
        low, middle, high = np.quantile(values, [0.25, 0.5, 0.75], method="nearest")
        better = sum(one.cost <= theirs[seed] for seed, one in own.items() if seed in theirs)
        refused = sum(bool(one.fault) for one in own.values())
        rows.append(
            (name, planner, f"{int(np.isfinite(values).sum())}/{len(values)}", str(refused),
             f"{low:.4g} / {middle:.4g} / {high:.4g}",
             "–" if planner == "OMPL SST" else f"{better}/{len(own)}")
        )  # fmt: skip
    head = ("problem", "planner", "solved", "refused", "cost: quartiles", "at most OMPL's")
    return markdown(head, rows)
