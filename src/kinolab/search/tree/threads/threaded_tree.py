"""A tree that several threads grow together."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import Any

import numpy as np

from kinolab.concurrency.processors import processors
from kinolab.numerics.struct import Record
from kinolab.search.tree.sampled.witnesses import witnesses
from kinolab.search.tree.threads.parallel_growth import (
    Growth,
    begin_apart,
    grow_in_rounds,
    help_growing,
    prune,
)
from kinolab.search.tree.threads.workers import (
    BOARD_SIZE,
    OVER,
    Worker,
    Workers,
    another,
    no_ends,
)
from kinolab.search.tree.tree import tree
from kinolab.search.tree.tree_extension import UNBOUNDED_STEPS, AbstractTreeExtension, SearchState

WORKERS_PER_THREAD = 2  # one with a long part, and one with a short one


class ThreadedTree(AbstractTreeExtension):
    """A tree of RRT, or a sparse one of SST, that several threads grow together.

    It depends on their number, not on the processors: there are as many workers on one alone.

    Args:
        search: Of the tree.
        growth: How it grows.
        max_nodes: Its capacity.
        threads: Their number; no more are started than there are processors.
    """

    def __init__(self, search: SearchState, growth: Growth, max_nodes: int, threads: int) -> None:
        arrays = search.problem
        self.nodes = tree(arrays, max_nodes, neighbours=not growth.sparse)
        self.best = np.zeros(2)
        sparse = witnesses(arrays, max_nodes if growth.sparse else 1)
        ends = no_ends(len(arrays.start), len(arrays.input_lower))
        others = range(1, WORKERS_PER_THREAD * threads)
        self._first = Record(Worker(search, self.nodes, sparse, ends))
        self._records = [self._first, *(another(self._first, k) for k in others)]
        addresses = np.array([record.address for record in self._records], np.int64)
        self._board = np.zeros(BOARD_SIZE, np.int64)
        self._most = np.full(1, UNBOUNDED_STEPS, np.int64)
        self._workers = Record(Workers(addresses, self._most, self._board))
        self._growth = Record(growth)
        self._helping: list[Future[None] | None] = [None] * (min(threads, processors()) - 1)
        self._pool = ThreadPoolExecutor(max(len(self._helping), 1))

    def begin(self) -> None:
        """Clear the tree to its start."""
        begin_apart(self._first, self._workers, self._growth)
        self.best[:] = 0.0, np.inf

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow for some iterations, or a few more: rounds are not cut."""
        arguments: tuple[Any, ...] = self._first, self._workers, self.best, self._growth
        if not iterations:  # compile only
            self._board[OVER] = 1
            help_growing(*arguments)
            self._board[OVER] = 0
        with suppress(RuntimeError):  # where the system has no thread left, the others do it all
            for k, helping in enumerate(self._helping):
                if iterations and (helping is None or helping.done()):
                    self._helping[k] = self._pool.submit(help_growing, *arguments)
        ended, made = grow_in_rounds(*arguments, iterations)
        for record in self._records[1:]:
            counts = record.held.tree.rejections
            self.nodes.rejections[:] += counts
            counts[:] = 0
        return int(ended), int(made)

    def shorten(self, steps: int) -> bool:
        """Prune nodes of a sparse tree that cannot lead to shorter motions."""
        growth = self._growth.held
        if not growth.sparse:
            return False
        self._most[0] = steps
        prune(self._first, self._workers, self.best)
        return bool(steps > growth.min_steps)

    def close(self) -> None:
        """End the threads."""
        self._board[OVER] = 1
        self._pool.shutdown()
