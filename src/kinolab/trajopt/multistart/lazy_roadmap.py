"""Short geometric paths round obstacles, from a lazy roadmap.

The roadmap joins random free configurations to their nearest ones, as many as PRM* asks for. Edges
are checked only where a shortest path would take them.

Sources: Bohlin, Kavraki, Path planning using lazy PRM, ICRA 2000; Karaman, Frazzoli, Sampling-based
algorithms for optimal motion planning, IJRR 30(7), 2011 (the number of neighbours).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from kinolab.concurrency.cancel import CancellationToken, never_cancelled, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.multistart.geometric_path import GeometricPaths
from kinolab.trajopt.multistart.guesses import Guesses
from kinolab.trajopt.nlp.options import GUESS

GRAPH_SECONDS = 2e-7  # [s] of work for an edge in a search for a shortest path


def least_duration(
    problem: PlanningTask, motion: Trajectory, stop: CancellationToken = never_cancelled
) -> float:
    """Return about how long a motion takes at least when shortcuts are taken, in [s].

    Its path is pulled tight by random shortcuts, and gone along at the largest rates.

    Raises:
        CancelledError: If that is cancelled.
    """
    generator = np.random.default_rng(0)
    guesses, paths = Guesses(problem, generator), GeometricPaths(problem, generator, stop)
    count = min(len(motion.x), GUESS.tight_samples)
    path = motion.x[np.linspace(0, len(motion.x) - 1, count).astype(int)]
    for _ in range(GUESS.tight_rounds):
        path = paths.shorter(problem.space.continuous(path))
    return guesses.quickest(path)


def free_states(
    paths: GeometricPaths, ends: Array, turning: float, most: int, stop: CancellationToken
) -> Array:
    """Return the ends of a path, shape (2, nx), and random free states, ``most`` of them at most.

    Args:
        paths: What is free.
        ends: First and last state, near whose attitudes the others are.
        turning: As for ``GeometricPaths.find``.
        most: Number of random states.
        stop: Cancellation token; cancelling raises a CancelledError.
    """
    free: list[Array] = []
    for _ in range(most):
        raise_if_cancelled(stop)
        drawn = paths.anywhere(ends[0], ends[1], turning, GUESS.roadmap_draws)
        free += [x for x in drawn if paths.are_free(x[None])]
        if len(free) >= most:
            break
    return np.vstack([ends, *free[:most]])


class LazyRoadmap:
    """A roadmap from the first of some states to the second.

    Args:
        x: States, shape (n, nx).
        times: Returns the least times in [s] from one state, shape (nx,), to all, shape (n,).
        is_free: Says whether the way from one state to another is free.
        neighbours: Of each state.
        stop: Cancellation token; cancelling raises a CancelledError.
        directed: Whether a way back is another way.
    """

    def __init__(
        self,
        x: Array,
        times: Callable[[Array], Array],
        is_free: Callable[[Array, Array], bool],
        neighbours: int,
        stop: CancellationToken,
        *,
        directed: bool = False,
    ) -> None:
        self._x, self._way_is_free, self._stop, self._directed = x, is_free, stop, directed
        self._edges, self._costs = self._nearest(times, neighbours)
        self._free: dict[tuple[int, int], bool] = {}

    def path(self) -> Array | None:
        """Return the states of the shortest free path, shape (m, nx); None without one.

        Raises:
            CancelledError: If the search is cancelled.
        """
        nodes = self._shortest()
        return None if nodes is None else self._x[nodes]

    def _nearest(
        self, times: Callable[[Array], Array], count: int
    ) -> tuple[NDArray[np.intp], Array]:
        """Return pairs of states, shape (m, 2), that are near each other, and least times, (m,)."""
        apart = np.array([times(x) for x in self._x])
        pairs = _pairs(apart, count)
        if self._directed:  # the nearest ones that lead there, too
            pairs = np.vstack([pairs, _pairs(apart.T, count)[:, ::-1]])
        else:
            pairs = np.sort(pairs, axis=1)
        pairs = np.unique(pairs, axis=0)
        charge(GRAPH_SECONDS * apart.size)
        return pairs, apart[pairs[:, 0], pairs[:, 1]]

    def _shortest(self) -> list[int] | None:
        """Return the nodes of the shortest path whose edges are free; None if there is none."""
        while True:
            raise_if_cancelled(self._stop)
            charge(GRAPH_SECONDS * len(self._edges))
            graph = csr_array((self._costs, self._edges.T), shape=(len(self._x),) * 2)
            _, before = dijkstra(
                graph, directed=self._directed, indices=0, return_predecessors=True
            )
            nodes = [1]
            while nodes[-1] > 0:
                nodes.append(int(before[nodes[-1]]))
            if nodes[-1] < 0:
                return None
            nodes.reverse()
            blocked = [e for e in map(self._edge, pairwise(nodes)) if not self._is_free(e)]
            if not blocked:
                return nodes
            gone = np.array(blocked) @ (len(self._x), 1)
            left = np.isin(self._edges @ (len(self._x), 1), gone, invert=True)
            self._edges, self._costs = self._edges[left], self._costs[left]

    def _edge(self, way: tuple[int, int]) -> tuple[int, int]:
        return way if self._directed else (min(way), max(way))

    def _is_free(self, edge: tuple[int, int]) -> bool:
        if edge not in self._free:
            self._free[edge] = self._way_is_free(*self._x[[*edge]])
        return self._free[edge]


def straight_roadmap(
    problem: PlanningTask,
    paths: GeometricPaths,
    times: Callable[[Array], Array],
    ends: Array,
    stop: CancellationToken,
) -> LazyRoadmap:
    """Return a roadmap of straight lines between two states.

    Args:
        paths: What is free.
        times: Returns the least times in [s] for legs of paths, shape (..., m, nx), (..., m - 1).
        ends: First and last state, shape (2, nx).
        stop: Cancellation token; cancelling raises a CancelledError.
    """
    space = problem.space
    x = free_states(paths, ends, GUESS.turning[1], GUESS.roadmap_states, stop)

    def times_from(begin: Array) -> Array:
        near = space.nearest(begin, x)
        legs = np.stack([np.broadcast_to(begin, near.shape), near], axis=1)
        return np.asarray(times(legs)[:, 0])

    def is_free(begin: Array, end: Array) -> bool:
        return paths.is_free(begin, space.nearest(begin, end))

    return LazyRoadmap(x, times_from, is_free, prm_star_neighbours(len(x), problem.model.nq), stop)


def prm_star_neighbours(count: int, dimension: int) -> int:
    """Return how many neighbours each of ``count`` states has in PRM*: e (1 + 1/d) log n."""
    return math.ceil(math.e * (1 + 1 / dimension) * math.log(count))


def _pairs(apart: Array, count: int) -> NDArray[np.intp]:
    """Return each row and its nearest columns, by distances (n, n), shape (n * count, 2)."""
    near = np.argsort(apart, axis=1, kind="stable")[:, 1 : count + 1]
    return np.stack([np.repeat(np.arange(len(near)), near.shape[1]), near.ravel()], axis=1)
