"""RRT, compiled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.search import setting
from kinolab.search.tree import AbstractCompiledPlanner, AbstractTreeExtension, SearchState
from kinolab.search.tree.sampled.directed_control import grow
from kinolab.search.tree.threads import Growth, ThreadedTree
from kinolab.search.tree.tree import begin, tree


@final
@dataclass(frozen=True, kw_only=True)
class RRTFast(AbstractCompiledPlanner):
    """Rapidly-exploring random tree, compiled; of several inputs the one that leads nearest.

    Nodes whose extensions often failed are extended less often.

    Source: LaValle, Kuffner, IJRR 20(5), 2001; Cheng, LaValle, Reducing metric sensitivity in
    randomized trajectory design, IROS 2001, for nodes whose extensions often fail.
    """

    name: ClassVar[str] = "rrt_fast"

    goal_bias: float = setting(
        0.05, 0.0, 1.0, meaning="Probability of growing toward the goal instead of anywhere."
    )
    threads: int = setting(
        1,
        1,
        64,
        unit="threads",
        meaning="Threads that grow the tree; plans depend on their number, not on the computer.",
    )

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:  # noqa: ARG002
        """Return the tree extension."""
        if self.threads == 1:
            return _RrtExtension(self, search)
        growth = Growth(self.goal_bias, self.control_samples, self.min_steps, self.max_steps)
        return ThreadedTree(search, growth, self.max_nodes, self.threads)


class _RrtExtension(AbstractTreeExtension):
    def __init__(self, planner: RRTFast, search: SearchState) -> None:
        self.nodes, self.best = tree(search.problem, planner.max_nodes), np.zeros(2)
        self._planner, self._search, self._tree = planner, Record(search), Record(self.nodes)

    def begin(self) -> None:
        """Clear the tree to its start."""
        begin(self._search, self._tree)
        self.best[:] = 0.0, np.inf

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations."""
        planner = self._planner
        ended, made = grow(
            self._search, self._tree, self.best, iterations,
            planner.goal_bias, planner.control_samples, planner.min_steps, planner.max_steps,
        )  # fmt: skip
        return int(ended), int(made)
