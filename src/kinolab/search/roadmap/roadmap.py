"""The roadmap graph: milestones, and motions between them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import scipy
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.search.graph import SearchGraph


@dataclass
class Roadmap:
    """A directed graph of states, with inputs as edges.

    Attributes:
        milestones: States, each of shape (nx,).
        motions: Inputs of shape (steps, nu), one row per propagation step, by pairs of milestones.
    """

    milestones: list[Array] = field(default_factory=list)
    motions: dict[tuple[int, int], Array] = field(default_factory=dict)

    def add(self, state: Array) -> int:
        """Add a milestone and return its index."""
        self.milestones.append(state)
        return len(self.milestones) - 1

    def connect(self, begin: int, end: int, inputs: Array) -> None:
        """Add a motion between two milestones, inputs (steps, nu); the faster of two is kept."""
        known = self.motions.get((begin, end))
        if known is None or len(inputs) < len(known):
            self.motions[begin, end] = inputs

    def graph(self, nx: int) -> SearchGraph:
        """Return the search graph, states of nx entries each."""
        edges = np.array(list(self.motions), dtype=np.int32).reshape(-1, 2)
        return SearchGraph(np.array(self.milestones).reshape(-1, nx), edges)

    def copy(self) -> Roadmap:
        """Return a roadmap to which milestones can be added without changing this one."""
        return Roadmap(list(self.milestones), dict(self.motions))

    def groups(self) -> NDArray[np.int32]:
        """Return the strongly connected component of each milestone, shape (n,)."""
        _, labels = scipy.sparse.csgraph.connected_components(
            self._steps(), directed=True, connection="strong"
        )
        return np.asarray(labels)

    def quickest(self, begin: int, end: int) -> Array | None:
        """Return the inputs of the fastest path, shape (steps, nu); None if there is none."""
        lengths, before = scipy.sparse.csgraph.dijkstra(
            self._steps(), indices=begin, return_predecessors=True
        )
        if not np.isfinite(lengths[end]):
            return None
        path = [end]
        while path[-1] != begin:
            path.append(int(before[path[-1]]))
        pairs = zip(path[:0:-1], path[-2::-1], strict=True)
        return np.vstack([self.motions[pair] for pair in pairs])

    def reached(self, begin: int) -> list[int]:
        """Return the milestones reachable from one, itself included."""
        lengths = scipy.sparse.csgraph.dijkstra(self._steps(), indices=begin)
        return [int(k) for k in np.flatnonzero(np.isfinite(lengths))]

    def _steps(self) -> scipy.sparse.csr_array:
        size = len(self.milestones)
        rows = np.array(list(self.motions), dtype=np.int64).reshape(-1, 2)
        steps = np.array([len(inputs) for inputs in self.motions.values()], dtype=float)
        return scipy.sparse.csr_array((steps, (rows[:, 0], rows[:, 1])), shape=(size, size))
