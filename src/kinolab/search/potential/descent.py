"""Descent of the potential under the full dynamics, to the goal, a minimum or the budget's end."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, auto

import numpy as np

from kinolab.concurrency.cancel import CancelledError, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.search.budget import Budget
from kinolab.search.potential.field import Field
from kinolab.search.potential.lookahead import Lookahead
from kinolab.simulation import Propagator
from kinolab.steering import GoalConnection


@dataclass(eq=False)
class PartialMotion:
    """A motion from the start that is extended step by step.

    Attributes:
        states: Each of shape (nx,); the first is the start.
        inputs: Each of shape (nu,); one fewer than the states.
    """

    states: list[Array]
    inputs: list[Array] = field(default_factory=list)

    @property
    def end(self) -> Array:
        """The final state, shape (nx,)."""
        return self.states[-1]

    def rows(self, nu: int) -> Array:
        """Return the inputs, shape (N, nu)."""
        return np.array(self.inputs, dtype=float).reshape(-1, nu)

    def until(self, count: int) -> PartialMotion:
        """Return its first ``count`` steps."""
        return PartialMotion(self.states[: count + 1], self.inputs[:count])

    def add(self, u: Array, x: Array) -> None:
        """Append a step: inputs (nu,) and the state (nx,) that they lead to."""
        self.inputs.append(u)
        self.states.append(x)


class Ending(Enum):
    """Why a descent ended."""

    GOAL = auto()
    MINIMUM = auto()
    BUDGET = auto()


class Descent:
    """Descends the field.

    Args:
        arrival: Goal connection.
        propagator: Propagates and checks every step.
        near: Potential in [m] below which goal connections are attempted.
        patience: Steps without progress that count as a local minimum.
    """

    def __init__(
        self,
        field: Field,
        lookahead: Lookahead,
        arrival: GoalConnection,
        propagator: Propagator,
        near: float,
        patience: int,
    ) -> None:
        self._field, self._lookahead, self._arrival = field, lookahead, arrival
        self._propagator, self._near, self._patience = propagator, near, patience
        self._problem = field.problem

    def follow(
        self, trail: PartialMotion, generator: np.random.Generator, budget: Budget
    ) -> Ending:
        """Extend a motion from its end until the descent ends."""
        u = self._problem.model.null_control()
        lowest, waited, count = self._height(trail.end), 0, 0
        while self._problem.goal_excess(trail.end) > 1.0:
            if budget.spent():
                return Ending.BUDGET
            height = self._height(trail.end)
            if height < lowest - 0.01:  # [m] decrease of the potential that counts as progress
                lowest, waited = height, 0
            # steps between attempts at a goal connection
            if height < self._near and count % 4 == 0:
                motion = self._arrival.inputs(trail.end)
                for arriving, x in motion or ():
                    trail.add(arriving, x)
                if motion is not None:
                    return Ending.GOAL
            count, waited = count + 1, waited + 1
            try:
                chosen = self._choose(trail.end, u, generator, budget)
            except CancelledError:
                budget.take_back()
                return Ending.BUDGET
            if chosen is None or waited > self._patience:
                return Ending.MINIMUM
            u, reached = chosen
            trail.add(u, reached)
        return Ending.GOAL

    def _height(self, x: Array) -> float:
        return float(self._field.potential(x[None])[0])

    def _choose(
        self, x: Array, u: Array, generator: np.random.Generator, budget: Budget
    ) -> tuple[Array, Array] | None:
        """Return inputs (nu,) and the state (nx,) after one step of them.

        Takes the best proposal that is free up to the horizon, else the one that is free longest;
        None if no first step is free.

        Raises:
            CancelledError: If time ran out before all were checked.
        """
        longest, best = 0, None
        for proposal in self._lookahead.proposals(x, u, generator):
            raise_if_cancelled(budget.expired)
            free, first = self._free_steps(x, proposal)
            if free > longest and first is not None:
                longest, best = free, (proposal, first)
            if free == self._lookahead.steps:
                break
        return best

    def _free_steps(self, x: Array, u: Array) -> tuple[int, Array | None]:
        """Return the number of free steps, and the state (nx,) after the first."""
        first, held = None, u.tolist()
        for k in range(self._lookahead.steps):
            reached, free = self._propagator.step(x.tolist(), held, self._problem.step)
            if not free:
                return k, first
            x = np.array(reached)
            first = x if first is None else first
        return self._lookahead.steps, first
