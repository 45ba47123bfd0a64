"""KPIECE, compiled, with a cost-to-go around obstacles as its heuristic."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np
from numba import typeof

from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.search import setting, with_default
from kinolab.search.tree import (
    UNBOUNDED_STEPS,
    AbstractCompiledPlanner,
    AbstractTreeExtension,
    SearchState,
)
from kinolab.search.tree.kpiece.cost_to_go import compute_cost_to_go, cost_to_go_grid
from kinolab.search.tree.kpiece.kpiece_grid import kpiece_grid
from kinolab.search.tree.kpiece.kpiece_kernel import explore, start_in_a_cell
from kinolab.search.tree.tree import tree

BOUND_FRACTION = 0.9  # of the steps of a motion, for the next one
# Fractions of the bound's pace along the cost to go, of trees in turn: near 1 a tree is narrow, and
# finds a motion soon if there is one that goes the shortest way.
PACES = (0.9, 0.6, 0.8)


@final
@dataclass(frozen=True, kw_only=True)
class KPIECEFast(AbstractCompiledPlanner):
    """KPIECE, compiled; cells nearer to the goal along a collision-free path are preferred.

    The cost to go of every cell is computed beforehand, around obstacles and without dynamics. Of
    several inputs the one that reaches the least cost to go is applied; where it leads if the
    machine goes straight on for a while counts, too, as it does for cells. Continues to shorter
    motions in new trees, each below the duration or the cost of the last one, for up to ``improve``
    seconds.

    Source: Sucan, Kavraki, WAFR 2008; Plaku, Kavraki, Vardi, IEEE Transactions on Robotics 26(3),
    2010, for the cost-to-go; Hauser, Zhou, IEEE Transactions on Robotics 32(6), 2016, for trees
    below a bound.
    """

    compares_costs: ClassVar[bool] = True
    name: ClassVar[str] = "kpiece_fast"

    cells: int = setting(40, 1, 1000, meaning="Cells along each coordinate that is divided.")
    cost_to_go_exponent: float = setting(
        2.0, 0.0, 10.0, meaning="Exponent of the cost-to-go by which cells count less."
    )
    control_samples: int = with_default(4, AbstractCompiledPlanner, "control_samples")
    goal_region_scale: float = with_default(10.0, AbstractCompiledPlanner, "goal_region_scale")
    restart_after: int = with_default(10_000, AbstractCompiledPlanner, "restart_after")
    # An attempt takes flat machines as long as 2000 iterations or more, and most trees need none.
    goal_connection_period: int = with_default(
        5000, AbstractCompiledPlanner, "goal_connection_period"
    )

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:
        """Return the tree extension."""
        return _KpieceExtension(self, problem, search)


class _KpieceExtension(AbstractTreeExtension):
    def __init__(self, planner: KPIECEFast, problem: PlanningTask, search: SearchState) -> None:
        arrays, most = search.problem, planner.max_nodes
        self.nodes = tree(arrays, most, neighbours=False, kept_steps=planner.max_steps)
        self.best = np.zeros(2)
        self._planner, self._search, self._tree = planner, Record(search), Record(self.nodes)
        self._cells = Record(
            kpiece_grid(problem, arrays, most, planner.goal_region_scale, planner.cells)
        )
        self._leads, self._led = Record(cost_to_go_grid(problem)), False
        self._most, self._turn = float(UNBOUNDED_STEPS), -1

    def begin(self) -> None:
        """Clear the tree to its start; below a bound the next one of PACES holds."""
        self._turn += self._most < UNBOUNDED_STEPS
        start_in_a_cell(self._search, self._tree, self._cells)
        self.best[:] = 0.0, np.inf

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations; the cost to go is computed before the first."""
        planner = self._planner
        if not self._led:
            self._led = iterations > 0
            arguments = self._search, self._leads, self.nodes.now
            if self._led:
                compute_cost_to_go(*arguments)
            else:
                compute_cost_to_go.compile(tuple(map(typeof, arguments)))  # before the clock starts
        pace = PACES[self._turn % len(PACES)] if self._most < UNBOUNDED_STEPS else 0.0
        ended, made = explore(
            self._search, self._tree, self._cells, self._leads, self.best, iterations,
            self._most, pace, planner.min_steps, planner.max_steps,
            planner.cost_to_go_exponent, planner.control_samples,
        )  # fmt: skip
        return int(ended), int(made)

    def shorten(self, steps: int) -> bool:
        """Grow new trees, only of motions that may take a good deal fewer steps."""
        self._most, self._turn = float(int(BOUND_FRACTION * steps)), -1
        self.begin()
        return self._most > self._planner.min_steps
