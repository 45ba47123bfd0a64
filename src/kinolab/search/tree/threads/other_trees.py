"""Other trees, grown in a thread beside those of a search.

How long trees take differs so much from seed to seed that the first of two takes far less than half
of what both do.

Source: Carpin, Pagello, On parallel RRTs for multi-robot systems, 8th Conference of the Italian
Association for Artificial Intelligence, 2002.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from typing import ClassVar

from kinolab.concurrency.submitting import submitted
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.search.tree.growth_work import growth_seconds, step_seconds
from kinolab.search.tree.time_slices import RestartRounds
from kinolab.search.tree.tree import FULL, GROWING, REACHED, controls_to
from kinolab.search.tree.tree_extension import AbstractTreeExtension

WORK_BEFORE = 0.1  # [s] of a search, before which other trees take longer to begin than they save
WORK_PER_TURN = 0.02  # [s] of work until both wait for each other


class OtherTrees:
    """Trees with other random numbers, for searches that would leave a second processor idle.

    Turns end by counts of work, and each waits for the other at their ends: what comes of both
    depends neither on how fast they are, nor on the number of processors.

    Args:
        trees: Makes them, when they are due.
        restart_after: Iterations of the first round, later ones being longer; 0 for a single round.

    Attributes:
        due: Iterations of the search until their next turn.
        statistics: Empty: they are not counted.
    """

    statistics: ClassVar[Mapping[str, float]] = {}

    def __init__(
        self,
        problem: PlanningTask,
        trees: Callable[[], AbstractTreeExtension],
        restart_after: int,
    ) -> None:
        self._step_seconds, self._make = step_seconds(problem), trees
        self._trees: AbstractTreeExtension | None = None
        self._pool = ThreadPoolExecutor(1)
        self._growing: Future[tuple[int, int]] | None = None
        self._round = RestartRounds(restart_after)
        self._of_search, self._own, self._charged = 0, 0, 0.0  # iterations; work in [s]
        self._turn = 1.0  # iterations
        self.due: float = 1.0

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:
        """End a turn and begin the next, if due; return inputs (N, nu) into the goal, or None."""
        self._of_search += iterations
        self.due -= iterations
        if self.due > 0:
            return None
        found = None if self._trees is None else self._end_turn(self._trees)
        work = self._work(tree.steps_made, self._of_search)
        fitting = _iterations_of(WORK_PER_TURN, work, self._of_search)
        if work >= WORK_BEFORE:
            if self._trees is None:
                self._trees, self._turn = self._make(), fitting  # at first as those of the search
                self._trees.begin()
            self._begin_turn(self._trees)
        self.due = fitting
        return found

    def _end_turn(self, trees: AbstractTreeExtension) -> Array | None:
        """Wait for the end of a turn; return the inputs of a motion into the goal, if any."""
        if self._growing is None:
            return None
        (ended, made), self._growing = self._growing.result(), None
        self._own += made
        self._round.left -= made
        work = self._work(trees.steps_made, self._own)
        charge(work - self._charged)
        self._charged = work
        found = None
        if ended == REACHED:
            found = controls_to(trees.nodes, int(trees.nodes.size[0]) - 1)
        elif ended == FULL or self._round.over:
            self._round.begin()
            trees.begin()
        return found

    def _begin_turn(self, trees: AbstractTreeExtension) -> None:
        if self._own > 0:  # grow slowly: the first iterations only begin what others have to do
            fitting = _iterations_of(WORK_PER_TURN, self._charged, self._own)
            self._turn = min(fitting, 2.0 * self._turn)
        due = [int(min(self._turn, self._round.left))]

        def grow(counts: list[int]) -> tuple[int, int]:  # may be asked twice, see ``submitted``
            return trees.grow(counts.pop()) if counts else (GROWING, 0)

        self._growing = submitted(self._pool, grow, due)

    def _work(self, steps: int, iterations: int) -> float:
        return growth_seconds(self._step_seconds, steps, iterations)

    def close(self) -> None:
        """Wait for the end of a turn, and give up the trees."""
        self._pool.shutdown()
        if self._trees is not None:
            self._trees.close()


def _iterations_of(share: float, work: float, iterations: int) -> float:
    """Return how many iterations take a share of work, as those so far did; 1 at least."""
    return max(1.0, math.floor(share * iterations / work)) if work > 0.0 else 1.0
