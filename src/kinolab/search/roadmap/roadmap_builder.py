"""Roadmap construction and queries."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from kinolab.concurrency.cancel import CancelledError, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search.budget import Budget
from kinolab.search.roadmap.milestones import Sampler
from kinolab.search.roadmap.roadmap import Roadmap
from kinolab.simulation import Propagator
from kinolab.steering import Steering


class RoadmapBuilder:
    """Grows and queries a roadmap of one machine and world.

    Args:
        problem: The planning problem; start and goal may differ in each query.
        neighbours: Number of nearest milestones that a new one is steered to.
        roadmap: Roadmap to extend.

    Attributes:
        roadmap: Milestones and motions.
    """

    def __init__(
        self, problem: PlanningTask, *, neighbours: int, seed: int, roadmap: Roadmap | None = None
    ) -> None:
        self._problem, self._neighbours = problem, neighbours
        self.roadmap = Roadmap() if roadmap is None else roadmap
        self._steering = Steering(problem, self._cancelled)
        self._judge = Propagator(problem)
        self.rejections = self._judge.rejections
        known = len(self.roadmap.milestones)  # seeds the sampler, so as not to repeat these
        self._sampler = Sampler(
            problem, self._steering, self._judge, (seed, known), self._cancelled
        )
        self._budget: Budget | None = None  # of the current operation
        self._start = problem.start  # of the last query
        self._left: dict[int, Array] = {}  # motions from that start, by milestone

    def goals(self, count: int, budget: Budget | None = None) -> list[Array]:
        """Return free states (nx,) in the problem's goal, its centre first; none if cancelled."""
        self._budget = budget
        try:
            return list(self._sampler.near_goal(count))
        except CancelledError:
            return []

    def grow(self, budget: Budget) -> int | None:
        """Add a milestone with motions to and from its neighbours.

        None if no free state is found or time runs out.
        """
        self._budget = budget
        try:
            state = self._sampler.draw()
        except CancelledError:
            return None
        if state is None:
            return None
        number = self.roadmap.add(state)
        for other in self._nearest(state, self._neighbours, apart_from=number):
            there = self._steer(self.roadmap, number, other, budget)
            if there or not self._steering.reversible:  # else one failure rules out both directions
                self._steer(self.roadmap, other, number, budget)
        return number

    def query(self, start: Array, goals: list[Array], budget: Budget) -> Array | None:
        """Return inputs from a start (nx,) to one of some goals (nx,), shape (steps, nu).

        The roadmap is not modified. None if they are not connected or the budget is spent.
        """
        asked = self.roadmap.copy()
        size = len(asked.milestones)
        begin = asked.add(start)
        left = self._joined(asked, begin, size, budget, leaving=True)
        self._keep({b: inputs for (a, b), inputs in asked.motions.items() if a == begin}, start)
        for goal in goals:
            end = asked.add(goal)
            self._steer(asked, begin, end, budget)
            if left:
                self._joined(asked, end, size, budget, leaving=False)
            inputs = asked.quickest(begin, end)
            if inputs is not None:
                return inputs
            if budget.over:
                return None
        return None

    def approach(self, start: Array, distance: Callable[[Array], float]) -> Array:
        """Return inputs from a start to the reachable milestone nearest to the goal, (steps, nu).

        No new motions are tried: those from the start are known from earlier queries.

        Args:
            start: Start state, shape (nx,).
            distance: Distance of a state from the goal.
        """
        asked = self.roadmap.copy()
        begin = asked.add(start)
        self._keep({}, start)
        for end, motion in self._left.items():
            asked.connect(begin, end, motion)
        reached = [k for k in asked.reached(begin) if k != begin]
        nearest = min(reached, key=lambda k: distance(asked.milestones[k]), default=begin)
        inputs = asked.quickest(begin, nearest) if reached else None
        return np.zeros((0, self._problem.model.nu)) if inputs is None else inputs

    def _keep(self, left: dict[int, Array], start: Array) -> None:
        """Cache motions from a start, together with earlier ones from the same start."""
        same = np.array_equal(start, self._start)
        self._start, self._left = start, {**self._left, **left} if same else left

    def _joined(
        self, roadmap: Roadmap, number: int, size: int, budget: Budget, *, leaving: bool
    ) -> int:
        """Connect a start or a goal to the roadmap's milestones; return the number of successes."""
        done = 0
        for other in self._nearest(roadmap.milestones[number], 3 * self._neighbours, size=size):
            pair = (number, other) if leaving else (other, number)
            done += self._steer(roadmap, *pair, budget)
            if done >= 2 or budget.over:  # motions that connect a start or a goal to the roadmap
                break
        return done

    def _steer(self, roadmap: Roadmap, a: int, b: int, budget: Budget) -> bool:
        if budget.spent():
            return False
        self._budget = budget
        begin, end = roadmap.milestones[a], roadmap.milestones[b]
        try:
            for motion in self._steering.steer(begin, end, self._passes_coarse_check):
                if motion.is_free(self._judge, self._cancelled):
                    roadmap.connect(a, b, motion.u)
                    return True
        except CancelledError:
            budget.take_back()
        return False

    def _cancelled(self) -> bool:
        return self._budget is not None and self._budget.expired()

    def _passes_coarse_check(self, states: Array) -> bool:
        """Check sampled states (n, nx) of a path before its motion is computed."""
        raise_if_cancelled(self._cancelled)
        return all(self._judge.admits(x) for x in states.tolist())

    def _nearest(
        self, state: Array, count: int, *, apart_from: int = -1, size: int | None = None
    ) -> Iterator[int]:
        """Yield the milestones nearest to a state (nx,) in the problem's metric."""
        known = np.array(self.roadmap.milestones[:size])
        if not len(known):
            return
        distances = self._problem.space.distance(known, state, self._problem.weights)
        order = np.argsort(distances, kind="stable")
        yield from [int(k) for k in order if k != apart_from][:count]
