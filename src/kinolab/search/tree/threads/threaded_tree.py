"""A tree that several threads grow together."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from kinolab.concurrency.processors import processors
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.search.tree.sampled.sampled_growth import SPARSE, Growth
from kinolab.search.tree.sampled.sampled_tree import AbstractSampledPlanner, SampledTree
from kinolab.search.tree.search_state import SearchState
from kinolab.search.tree.threads.parallel_growth import abandon, grow_in_rounds, help_growing
from kinolab.search.tree.threads.workers import BOARD_SIZE, MOST_ENDS, OVER, Workers, another
from kinolab.search.tree.tree_extension import AbstractTreeExtension
from kinolab.settings import setting


class ThreadedTree(SampledTree):
    """A tree of RRT, or a sparse one of SST, that several threads grow together.

    It depends on their number, not on the processors: there are as many workers on one alone.

    Args:
        growth: How it grows.
        threads: Their number; no more are started than there are processors.
    """

    def __init__(self, search: SearchState, growth: Growth, max_nodes: int, threads: int) -> None:
        super().__init__(search, growth, max_nodes, MOST_ENDS)
        others = range(1, 2 * threads)  # one with a long part, and one with a short one
        self._records = [self._first, *(another(self._first, k) for k in others)]
        addresses = np.array([record.address for record in self._records], np.int64)
        self._board = np.zeros(BOARD_SIZE, np.int64)
        self._workers = Record(Workers(addresses, self._board))
        self._helping: list[Future[None] | None] = [None] * (min(threads, processors()) - 1)
        self._pool = ThreadPoolExecutor(max(len(self._helping), 1))

    def begin(self) -> None:
        """Clear the tree to its start."""
        super().begin()
        abandon(self._first, self._workers)

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations, or a few more: rounds are not cut."""
        if not iterations:  # compile only
            self._board[OVER] = 1
            help_growing(self._first, self._workers)
            self._board[OVER] = 0
        with suppress(RuntimeError):  # where the system has no thread left, the others do it all
            for k, helping in enumerate(self._helping):
                if iterations and (helping is None or helping.done()):
                    self._helping[k] = self._pool.submit(help_growing, self._first, self._workers)
        ended, made = grow_in_rounds(self._first, self._workers, iterations)
        for record in self._records[1:]:
            counts = record.held.tree.rejections
            self.nodes.rejections[:] += counts
            counts[:] = 0
        return int(ended), int(made)

    def shorten(self, steps: int) -> bool:
        """Prune nodes of a sparse tree that cannot lead to shorter motions."""
        possible = super().shorten(steps)
        if self._growth.kind == SPARSE:
            abandon(self._first, self._workers)  # its nodes have other numbers now
        return possible

    def close(self) -> None:
        """End the threads."""
        self._board[OVER] = 1
        self._pool.shutdown()


@dataclass(frozen=True, kw_only=True)
class AbstractThreadedPlanner(AbstractSampledPlanner):
    """A planner whose tree grows toward samples, in several threads where one wants."""

    threads: int = setting(
        1,
        1,
        64,
        unit="threads",
        meaning="Threads that grow the tree; plans depend on their number, not on the computer.",
    )

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:
        """Return the tree extension."""
        if self.threads == 1:
            return super().extension(problem, search)
        return ThreadedTree(search, self.growth(), self.max_nodes, self.threads)
