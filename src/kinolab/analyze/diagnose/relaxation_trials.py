"""Short searches with one relaxation each: which one makes the search succeed?"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from kinolab import planners
from kinolab.analyze.diagnose.relaxations import OBSTACLES, Relaxation, relaxations
from kinolab.errors import KinolabError
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome
from kinolab.simulation.reference import resimulate
from kinolab.solve import PlanResult, make_planner

TRIAL_SECONDS = 2.0  # of one search


@dataclass(frozen=True)
class RelaxationTrial:
    """Result of one relaxation.

    Attributes:
        change: Its name.
        words: The change in words.
        solved: Whether the search reached the goal.
        seconds: How long it took.
    """

    change: str
    words: str
    solved: bool
    seconds: float


def relaxation_trials(
    problem: PlanningTask,
    plan: PlanResult,
    settings: Mapping[str, Any],
    seconds: float,
    say: Callable[[str], None] = lambda _: None,
    max_iterations: int | None = None,
) -> tuple[RelaxationTrial, ...]:
    """Search again with one thing changed at a time.

    Args:
        plan: The failed result: planner, seed and iterations.
        settings: Planner settings other than the scenario's.
        seconds: For all searches together.
        say: Receives progress messages.
        max_iterations: Of each search; as many as the failed one made when left out.
    """
    most = plan.iterations if max_iterations is None else max_iterations
    end = time.monotonic() + seconds
    planner = make_planner(problem, _known(plan.planner), dict(settings))
    tried = []
    for change in relaxations(problem, planner):
        left = min(TRIAL_SECONDS, end - time.monotonic())
        if left < 0.2:  # [s] shortest search worth starting
            break
        say(f"trying again {change.words}")
        begun = time.monotonic()
        budget = Budget(left, max(most, 1))
        solved = _solved(change, planner, plan.seed, budget)
        tried.append(RelaxationTrial(change.name, change.words, solved, time.monotonic() - begun))
    return tuple(tried)


def _known(name: str) -> str | None:
    """Return a planner's name; None for one from a file, which the scenario names in full."""
    try:
        planners.get(name)
    except KinolabError:
        return None
    return name


def _solved(change: Relaxation, planner: AbstractPlanner, seed: int, budget: Budget) -> bool:
    """Whether the planner's motion reaches the relaxed goal; collisions are not verified."""
    kept = {field.name: getattr(planner, field.name) for field in fields(planner)}
    searcher = type(planner)(**kept | dict(change.settings))
    try:
        result = searcher.solve(change.problem, seed, budget)
        if result.outcome is not Outcome.SOLVED:
            return False
        end = resimulate(change.problem, result.t, result.u).x[-1]
    except KinolabError:
        return False
    return change.problem.goal_excess(end) <= 1.0


def trial_sentences(tried: Sequence[RelaxationTrial]) -> Iterator[str]:
    """Name the change that makes the search succeed, or all that do so alone."""
    worked = {retry.change: retry.words for retry in tried if retry.solved}
    if list(worked) == [OBSTACLES]:
        words = worked[OBSTACLES]
        yield f"{words[0].upper()}{words[1:]} a plan is found, so they are what is in the way."
    elif len(worked) == 1:
        yield f"One change makes it work: a search {next(iter(worked.values()))} finds a plan."
    elif worked:
        yield f"Each of these alone makes it work: a search {', '.join(worked.values())}."
    elif tried:
        failed = ", ".join(retry.words for retry in tried)
        yield f"No single change made a search of {TRIAL_SECONDS:g} s succeed: {failed}."
