"""How a search goes on after its first motion into the goal, for shorter ones."""

from __future__ import annotations

import math

from kinolab.numerics.arrays import Array
from kinolab.search.budget import Budget
from kinolab.search.tree.tree_extension import UNBOUNDED_STEPS, AbstractTreeExtension


class IncumbentImprovement:
    """The shortest motion so far, and how long the search for shorter ones goes on.

    Args:
        budget: Of the search.
        seconds: For which it goes on after its first motion.
        step: Of the motions' knots in [s].

    Attributes:
        u: Inputs of the shortest motion into the goal (N, nu); None before there is one.
        statistics: The duration of the first motion in [s], and how many were shorter.
    """

    def __init__(self, budget: Budget, seconds: float, step: float) -> None:
        self._clock, self._seconds, self._step = budget.clock, seconds, step
        self._until, self._pointless = math.inf, False
        self.u: Array | None = None
        self.statistics: dict[str, float] = {}

    @property
    def over(self) -> bool:
        """Whether the search has come to its end."""
        return self._pointless or self._clock() >= self._until

    def wants(self, u: Array) -> bool:
        """Say whether a motion is shorter than all before."""
        return len(u) < (UNBOUNDED_STEPS if self.u is None else len(self.u))

    def found(self, u: Array, tree: AbstractTreeExtension) -> None:
        """Take a shorter motion, and have a tree look for shorter ones."""
        if self.u is None:
            self.statistics = {"first_duration": len(u) * self._step, "improvements": 0.0}
            self._until = self._clock() + self._seconds
        else:
            self.statistics["improvements"] += 1.0
        self.u = u
        self._pointless = self.over or not tree.shorten(len(u))
