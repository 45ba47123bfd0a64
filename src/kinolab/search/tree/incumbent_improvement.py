"""How long a tree's solution is improved, and by how much another one must be better."""

from __future__ import annotations

import math
from collections.abc import Callable

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goals_reached import SAME_TIME
from kinolab.problem.time_steps import covering_steps
from kinolab.search.budget import Budget
from kinolab.search.tree.tree import COST_UNIT
from kinolab.search.tree.tree_extension import UNBOUNDED_STEPS, AbstractTreeExtension
from kinolab.simulation.reference import cost_of_inputs


class IncumbentImprovement:
    """The incumbent solution and the time limit of its improvement.

    Args:
        tree: Is bounded from its beginning where a motion is known already.
        seconds: Time to continue after the first solution, in [s].
        step: Time step of the motions in [s].
        cost: Returns what inputs (N, nu) cost; the number of steps when left out.

    Attributes:
        longest: Duration in [s] that none may exceed.
        u: Inputs of the shortest solution (N, nu); None before there is one.
        statistics: Duration of the first solution in [s], and the number of improvements.
    """

    def __init__(
        self,
        tree: AbstractTreeExtension,
        budget: Budget,
        seconds: float,
        step: float,
        cost: Callable[[Array], int] = len,
    ) -> None:
        self._tree, self._cost = tree, cost
        self._clock, self._seconds, self._step = budget.clock, seconds, step
        self._until, self._pointless = math.inf, False
        self._most, self._gained, self._patience = UNBOUNDED_STEPS, math.inf, budget.patience
        # A duration says nothing of what else a motion costs.
        if math.isfinite(budget.below) and seconds > 0 and cost is len:
            self._most = covering_steps(budget.below, step)
            self._gained = self._clock()
            tree.shorten(self._most)
        self.longest = math.inf
        self.u: Array | None = None
        self.statistics: dict[str, float] = {}

    @property
    def over(self) -> bool:
        """Whether the search must end."""
        now = self._clock()
        return self._pointless or now >= self._until or now - self._gained >= self._patience

    def wants(self, u: Array) -> bool:
        """Say whether inputs (N, nu) are shorter, or cost less, than the incumbent."""
        return len(u) * self._step <= self.longest + SAME_TIME and self._cost(u) < self._most

    def found(self, u: Array) -> None:
        """Accept inputs (N, nu) as the incumbent, and bound the tree by their length."""
        if self.u is None:
            self.statistics = {"first_duration": len(u) * self._step, "improvements": 0.0}
            self._until = self._clock() + self._seconds
        else:
            self.statistics["improvements"] += 1.0
        self.u, self._most, self._gained = u, self._cost(u), self._clock()
        self._pointless = self.over or not self._tree.shorten(self._most)


def trees_cost(problem: PlanningTask, u: Array) -> int:
    """Return what inputs (N, nu) cost by [objective], as trees count it."""
    return int(min(cost_of_inputs(problem, u) / COST_UNIT, UNBOUNDED_STEPS - 1.0))
