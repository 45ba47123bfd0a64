"""A probabilistic roadmap over the configurations of a machine at rest.

Source: Kavraki, Svestka, Latombe, Overmars, IEEE Trans. Robotics and Automation 12(4), 1996.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from kinolab.numerics.arrays import Array
from kinolab.search.budget import Budget
from kinolab.search.roadmap.configuration_space import ConfigurationSpace

BEGIN, GOAL = 0, 1  # indices of the first two configurations


class GeometricRoadmap:
    """A roadmap between a start and a goal, undirected.

    Args:
        configurations: The configuration space.
        start: Start state, shape (nx,).
        goal: Goal state, shape (nx,).
        neighbours: Maximum number of neighbours that a configuration is connected to.

    Raises:
        CancelledError: If the search is cancelled, from all its methods, too.
    """

    def __init__(
        self,
        configurations: ConfigurationSpace,
        start: Array,
        goal: Array,
        seed: int,
        neighbours: int,
    ) -> None:
        self._configurations, self._neighbours = configurations, neighbours
        self._random = np.random.default_rng(seed)
        self._x: list[Array] = []
        self._lengths: dict[tuple[int, int], float] = {}
        for end in (start, goal):
            x = configurations.equilibrium(end)
            self._add(end if x is None else x)

    @property
    def size(self) -> int:
        """Number of configurations in the roadmap."""
        return len(self._x)

    def grow(self, count: int, budget: Budget) -> None:
        """Add ``count`` configurations, or fewer if the budget runs out."""
        end = self.size + count
        while self.size < end and not budget.spent():
            x = self._configurations.draw(self._random)
            if x is not None and self._configurations.has_clearance(x):
                self._add(x)

    def path(self) -> list[Array] | None:
        """Return the shortest path from start to goal, states (nx,) at rest; None without one."""
        return self._path_to(lambda apart: GOAL if np.isfinite(apart[GOAL]) else None)

    def approach(self, distance: Callable[[Array], float]) -> list[Array]:
        """Return the path to the reachable configuration nearest to the goal, states (nx,) at rest.

        Args:
            distance: Distance of a state from the goal.
        """

        def nearest(apart: Array) -> int:
            reached = np.flatnonzero(np.isfinite(apart)).tolist()
            return min(reached, key=lambda k: distance(self._x[k]))

        return self._path_to(nearest) or []

    def _add(self, x: Array) -> None:
        """Add a configuration, joined to its nearest ones where the way is free."""
        if self._x:
            apart, number = self._configurations.distances(x, np.array(self._x)), self.size
            for k in np.argsort(apart, kind="stable")[: self._neighbours].tolist():
                if self._configurations.joined(self._x[k], x):
                    # SciPy treats length zero as no edge
                    self._lengths[k, number] = max(float(apart[k]), 1e-12)
        self._x.append(x)

    def _path_to(self, chosen: Callable[[Array], int | None]) -> list[Array] | None:
        """Return the shortest path to what is chosen by the lengths of shortest paths (n,)."""
        rows = np.array(list(self._lengths), dtype=np.int64).reshape(-1, 2)
        table = scipy.sparse.csr_array((list(self._lengths.values()), rows.T), (self.size,) * 2)
        apart, before = scipy.sparse.csgraph.dijkstra(
            table, directed=False, indices=BEGIN, return_predecessors=True
        )
        end = chosen(apart)
        if end is None:
            return None
        path = [end]
        while path[-1] != BEGIN:
            path.append(int(before[path[-1]]))
        return [self._x[k] for k in reversed(path)]
