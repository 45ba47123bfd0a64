"""Run third-party planners, and attribute their errors to them."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.files import LOG
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.scenario.user_code import blamed
from kinolab.search.budget import LATE, Budget
from kinolab.search.planner import AbstractPlanner
from kinolab.search.result import Outcome, SearchResult

WHERE = "[planner]"


@contextmanager
def answerable(planner: type[AbstractPlanner]) -> Iterator[None]:
    """Convert exceptions of a planner's constructor into errors that name the line.

    Exceptions of kinolab's own planners pass unchanged: they are bugs in kinolab.
    """
    if _is_kinolabs(planner):
        yield
        return
    file = _file_of(planner)
    with blamed(f"making {planner.__name__}{_of(file)}", WHERE, file):
        yield


def search(
    planner: AbstractPlanner, problem: PlanningTask, seed: int, budget: Budget
) -> SearchResult:
    """Search with any planner.

    Raises:
        InputError: If a third-party planner fails or returns an invalid result.
    """
    kind = type(planner)
    if _is_kinolabs(kind):
        return planner.solve(problem, seed, budget)
    file = _file_of(kind)
    what = f"{kind.__name__}.solve(){_of(file)}"
    with _overseen(budget, what), blamed(f"running {what}", WHERE, file, passing=()):
        result = planner.solve(problem, seed, budget)
        late = budget.unasked
    result = _checked(result, what, problem)
    if late:
        result = replace(result, warnings=(*result.warnings, _unasked(what, budget)))
    if budget.interrupted and result.outcome is not Outcome.SOLVED:
        return replace(result, outcome=Outcome.INTERRUPTED)  # whatever it reported
    return result


@contextmanager
def _overseen(budget: Budget, what: str) -> Iterator[None]:
    """Log it once if a search goes on after its time and does not ask whether it may."""
    ended = threading.Event()

    def oversee() -> None:
        while not ended.wait(LATE / 2.0):
            if budget.unasked:
                LOG.warning("%s Ctrl-C ends it.", _unasked(what, budget))
                return

    threading.Thread(target=oversee, daemon=True).start()
    try:
        yield
    finally:
        ended.set()


def _unasked(what: str, budget: Budget) -> str:
    """Say that a search does not ask its budget, and what would work."""
    since = f"since {budget.asked:.3g} s" if budget.asked else "once"
    return (
        f"{what} does not ask its budget: it has run for {budget.elapsed:.3g} s, where the limit "
        f"is {budget.time_limit:g} s, and has not called budget.spent() {since}. "
        "Let each iteration begin with: if budget.spent(): break"
    )


def _file_of(planner: type[AbstractPlanner]) -> Path | None:
    """Return the file that defines a class; None for one defined in a notebook."""
    file = getattr(sys.modules.get(planner.__module__), "__file__", None)
    return Path(file) if file else None


def _of(file: Path | None) -> str:
    return f" of {file.name}" if file else ""


def _is_kinolabs(planner: type[AbstractPlanner]) -> bool:
    return planner.__module__.partition(".")[0] == "kinolab"


def _checked(result: Any, what: str, problem: PlanningTask) -> SearchResult:
    """Validate a result and convert it to the declared types, for files and reports.

    The motion itself is not checked here: every motion is re-simulated and verified.
    """
    if not isinstance(result, SearchResult) or not isinstance(result.outcome, Outcome):
        kind = type(getattr(result, "outcome", result)).__name__
        wanted = "an Outcome" if isinstance(result, SearchResult) else "a SearchResult"
        raise InputError([Mistake(WHERE, f"{what} returned {kind}, not {wanted}.")])
    with blamed(f"reading what {what} returned", WHERE):
        t, u = (np.asarray(values, dtype=float) for values in (result.t, result.u))
        iterations = int(result.iterations)
        statistics = _numbers(result.statistics)
        rejections = {str(cause): _numbers(shares) for cause, shares in result.rejections.items()}
    _check_rows(t, u, what, problem.model.nu)
    told: dict[str, Any] = {
        "iterations": iterations,
        "statistics": statistics,
        "rejections": rejections,
    }
    return replace(result, t=t, u=u, **told)


def _numbers(named: Mapping[str, float]) -> dict[str, float]:
    return {str(name): float(value) for name, value in named.items()}


def _check_rows(t: Array, u: Array, what: str, nu: int) -> None:
    if t.ndim != 1 or len(t) == 0 or u.shape != (len(t) - 1, nu):
        said = f"{what} returned times of shape {t.shape} and inputs of shape {u.shape}."
        remedy = f"N inputs have the shape (N, {nu}), and the times of their ends (N+1,)."
        raise InputError([Mistake(WHERE, said, remedy)])
    if not (np.isfinite(t).all() and np.isfinite(u).all()):
        raise InputError([Mistake(WHERE, f"{what} returned numbers that are not finite.")])
