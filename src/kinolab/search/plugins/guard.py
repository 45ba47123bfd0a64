"""Run a planner that somebody else wrote, and tell its mistakes apart from kinolab's."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.scenario.user_code import blamed
from kinolab.search.planner import (
    AbstractPlanner,
    Budget,
    Outcome,
    SearchResult,
)

WHERE = "[planner]"


@contextmanager
def answerable(planner: type[AbstractPlanner]) -> Iterator[None]:
    """Turn what a planner's code raises while it is made into a mistake that names the line.

    What kinolab's own planners raise stays as it is: it is a mistake in kinolab.
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
        InputError: If a planner that is not kinolab's fails, or returns what cannot be a result.
    """
    kind = type(planner)
    if _is_kinolabs(kind):
        return planner.solve(problem, seed, budget)
    file = _file_of(kind)
    what = f"{kind.__name__}.solve(){_of(file)}"
    with blamed(f"running {what}", WHERE, file, passing=()):
        result = planner.solve(problem, seed, budget)
    result = _checked(result, what, problem)
    if budget.interrupted and result.outcome is not Outcome.SOLVED:
        return replace(result, outcome=Outcome.INTERRUPTED)  # whatever it took the end for
    return result


def _file_of(planner: type[AbstractPlanner]) -> Path | None:
    """Return the file that defines a class; one that was typed into a notebook has none."""
    file = getattr(sys.modules.get(planner.__module__), "__file__", None)
    return Path(file) if file else None


def _of(file: Path | None) -> str:
    return f" of {file.name}" if file else ""


def _is_kinolabs(planner: type[AbstractPlanner]) -> bool:
    return planner.__module__.partition(".")[0] == "kinolab"


def _checked(result: Any, what: str, problem: PlanningTask) -> SearchResult:
    """Return a result in the types that it promises, for files and reports to rely on.

    Whether it is true is not asked here: every motion is simulated again and verified.
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
