"""Stable Sparse RRT (SST), compiled."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, final

import numpy as np

from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.search import setting
from kinolab.search.tree import (
    UNBOUNDED_STEPS,
    AbstractCompiledPlanner,
    AbstractTreeExtension,
    SearchState,
)
from kinolab.search.tree.sampled.sampled_growth import grow_sparsely
from kinolab.search.tree.sampled.witnesses import begin_witnesses, sweep, witnesses
from kinolab.search.tree.threads import Growth, ThreadedTree
from kinolab.search.tree.tree import begin_without_neighbours, tree


@final
@dataclass(frozen=True, kw_only=True)
class SST(AbstractCompiledPlanner):
    """Stable Sparse RRT, compiled: one cheapest state per small ball keeps the tree sparse.

    Continues to shorter motions in the same tree, for up to ``improve`` seconds.

    Source: Li, Littlefield, Bekris, IJRR 35(5), 2016.
    """

    name: ClassVar[str] = "sst"

    selection_radius: float = setting(
        0.2,
        0.0,
        1e6,
        unit="metric",
        meaning="Radius around a sample within which the cheapest state is grown, not the nearest.",
    )
    improving_radius: float = setting(
        1.5,
        0.0,
        1e6,
        unit="metric",
        meaning="The same, once a motion into the goal is known.",
    )
    pruning_radius: float = setting(
        0.1,
        0.0,
        1e6,
        unit="metric",
        meaning="Radius around a state within which only the cheapest one is grown.",
    )
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
            return _SstExtension(self, search)
        growth = Growth(
            self.goal_bias,
            self.control_samples,
            self.min_steps,
            self.max_steps,
            sparse=1,
            selection_radius=self.selection_radius,
            improving_radius=self.improving_radius,
            pruning_radius=self.pruning_radius,
        )
        return ThreadedTree(search, growth, self.max_nodes, self.threads)


class _SstExtension(AbstractTreeExtension):
    def __init__(self, planner: SST, search: SearchState) -> None:
        arrays, capacity = search.problem, planner.max_nodes
        self.nodes, self.best = tree(arrays, capacity, neighbours=False), np.zeros(2)
        self._planner, self._search, self._tree = planner, Record(search), Record(self.nodes)
        self._witnesses, self._most = Record(witnesses(arrays, capacity)), UNBOUNDED_STEPS

    def begin(self) -> None:
        """Clear the tree to its start."""
        begin_without_neighbours(self._search, self._tree)
        begin_witnesses(self._search, self._tree, self._witnesses)
        self.best[:] = 0.0, np.inf

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations."""
        planner = self._planner
        radius = (
            planner.selection_radius if self._most == UNBOUNDED_STEPS else planner.improving_radius
        )
        ended, made = grow_sparsely(
            self._search, self._tree, self._witnesses, self.best, iterations, self._most,
            radius, planner.pruning_radius, planner.goal_bias,
            planner.control_samples, planner.min_steps, planner.max_steps,
        )  # fmt: skip
        return int(ended), int(made)

    def shorten(self, steps: int) -> bool:
        """Search only for motions of fewer steps; prune nodes that cannot lead to any."""
        self._most = steps
        sweep(self._tree, self._witnesses, self.best, steps)
        return steps > self._planner.min_steps
