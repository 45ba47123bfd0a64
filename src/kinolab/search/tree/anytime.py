"""Anytime search: improvement of the incumbent after the first solution."""

from __future__ import annotations

import math

from kinolab.numerics.arrays import Array
from kinolab.problem.time_steps import covering_steps
from kinolab.search.budget import Budget
from kinolab.search.tree.tree_extension import UNBOUNDED_STEPS, AbstractTreeExtension


class IncumbentImprovement:
    """The incumbent solution and the time limit of its improvement.

    Args:
        budget: Of the search.
        seconds: Time to continue after the first solution, in [s].
        step: Time step of the motions in [s].

    Attributes:
        u: Inputs of the shortest solution (N, nu); None before there is one.
        statistics: Duration of the first solution in [s], and the number of improvements.
    """

    def __init__(self, budget: Budget, seconds: float, step: float) -> None:
        self._clock, self._seconds, self._step = budget.clock, seconds, step
        self._until, self._pointless = math.inf, False
        self._most, self._gained, self._patience = UNBOUNDED_STEPS, math.inf, budget.patience
        if math.isfinite(budget.below) and seconds > 0:
            self._most = covering_steps(budget.below, step)
            self._gained = self._clock()
        self.u: Array | None = None
        self.statistics: dict[str, float] = {}

    @property
    def over(self) -> bool:
        """Whether the search must end."""
        now = self._clock()
        return self._pointless or now >= self._until or now - self._gained >= self._patience

    def bound(self, tree: AbstractTreeExtension) -> None:
        """Bound a tree from its beginning where a motion is known already."""
        if self._most < UNBOUNDED_STEPS:
            tree.shorten(self._most)

    def wants(self, u: Array) -> bool:
        """Say whether inputs (N, nu) are shorter than the incumbent."""
        return len(u) < self._most

    def found(self, u: Array, tree: AbstractTreeExtension) -> None:
        """Accept inputs (N, nu) as the incumbent, and bound the tree by their length."""
        if self.u is None:
            self.statistics = {"first_duration": len(u) * self._step, "improvements": 0.0}
            self._until = self._clock() + self._seconds
        else:
            self.statistics["improvements"] += 1.0
        self.u, self._most, self._gained = u, len(u), self._clock()
        self._pointless = self.over or not tree.shorten(len(u))
