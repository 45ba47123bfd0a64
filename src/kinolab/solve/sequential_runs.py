"""Searches one after the other, with one seed each, in one process."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

from kinolab.problem import Problem
from kinolab.search import Budget
from kinolab.solve.attempt import attempt, make_planner
from kinolab.solve.improve import PlanImprover
from kinolab.solve.plan import Plan
from kinolab.solve.repeated_search import RepeatedSearch
from kinolab.solve.request import Request


def sequential_runs(
    problem: Problem,
    request: Request,
    *,
    progress: Callable[[int, float], None] | None = None,
    watch: Callable[[Budget], None] | None = None,
    better: Callable[[Plan], None] | None = None,
) -> Iterator[tuple[Plan, float]]:
    """Yield the plan of each seed, and the seconds from the beginning of the first search.

    A search that ends by itself leaves the rest of the time to the next seed; one whose motion the
    verifier refuses leaves it, and its iterations, to another search with the same seed's numbers.

    Args:
        problem: What to solve.
        request: With which planner and seeds, and how long.
        progress: Called during a search with the iterations and seconds so far, of all searches.
        watch: Called with the budget before each search, so that it can be interrupted.
        better: Called with each verified plan that is better than those before with its seed.
    """
    searcher = make_planner(problem, request.planner, request.settings)
    clock, solved = _Clock(progress), False
    improving = PlanImprover(problem, searcher, request, lambda: clock.elapsed, watch, better)
    budget: Budget | None = None
    last: Budget | None = None
    for seed in request.seeds():
        searches = RepeatedSearch(seed, request.max_iterations)
        while not searches.over:
            left = request.time_limit - clock.elapsed
            if budget is not None and (budget.interrupted or left <= 0):
                break
            last = budget
            budget = Budget(left, searches.left, clock.report if progress else None)
            if watch:
                watch(budget)
            if last is not None and last.interrupted:
                break  # that was meant for this one, which was not known yet
            if request.optimize:
                budget.improve = 0.0  # the time is better spent on making the first motion shorter
            found = attempt(problem, searcher, searches.next_seed, budget, keep_approach=not solved)
            clock.add(budget)
            found = replace(found, seed=seed)
            searches.add(found, improving.plan(found, budget))
        if not searches.begun:
            return
        found = searches.plan()
        solved = solved or found.status == "solved"
        yield found, clock.elapsed
        if found.interrupted or (last is not None and last.interrupted):
            return


class _Clock:
    """Time and iterations of all searches so far."""

    def __init__(self, progress: Callable[[int, float], None] | None) -> None:
        self._progress = progress
        self._begun: float | None = None
        self._iterations = 0

    @property
    def elapsed(self) -> float:
        """Seconds since the first search began; 0 before its end."""
        return 0.0 if self._begun is None else time.monotonic() - self._begun

    def report(self, iterations: int, seconds: float) -> None:
        """Pass on how far the running search is."""
        if self._progress:
            elapsed = seconds if self._begun is None else self.elapsed
            self._progress(self._iterations + iterations, elapsed)

    def add(self, budget: Budget) -> None:
        """Count a search that is over."""
        if self._begun is None:
            self._begun = budget.started
        self._iterations += budget.iterations
