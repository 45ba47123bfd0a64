"""Path-directed subdivision trees (PDST), compiled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.search.tree import AbstractCompiledPlanner, AbstractTreeExtension, SearchState
from kinolab.search.tree.pdst.pdst_kernel import grow_motions, start_with_a_motion
from kinolab.search.tree.pdst.subdivision import subdivision
from kinolab.search.tree.tree import tree


@final
@dataclass(frozen=True, kw_only=True)
class PDST(AbstractCompiledPlanner):
    """Path-directed subdivision trees, compiled: motions, not states, take turns in growing.

    Each motion of the tree lies in one cell of a subdivision that becomes finer where the tree
    grows. The one that was grown least often for the size of its cell is grown next, from a random
    state along it. No metric is needed.

    Source: Ladd, Kavraki, Motion planning in the presence of drift, underactuation and discrete
    system changes, RSS 2005.
    """

    name: ClassVar[str] = "pdst"

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:
        """Return the tree extension."""
        return _PdstExtension(self, problem, search)


class _PdstExtension(AbstractTreeExtension):
    def __init__(self, planner: PDST, problem: PlanningTask, search: SearchState) -> None:
        arrays, most = search.problem, planner.max_nodes
        self.nodes, self.best = tree(arrays, most, neighbours=False), np.zeros(2)
        self._planner, self._search, self._tree = planner, Record(search), Record(self.nodes)
        self._cells = Record(subdivision(problem, most))

    def begin(self) -> None:
        """Clear the tree to its start."""
        start_with_a_motion(self._search, self._tree, self._cells)
        self.best[:] = 0.0, np.inf

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations."""
        planner = self._planner
        ended, made = grow_motions(
            self._search, self._tree, self._cells, self.best, iterations,
            planner.min_steps, planner.max_steps,
        )  # fmt: skip
        return int(ended), int(made)
