"""How slim must the machine be to fit? Counted in quanta per side."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinolab.analyze.diagnose.narrow_passage.free_space import FreeSpace
from kinolab.numerics.arrays import Array
from kinolab.problem import Problem

SHRINKAGE_QUANTUM = 2.5e-4  # [m] per side
HORIZON = 0.1  # [m] around the machine within which nothing needs to be looked at again


class RequiredShrinkage:
    """Machines of every slimness, made as they are asked for.

    Args:
        problem: The machine and the world.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem, self._checker = problem, problem.checker()
        self._shapes: dict[int, FreeSpace] = {}
        self._inflated = FreeSpace(problem, self._checker.inflated(HORIZON, ground=False))

    def shape(self, slim: int) -> FreeSpace:
        """Return the machine that is so many quanta slimmer on every side."""
        if slim not in self._shapes:
            checker = self._checker.slimmer(slim * SHRINKAGE_QUANTUM) if slim > 0 else self._checker
            self._shapes[slim] = FreeSpace(self._problem, checker)
        return self._shapes[slim]

    def clearance(self, path: Array) -> Array:
        """Return how far the machine may move at each state, shape (n,): ``HORIZON`` or 0.

        The ground does not count.
        """
        return np.where([self._inflated.collides(x) for x in path.tolist()], 0.0, HORIZON)

    def fits(self, x: Array, slim: int) -> bool:
        """Say whether a machine that is so many quanta slimmer is free at a state."""
        return self.shape(slim).free(x.tolist())

    def blocked(self, path: Array, slim: int) -> NDArray[np.bool_]:
        """Say at which states of a way, shape (n, nx), the machine is not free."""
        shape = self.shape(slim)
        return np.array([not shape.free(x) for x in path.tolist()], dtype=bool)

    def least(self, path: Array, most: int) -> int:
        """Return how slim the machine must be to fit everywhere, where ``most`` is enough."""
        fat, slim = -1, most
        suspects = path
        while slim - fat > 1:
            middle = (fat + slim) // 2
            blocked = self.blocked(suspects, middle)
            if blocked.any():
                fat, suspects = middle, suspects[blocked]  # the others fit slimmer ones as well
            else:
                slim = middle
        return slim
