"""The planner of scenarios that name none: those that the measurements recommend, in turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import ClassVar, final

from kinolab.compiled import AbstractCompiledPlanner, AbstractGrowth, Search
from kinolab.planners.kpiece_fast import KPIECEFast
from kinolab.planners.rrt_fast import RRTFast
from kinolab.problem import Problem
from kinolab.search import with_default

MEMBERS: tuple[type[AbstractCompiledPlanner], ...] = (KPIECEFast, RRTFast)


@final
@dataclass(frozen=True, kw_only=True)
class Auto(AbstractCompiledPlanner):
    """A portfolio: rounds of kpiece_fast and of rrt_fast in turn, each longer than the one before.

    The first solves nearly everything that we measure; the second is not led astray by cells.

    Source: Gomes, Selman, Algorithm portfolios, Artificial Intelligence 126(1-2), 2001.
    """

    name: ClassVar[str] = "auto"

    inputs_tried: int = with_default(4, AbstractCompiledPlanner, "inputs_tried")
    goal_zoom: float = with_default(10.0, AbstractCompiledPlanner, "goal_zoom")
    restart_after: int = with_default(10_000, AbstractCompiledPlanner, "restart_after")
    last_step_every: int = with_default(1000, AbstractCompiledPlanner, "last_step_every")

    def growth(self, problem: Problem, search: Search) -> AbstractGrowth:
        """Return what grows the tree."""
        shared = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return _Rounds([member(**shared).growth(problem, search) for member in MEMBERS])


class _Rounds(AbstractGrowth):
    """Trees of which one grows, and another one from the next beginning on."""

    def __init__(self, trees: Sequence[AbstractGrowth]) -> None:
        self._trees, self._turn = trees, -1

    def begin(self) -> None:
        """Begin the next tree."""
        if self._turn < 0:
            for tree in self._trees:  # all are compiled before the clock starts
                tree.begin()
                tree.grow(0)
        self._turn += 1
        self._now = self._trees[self._turn % len(self._trees)]
        self._now.begin()
        self.nodes, self.best = self._now.nodes, self._now.best

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow by some iterations."""
        return self._now.grow(iterations)
