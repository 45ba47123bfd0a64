"""Sub-searches interleaved with the growth of a tree, such as goal connections."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.budget import Budget
from kinolab.search.tree.tree import controls_to
from kinolab.search.tree.tree_extension import AbstractTreeExtension

if TYPE_CHECKING:
    from kinolab.steering.goal_connection import SteeredGoalConnection


class SubSearch(Protocol):
    """A search interleaved with the growth of a tree.

    Attributes:
        due: Iterations of the tree until its next turn.
    """

    due: float

    @property
    def statistics(self) -> Mapping[str, float]:
        """Counters to report, by name."""

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:
        """Take a turn if due; return inputs (N, nu) from the start into the goal, or None."""

    def close(self) -> None:
        """End what is left unfinished between two turns."""


class InterleavedSearches:
    """Several interleaved sub-searches."""

    def __init__(self, members: Sequence[SubSearch]) -> None:
        self._members = members

    @property
    def due(self) -> float:
        """Iterations of the tree until the next turn of any; infinite where there are none."""
        return min((member.due for member in self._members), default=math.inf)

    @property
    def statistics(self) -> dict[str, float]:
        """The counters of all of them, by name."""
        return {name: n for member in self._members for name, n in member.statistics.items()}

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:
        """Advance all of them; return the first solution (N, nu), or None."""
        found = [member.advance(iterations, tree) for member in self._members]
        return next((inputs for inputs in found if inputs is not None), None)

    def close(self) -> None:
        """End what they have left unfinished."""
        for member in self._members:
            member.close()


class GoalConnections:
    """Attempts goal connections from random nodes, where growth alone would have to hit the goal.

    They take no more time than the tree does, but for the last one.

    Args:
        period: Iterations between attempts; 0 for never.
        goal_region_scale: What counts as near the goal, in its tolerances.
        seed: Random seed of the node selection.

    Attributes:
        due: Iterations until the next attempt.
    """

    def __init__(
        self,
        problem: PlanningTask,
        period: int,
        goal_region_scale: float,
        seed: int,
        budget: Budget,
    ) -> None:
        self._problem, self._scale, self._budget = problem, goal_region_scale, budget
        self._period = self.due = period or math.inf
        self._generator = np.random.default_rng(seed)
        self.statistics: Mapping[str, float] = {}  # none before the first attempt
        self._propagations = 0

    @cached_property
    def _connection(self) -> SteeredGoalConnection:
        with self._budget.preparing():
            from kinolab.steering.goal_connection import (
                SteeredGoalConnection,  # imports SciPy's optimisers
            )

            return SteeredGoalConnection(self._problem, 1, self._scale, lambda: self._budget.over)

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:
        """Make an attempt if due; return inputs (N, nu) from the start into the goal, or None."""
        self.due -= iterations
        if self.due > 0:
            return None
        self.due = self._period
        # three steps of a connection, which checks nothing, take as long as one of the tree
        if 3.0 * tree.steps_made < self._propagations:
            return None
        node = int(self._generator.integers(tree.nodes.size[0]))
        x = tree.nodes.x[node]
        found = self._connection.connect(x.tolist(), self._problem.goal_excess(x))
        self.statistics = self._connection.statistics
        self._propagations = self._connection.propagations
        if not found:
            return None
        return np.concatenate([controls_to(tree.nodes, node), self._connection.inputs])

    def close(self) -> None:
        """Nothing is left unfinished."""
