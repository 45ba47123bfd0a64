"""A geometric roadmap whose paths are tracked by feedback."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, final

import numpy as np

from kinolab.concurrency.cancel import CancelledError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting, unsolved
from kinolab.search.roadmap import ConfigurationSpace, GeometricRoadmap
from kinolab.search.roadmap.milestones import Sampler
from kinolab.simulation import Propagator
from kinolab.steering import Maneuver, Steering

CONFIGURATIONS_PER_BATCH = 20  # configurations between queries


@final
@dataclass(frozen=True, kw_only=True)
class PRMGeometric(AbstractPlanner):
    """Probabilistic roadmap of configurations, followed with feedback.

    Each edge of a roadmap path becomes a rest-to-rest motion, which the machine tracks under the
    full dynamics with time-varying linear-quadratic feedback. The closed-loop motion is checked. If
    it collides or misses the goal, the next roadmap keeps a larger clearance.

    Source: Kavraki, Svestka, Latombe, Overmars, IEEE Trans. Robotics and Automation 12(4), 1996.
    """

    name: ClassVar[str] = "prm_geometric"
    work_per_iteration: ClassVar[float] = 2e-2

    neighbours: int = setting(
        8, 1, 1000, meaning="Nearest configurations that each one is joined to."
    )
    margin: float = setting(
        0.02, 0.0, 10.0, unit="m", meaning="Clearance that paths keep from obstacles at first."
    )

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Track roadmap paths until the motion of one is collision-free and reaches the goal."""
        follower = _PathFollower(problem, budget)
        goal, margin, tried = follower.goal(seed), self.margin, 0
        if follower.reaches or goal is None or follower.steering.paths is None:
            return _result(problem, follower, budget, tried)
        places = follower.places(goal, margin)
        budget.restart()  # code for this machine was compiled and loaded until here
        try:
            while places.differ and not budget.spent():
                given = problem.start, goal, seed + tried, self.neighbours
                path = _path(GeometricRoadmap(places, *given), follower, places, budget)
                if path is None:
                    break
                follower.follow(places, path)
                if follower.reaches:
                    break
                # factor on the margin after a path that could not be tracked
                margin, tried = max(1.5 * margin, 0.005), tried + 1
                places = follower.places(goal, margin)
        except CancelledError:
            pass  # partial work is discarded
        return _result(problem, follower, budget, tried)


def _path(
    roadmap: GeometricRoadmap, follower: _PathFollower, places: ConfigurationSpace, budget: Budget
) -> list[Array] | None:
    """Grow the roadmap until it has a path to the goal, states (nx,); None if the budget is spent.

    Until then, paths to the nearest approach are tracked now and then, since at the time limit it
    is too late for that.
    """
    due = CONFIGURATIONS_PER_BATCH
    while not budget.over:
        path = roadmap.path()
        if path is not None:
            return path
        if roadmap.size >= due:
            due *= 4  # growth of the roadmap between attempts to follow its nearest approach
            follower.follow(places, roadmap.approach(follower.problem.goal_distance))
        roadmap.grow(CONFIGURATIONS_PER_BATCH, budget)
    return None


class _PathFollower:
    """Tracks paths, checks the motions, and keeps the one that ends nearest to the goal.

    Attributes:
        problem: The planning problem.
        steering: Of its machine.
        rejections: Rejected motions by cause and source.
        nearest: The motion that ends nearest to the goal; initially empty, at the start.
    """

    def __init__(self, problem: PlanningTask, budget: Budget) -> None:
        self.problem, self._budget, self._judge = problem, budget, Propagator(problem)
        self.steering, self.rejections = Steering(problem, budget.expired), self._judge.rejections
        self.nearest = self._still

    def goal(self, seed: int) -> Array | None:
        """Return a collision-free equilibrium (nx,) in the goal, preferably its centre; or None."""
        sampler = Sampler(self.problem, self.steering, self._judge, seed)
        # goal samples from which to choose an equilibrium
        return next(sampler.near_goal(10, moving=False), None)

    def places(self, goal: Array, margin: float) -> ConfigurationSpace:
        """Return the configuration space with a clearance margin in [m]."""
        return ConfigurationSpace(
            self.problem, self.steering, goal, margin, self.rejections, self._budget.expired
        )

    @property
    def reaches(self) -> bool:
        """Whether the nearest motion ends in the goal."""
        return self.problem.goal_excess(self.nearest.x[-1]) <= 1.0

    def follow(self, places: ConfigurationSpace, path: list[Array]) -> None:
        """Track a path as far as it is free; each edge counts as an iteration."""
        reached = self._still
        try:
            for x0, x1 in pairwise(path):
                piece = None if self._budget.spent() else self._piece(places, reached.x[-1], x0, x1)
                if piece is None:
                    break
                reached = reached.then(piece)
        except CancelledError:
            self._budget.take_back()
        self.nearest = min(
            self.nearest, reached, key=lambda motion: self.problem.goal_distance(motion.x[-1])
        )

    @property
    def _still(self) -> Maneuver:
        return Maneuver(self.problem.start[None], np.zeros((0, self.problem.model.nu)))

    def _piece(
        self, places: ConfigurationSpace, begin: Array, x0: Array, x1: Array
    ) -> Maneuver | None:
        """Track the edge from x0 to x1 from a state near x0, (nx,) each; None if it collides."""
        assert self.steering.paths is not None
        motions = (self.steering.paths.chain(paths, x0) for paths in places.free_paths(x0, x1))
        wanted = next((found for found in motions if found is not None), None)
        piece = wanted and self.steering.tracker.track(begin, wanted)
        free = piece is not None and piece.is_free(self._judge, self._budget.expired)
        return piece if free else None


def _result(
    problem: PlanningTask, follower: _PathFollower, budget: Budget, tried: int
) -> SearchResult:
    motion = follower.nearest
    outcome = Outcome.SOLVED if follower.reaches else unsolved(budget, motion.steps)
    times = problem.step * np.arange(motion.steps + 1, dtype=float)
    statistics = {"paths_not_followed": float(tried)}
    shares = follower.rejections.shares()
    return SearchResult(outcome, times, motion.u, budget.iterations, statistics, shares)
