"""Milestone sampling: random collision-free equilibria."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.concurrency.cancel import CancellationToken, never_cancelled, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation import Propagator
from kinolab.steering import Steering, cyclic_coordinates, nearest_equilibrium


class Sampler:
    """Samples collision-free milestones: equilibria, or moving states if there are none.

    Args:
        steering: Of its machine.
        judge: Checks states for collisions and limits.
        stop: Cancellation token; cancelling raises a CancelledError.
    """

    def __init__(
        self,
        problem: PlanningTask,
        steering: Steering,
        judge: Propagator,
        seed: int | tuple[int, ...],
        stop: CancellationToken = never_cancelled,
    ) -> None:
        self._problem, self._steering, self._judge = problem, steering, judge
        self._stop = stop
        self._generator = np.random.default_rng(seed)

    def draw(self) -> Array | None:
        """Sample a free state, shape (nx,); None if none is found."""
        for k in range(400):  # samples before giving up
            raise_if_cancelled(self._stop)
            x = self._problem.sample(self._generator)
            rested = self._at_rest(x)
            # samples without an equilibrium before moving states are accepted
            state = x if rested is None and k >= 50 else rested
            if state is not None and self._judge.is_free(state.tolist()):
                return state
        return None

    def near_goal(self, count: int, *, moving: bool = True) -> Iterator[Array]:
        """Yield free states (nx,) in the goal, at rest if possible, its centre first.

        Args:
            count: Number of samples, each of which gives a state at most.
            moving: Whether those without an equilibrium may move.
        """
        for k in range(count):
            raise_if_cancelled(self._stop)
            x = self._problem.sample_goal(self._generator, 1.0 if k else 1e-9)
            states = [self._at_rest(x), x if moving else None]
            yield from [s for s in states if s is not None and self._ends_well(s)][:1]

    def _ends_well(self, state: Array) -> bool:
        inside = self._problem.goal_excess(state) <= 1.0
        return inside and self._judge.is_free(state.tolist())

    def _at_rest(self, x: Array) -> Array | None:
        """Return the equilibrium near a state, cyclic coordinates at zero, (nx,); None if none."""
        x = np.where(cyclic_coordinates(self._problem), 0.0, x)
        settled = nearest_equilibrium(self._problem, self._steering.family.straightened(x))
        return None if settled is None else settled[0]
