"""AO-RRT, compiled: trees in state-cost space, restarted below the best duration so far."""

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
from kinolab.search.tree.sampled.cost_index import begin_cost_index, cost_index, grow_below
from kinolab.search.tree.sampled.directed_control import grow
from kinolab.search.tree.tree import begin, tree


@final
@dataclass(frozen=True, kw_only=True)
class AORRT(AbstractCompiledPlanner):
    """Asymptotically optimal RRT, compiled: each tree stays below the best cost so far.

    The first is the tree of rrt_fast; others follow for up to ``improve`` seconds.

    Source: Hauser, Zhou, IEEE Transactions on Robotics 32(6), 2016.
    """

    name: ClassVar[str] = "ao_rrt"

    goal_bias: float = setting(
        0.05, 0.0, 1.0, meaning="Probability of growing toward the goal instead of anywhere."
    )
    cost_weight: float = setting(
        1.0,
        0.0,
        1e6,
        unit="extents",
        meaning="Distance in cost between start and end of the best motion, in the metric.",
    )

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:  # noqa: ARG002
        """Return the tree extension."""
        return _AoRrtExtension(self, search)


class _AoRrtExtension(AbstractTreeExtension):
    def __init__(self, planner: AORRT, search: SearchState) -> None:
        self.nodes, self.best = tree(search.problem, planner.max_nodes), np.zeros(2)
        self._planner, self._search, self._tree = planner, Record(search), Record(self.nodes)
        self._costs, self._most = (
            Record(cost_index(search.problem, planner.max_nodes)),
            UNBOUNDED_STEPS,
        )

    def begin(self) -> None:
        """Clear the tree to its start."""
        begin(self._search, self._tree)
        begin_cost_index(self._search, self._tree, self._costs)
        self.best[:] = 0.0, np.inf

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations, below the cost bound if there is one."""
        planner = self._planner
        how = planner.goal_bias, planner.control_samples, planner.min_steps, planner.max_steps
        if self._most == UNBOUNDED_STEPS:
            ended, made = grow(self._search, self._tree, self.best, iterations, *how)
        if self._most < UNBOUNDED_STEPS or not iterations:  # none: compile only
            ended, made = grow_below(
                self._search, self._tree, self._costs, self.best, iterations, self._most,
                planner.cost_weight, *how,
            )  # fmt: skip
        return int(ended), int(made)

    def shorten(self, steps: int) -> bool:
        """Restart with a cost bound in steps."""
        self._most = steps
        self.begin()
        return steps > self._planner.min_steps
