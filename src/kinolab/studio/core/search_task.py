"""The search that the studio has done in the background."""

from __future__ import annotations

import re
import signal
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult
from kinolab.studio.core.background_work import Told
from kinolab.trajectory import Trajectory

SET = re.compile(r"--set (\S+=\S+)")  # a change as the diagnosis words it


@dataclass(frozen=True, eq=False)
class Explored:
    """The search graph so far, as segments of the leading body, shape (edges, 2, 3), in [m]."""

    segments: Array


@dataclass(frozen=True)
class Improved:
    """A verified plan that is better than those before."""

    plan: PlanResult


@dataclass(frozen=True)
class Searched:
    """What came of a search.

    Attributes:
        plan: What it ended with.
        sentences: Why nothing was found.
        changes: Changes that let a short search succeed, as ``--set`` takes them.
    """

    plan: PlanResult
    sentences: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()


def search(
    tell: Callable[[Any], None],
    problem: PlanningTask,
    guess: Trajectory | None = None,
    improve: float | None = None,
) -> Searched:
    """Search for a plan, and for the reason where there is none.

    Args:
        tell: Sends what there is to see meanwhile.
        problem: To be solved.
        guess: A motion that is tried first.
        improve: Work on making it shorter, in [s]; the scenario's when left out.
    """
    from kinolab.analyze.diagnose import diagnose
    from kinolab.show.scene.scenes import branches
    from kinolab.solve import solve

    asked_to_end = threading.Event()

    def watch(budget: Any) -> None:
        def end(*_: Any) -> None:
            asked_to_end.set()
            budget.end()

        signal.signal(signal.SIGTERM, end)
        budget.viewer = lambda graph: tell(Explored(branches(problem, graph)))
        budget.told = lambda words: tell(Told(words))
        if asked_to_end.is_set():
            budget.end()

    plan = solve(
        problem,
        guess=guess,
        improve=improve,
        progress=lambda count, seconds: tell(Told(f"{count} iterations in {seconds:.1f} s")),
        watch=watch,
        improved=lambda plan: tell(Improved(plan)),
    )
    if plan.graph is not None:
        tell(Explored(branches(problem, plan.graph)))
    if plan.status == "solved" or asked_to_end.is_set():
        return Searched(plan)
    tell(Told("looking for the reason"))
    found = diagnose(problem, plan, progress=lambda words: tell(Told(words)))
    changes = [
        SET.findall(trial.words)[0]
        for trial in found.retries
        if trial.solved and SET.search(trial.words)
    ]
    return Searched(plan, tuple(found.sentences), tuple(changes))
