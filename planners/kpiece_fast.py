"""A search by cells that knows the way around obstacles, compiled as a whole."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from numba import typeof

from kinolab.numerics.struct import Record
from kinolab.problem import Problem
from kinolab.search import setting, with_default
from kinolab.search.tree import AbstractCompiledPlanner, AbstractGrowth, Search
from kinolab.search.tree.cost_to_go import find_ways, leads
from kinolab.search.tree.kpiece_grid import cells
from kinolab.search.tree.kpiece_kernel import explore, start_in_a_cell
from kinolab.search.tree.tree import tree


@final
@dataclass(frozen=True, kw_only=True)
class KPIECEFast(AbstractCompiledPlanner):
    """Kinodynamic exploration of cells, compiled; cells nearer to the goal on a free way lead.

    How far a cell is from the goal is worked out beforehand, around obstacles and without dynamics.
    Of several inputs the one is held that leads furthest on that way.

    Source: Sucan, Kavraki, WAFR 2008; Plaku, Kavraki, Vardi, IEEE Transactions on Robotics 26(3),
    2010, for leads.
    """

    name: ClassVar[str] = "kpiece_fast"

    cells: int = setting(40, 1, 1000, meaning="Cells along each coordinate that is divided.")
    greed: float = setting(
        2.0, 0.0, 10.0, meaning="Power of the way to the goal by which cells count less."
    )
    inputs_tried: int = with_default(4, AbstractCompiledPlanner, "inputs_tried")
    goal_zoom: float = with_default(10.0, AbstractCompiledPlanner, "goal_zoom")
    restart_after: int = with_default(10_000, AbstractCompiledPlanner, "restart_after")
    last_step_every: int = with_default(1000, AbstractCompiledPlanner, "last_step_every")

    def growth(self, problem: Problem, search: Search) -> AbstractGrowth:
        """Return what grows the tree."""
        return _Growth(self, problem, search)


class _Growth(AbstractGrowth):
    def __init__(self, planner: KPIECEFast, problem: Problem, search: Search) -> None:
        question, most = search.question, planner.max_nodes
        self.nodes, self.best = tree(question, most, neighbours=False), np.zeros(2)
        self._planner, self._search, self._tree = planner, Record(search), Record(self.nodes)
        self._cells = Record(cells(problem, question, most, planner.goal_zoom, planner.cells))
        self._leads, self._led = Record(leads(problem)), False

    def begin(self) -> None:
        """Leave nothing in the tree but the start."""
        start_in_a_cell(self._search, self._tree, self._cells)
        self.best[:] = 0.0, np.inf

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow by some iterations; the ways of the cells are found before the first."""
        planner = self._planner
        if not self._led:
            self._led = iterations > 0
            arguments = self._search, self._leads, self.nodes.now
            if self._led:
                find_ways(*arguments)
            else:
                find_ways.compile(tuple(map(typeof, arguments)))  # no part of a search
        ended, made = explore(
            self._search, self._tree, self._cells, self._leads, self.best, iterations,
            planner.min_steps, planner.max_steps, float(planner.greed), planner.inputs_tried,
        )  # fmt: skip
        return int(ended), int(made)
