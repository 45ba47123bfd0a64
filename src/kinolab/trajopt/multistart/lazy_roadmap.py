"""Short geometric paths round obstacles, from a lazy roadmap.

The roadmap joins random free configurations to their nearest ones, as many as PRM* asks for. Edges
are checked only where a shortest path would take them.

Sources: Bohlin, Kavraki, Path planning using lazy PRM, ICRA 2000; Karaman, Frazzoli, Sampling-based
algorithms for optimal motion planning, IJRR 30(7), 2011 (the number of neighbours).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from kinolab.concurrency.cancel import CancellationToken, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.multistart.geometric_path import GeometricPaths
from kinolab.trajopt.multistart.guesses import Guesses
from kinolab.trajopt.options import GUESS

GRAPH_SECONDS = 2e-7  # [s] of work for an edge in a search for a shortest path


def least_durations(problem: PlanningTask, motions: Sequence[Trajectory]) -> list[float]:
    """Return about how long motions take at least when shortcuts are taken, in [s].

    Paths are pulled tight by random shortcuts, and gone along at the largest rates.
    """
    generator = np.random.default_rng(0)
    guesses, paths = Guesses(problem, generator), GeometricPaths(problem, generator)
    least = []
    for motion in motions:
        count = min(len(motion.x), GUESS.tight_samples)
        path = motion.x[np.linspace(0, len(motion.x) - 1, count).astype(int)]
        for _ in range(GUESS.tight_rounds):
            path = paths.shorter(problem.space.continuous(path))
        least.append(guesses.quickest(path))
    return least


class LazyRoadmap:
    """A roadmap between two states.

    Args:
        problem: The planning problem.
        paths: What is free, and shortens paths.
        times: Returns the least times in [s] for legs of paths, shape (..., m, nx), (..., m - 1).
        ends: First and last state, shape (2, nx).
        stop: Cancellation token; cancelling raises a CancelledError.
    """

    def __init__(
        self,
        problem: PlanningTask,
        paths: GeometricPaths,
        times: Callable[[Array], Array],
        ends: Array,
        stop: CancellationToken,
    ) -> None:
        self._space, self._paths, self._times, self._stop = problem.space, paths, times, stop
        self._x = np.vstack([ends, *self._drawn(ends)])
        # Neighbours, as PRM* has them: e (1 + 1/d) log n.
        count = math.ceil(math.e * (1 + 1 / problem.model.nq) * math.log(len(self._x)))
        self._edges, self._costs = self._nearest(count)
        self._free: dict[tuple[int, int], bool] = {}

    def path(self) -> Array | None:
        """Return the shortest free path, with random shortcuts, shape (m, nx); None without one.

        Raises:
            CancelledError: If the search is cancelled.
        """
        nodes = self._shortest()
        if nodes is None:
            return None
        return self._paths.shorter(self._space.continuous(self._x[nodes]))

    def _drawn(self, ends: Array) -> list[Array]:
        """Return random free states near the ends' attitudes, (nx,) each."""
        free: list[Array] = []
        for _ in range(GUESS.roadmap_states):
            raise_if_cancelled(self._stop)
            drawn = self._paths.anywhere(ends[0], ends[1], GUESS.turning[1], GUESS.roadmap_draws)
            free += [x for x in drawn if self._paths.are_free(x[None])]
            if len(free) >= GUESS.roadmap_states:
                break
        return free[: GUESS.roadmap_states]

    def _nearest(self, count: int) -> tuple[NDArray[np.intp], Array]:
        """Return pairs of states, shape (m, 2), that are near each other, and least times, (m,)."""
        times = np.array([self._times_from(x) for x in self._x])
        near = np.argsort(times, axis=1, kind="stable")[:, 1 : count + 1]
        pairs = np.stack([np.repeat(np.arange(len(near)), near.shape[1]), near.ravel()], axis=1)
        pairs = np.unique(np.sort(pairs, axis=1), axis=0)
        charge(GRAPH_SECONDS * times.size)
        return pairs, times[pairs[:, 0], pairs[:, 1]]

    def _times_from(self, x: Array) -> Array:
        """Return the least times in [s] from one state, shape (nx,), to all."""
        near = self._space.nearest(x, self._x)
        times = self._times(np.stack([np.broadcast_to(x, near.shape), near], axis=1))
        return np.asarray(times[:, 0])

    def _shortest(self) -> list[int] | None:
        """Return the nodes of the shortest path whose edges are free; None if there is none."""
        while True:
            raise_if_cancelled(self._stop)
            charge(GRAPH_SECONDS * len(self._edges))
            graph = csr_array((self._costs, self._edges.T), shape=(len(self._x),) * 2)
            _, before = dijkstra(graph, directed=False, indices=0, return_predecessors=True)
            nodes = [1]
            while nodes[-1] > 0:
                nodes.append(int(before[nodes[-1]]))
            if nodes[-1] < 0:
                return None
            blocked = [e for e in pairwise(nodes) if not self._is_free(e)]
            if not blocked:
                return nodes[::-1]
            gone = np.sort(blocked) @ (len(self._x), 1)
            left = np.isin(self._edges @ (len(self._x), 1), gone, invert=True)
            self._edges, self._costs = self._edges[left], self._costs[left]

    def _is_free(self, edge: tuple[int, int]) -> bool:
        pair = min(edge), max(edge)
        if pair not in self._free:
            begin, end = self._x[[*pair]]
            self._free[pair] = self._paths.is_free(begin, self._space.nearest(begin, end))
        return self._free[pair]
