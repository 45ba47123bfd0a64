"""A tree that grows toward samples, and base class of the planners that grow one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.numerics.arrays import allocate
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.search.tree.compiled_planner import AbstractCompiledPlanner
from kinolab.search.tree.extensions import Ends
from kinolab.search.tree.sampled.sampled_growth import (
    IN_COST_SPACE,
    NEAREST,
    SPARSE,
    Growth,
    Worker,
    begin,
    cost_index,
    grow,
    prune,
)
from kinolab.search.tree.sampled.witnesses import witnesses
from kinolab.search.tree.search_state import SearchState
from kinolab.search.tree.tree import tree
from kinolab.search.tree.tree_extension import UNBOUNDED_STEPS, AbstractTreeExtension
from kinolab.settings import setting


class SampledTree(AbstractTreeExtension):
    """A tree of RRT, of SST or of AO-RRT.

    Args:
        growth: How it grows.
        ends: Most ends of extensions that wait to be added.
    """

    def __init__(self, search: SearchState, growth: Growth, max_nodes: int, ends: int = 1) -> None:
        arrays, kind = search.problem, growth.kind
        self.nodes = tree(arrays, max_nodes, neighbours=kind != SPARSE)
        self.best = np.zeros(2)
        self._most, self._growth = np.full(1, UNBOUNDED_STEPS, np.int64), growth
        sizes = {"capacity": ends, "nx": len(arrays.start), "nu": len(arrays.input_lower)}
        self._first = Record(
            Worker(
                search,
                self.nodes,
                growth,
                witnesses(arrays, max_nodes if kind == SPARSE else 1),
                cost_index(arrays, max_nodes if kind == IN_COST_SPACE else 1),
                allocate(Ends, sizes),
                self._most,
                self.best,
            )
        )

    def begin(self) -> None:
        """Clear the tree to its start."""
        begin(self._first)

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations; return GROWING, REACHED or FULL, and the number made."""
        ended, made = grow(self._first, iterations, False)
        return int(ended), int(made)

    def shorten(self, steps: int) -> bool:
        """Search only for motions of fewer steps from now on; return whether any may exist.

        Of a sparse tree nodes that cannot lead to any are pruned; one in state-cost space is begun
        anew. Trees of RRT find none.
        """
        if self._growth.kind == NEAREST:
            return False
        self._most[0] = steps
        if self._growth.kind == SPARSE:
            prune(self._first)
        else:
            self.begin()
        return steps > self._growth.min_steps


@dataclass(frozen=True, kw_only=True)
class AbstractSampledPlanner(AbstractCompiledPlanner):
    """A planner whose tree grows toward samples."""

    goal_bias: float = setting(
        0.05, 0.0, 1.0, meaning="Probability of growing toward the goal instead of anywhere."
    )

    def growth(self) -> Growth:
        """Return how the tree grows."""
        return Growth(self.goal_bias, self.control_samples, self.min_steps, self.max_steps)

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:  # noqa: ARG002
        """Return the tree extension."""
        return SampledTree(search, self.growth(), self.max_nodes)
