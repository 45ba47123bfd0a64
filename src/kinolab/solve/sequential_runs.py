"""Sequential runs in one process: search, simulate, verify and improve, for each seed.

If the verifier rejects a motion, another search with a seed derived from the same one follows.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

from kinolab import trajopt
from kinolab.problem import PlanningTask
from kinolab.problem.objective.costed import without_objective
from kinolab.search import AbstractPlanner, Budget
from kinolab.solve.attempt import attempt
from kinolab.solve.cheaper import Cheapening
from kinolab.solve.guessed import GuessedMotion
from kinolab.solve.improve import PlanImprover
from kinolab.solve.plan import REFUSED, Listeners, PlanResult, Request, stream


def sequential_runs(
    problem: PlanningTask,
    searcher: AbstractPlanner,
    request: Request,
    listeners: Listeners,
) -> Iterator[tuple[PlanResult, float]]:
    """Yield the plan of each seed, and the seconds since the beginning of the first search.

    A search that ends early leaves its remaining time to the next seed; one whose motion the
    verifier rejects leaves it, and its iterations, to another search derived from the same seed.

    Args:
        searcher: The planner with its settings.
        request: Seeds and limits.
        listeners: Of which ``improved`` is called with what is better than all with its seed.
    """
    progress, better = listeners.progress, listeners.improved
    clock, solved, timed = _Clock(progress), False, without_objective(problem)
    searched = problem if searcher.compares_costs else timed
    improving = PlanImprover(timed, searcher, request, lambda: clock.elapsed, better)
    cheapening = None
    if timed is not problem:  # a quick plan is but a beginning, and told to nobody
        improving.on_improved = None
        # On a busy computer being quick may take all of the time, and must not.
        improving.request = replace(request, time_limit=0.5 * request.time_limit)
        cheapening = Cheapening(problem, timed, searcher, request, lambda: clock.elapsed, better)
    quick = improving.request
    budget: Budget | None = None
    last: Budget | None = None
    for seed in request.seeds():
        searches = RepeatedSearch(seed, request.max_iterations)
        while not searches.over:
            left = request.time_limit - clock.elapsed
            if budget is not None and (budget.interrupted or left <= 0):
                break
            last, budget = budget, Budget(left, searches.left, clock.report if progress else None)
            budget.refused = searches.refused.total()
            if listeners.watch:
                listeners.watch(budget)
            if last is not None and last.interrupted:
                break  # interrupted before this budget was registered
            # With optimisation, shortening the first motion is a better use of the time.
            budget.improve = 0.0 if request.optimize else request.improve
            found = None if searches.begun else _guessed(searched, searcher, request, budget)
            found = found or attempt(
                searched, searcher, searches.next_seed, budget, keep_approach=not solved
            )
            clock.add(budget)
            found = replace(found, seed=seed)
            improved = improving.plan(replace(found, price=None), budget)
            if (improved.duration or 0.0) > trajopt.most_time(problem):  # it is no plan yet
                improving.request = request
                improved = improving.plan(improved, budget)
                improving.request = quick
            if cheapening is not None:
                improved = cheapening.plan(found, improved, budget)
            searches.add(found, improved)
        if not searches.begun:
            return
        found = searches.plan()
        solved = solved or found.status == "solved"
        yield found, clock.elapsed
        if found.interrupted or (last is not None and last.interrupted):
            return


def _guessed(
    problem: PlanningTask, searcher: AbstractPlanner, request: Request, budget: Budget
) -> PlanResult | None:
    """Return the verified plan that a guess leads to; None without one, or where it leads nowhere.

    It counts as the planner's own: what improves it may search again.
    """
    if request.guess is None:
        return None
    guess = GuessedMotion(guess=request.guess)
    found = attempt(problem, guess, request.seed, budget, keep_approach=False)
    return replace(found, planner=searcher.name) if found.status == "solved" else None


@dataclass
class RepeatedSearch:
    """State of the repeated searches with one seed.

    Attributes:
        seed: Of the first search.
        most: Iteration limit of all together, None for no limit.
        made: Iterations so far.
        refused: Number of motions that the verifier rejected, by failed checks.
    """

    seed: int
    most: int | None = None
    made: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    _last: PlanResult | None = None
    _best: PlanResult | None = None  # of those rejected
    _again: bool = False  # whether the last motion had been rejected before
    _seen: set[bytes] = field(default_factory=set)
    _timings: Counter[str] = field(default_factory=Counter)

    @property
    def begun(self) -> bool:
        """Whether any search has ended."""
        return self._last is not None

    @property
    def next_seed(self) -> int:
        """Seed of the next search."""
        return stream(self.seed, self.refused.total()) if self.refused else self.seed

    @property
    def left(self) -> int | None:
        """Iterations left for the next search, None for no limit."""
        return None if self.most is None else self.most - self.made

    @property
    def over(self) -> bool:
        """Whether no further search follows: not rejected, interrupted, out of budget, or repeated.

        A repeated motion shows that the planner is deterministic.
        """
        last = self._last
        if last is None:
            return False
        spent = self.left is not None and (self.left <= 0 or not last.iterations)
        return last.status != REFUSED or last.interrupted or self._again or spent

    def add(self, found: PlanResult, last: PlanResult) -> None:
        """Record the outcome of one more search.

        Args:
            last: The same after improvement.
        """
        self.made += found.iterations
        self._timings.update(last.timings)
        self._last = last
        if found.status == REFUSED:
            self.refused[_checks(found)] += 1
            self._again = self._known(found)
        if last.status == REFUSED:
            self._best = min((self._best or last, last), key=lambda plan: plan.rank)

    def plan(self) -> PlanResult:
        """Return the verified plan, else the best rejected one, else the last."""
        last, best = self._last, self._best
        assert last is not None, "a search has ended"
        return replace(
            last if best is None or last.status == "solved" else best,
            iterations=self.made,
            timings=dict(self._timings),
            refused=dict(self.refused),
            interrupted=last.interrupted,
        )

    def _known(self, found: PlanResult) -> bool:
        """Say whether a motion with the same inputs was rejected before, and remember it."""
        if found.trajectory is None:
            return False
        inputs, known = found.trajectory.inputs.tobytes(), len(self._seen)
        self._seen.add(inputs)
        return len(self._seen) == known


def _checks(refused: PlanResult) -> str:
    """Name the failed checks; ``motion`` if it cannot be simulated."""
    certificate = refused.certificate
    return "motion" if certificate is None else ", ".join(c.name for c in certificate.failures)


class _Clock:
    """Time and iterations of all searches so far."""

    def __init__(self, progress: Callable[[int, float], None] | None) -> None:
        self._progress = progress
        self._begun: float | None = None
        self._iterations = 0

    @property
    def elapsed(self) -> float:
        """Seconds since the first search began; 0 until that has ended."""
        return 0.0 if self._begun is None else time.monotonic() - self._begun

    def report(self, iterations: int, seconds: float) -> None:
        """Report the progress of the running search."""
        if self._progress:
            elapsed = seconds if self._begun is None else self.elapsed
            self._progress(self._iterations + iterations, elapsed)

    def add(self, budget: Budget) -> None:
        """Add a finished search."""
        if self._begun is None:
            self._begun = budget.started
        self._iterations += budget.iterations
