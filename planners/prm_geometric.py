"""A roadmap of configurations, and feedback that follows its paths."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from kinolab.bridge import Configurations, GeometricRoadmap
from kinolab.problem import Problem
from kinolab.propagation import Propagator
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting
from kinolab.steering import Maneuver, Steering, ignorable, settle

Array: TypeAlias = NDArray[np.float64]

BATCH = 20  # configurations between two questions
GOALS = 10  # states of the goal region among which one to end at is chosen
WIDER = 1.5  # factor on the margin after a path that could not be followed


@final
@dataclass(frozen=True, kw_only=True)
class PRMGeometric(AbstractPlanner):
    """Probabilistic roadmap of configurations (OMPL), followed with feedback.

    A path of the roadmap becomes a motion from rest to rest along each of its parts; the machine
    follows it through the full dynamics under time-varying linear-quadratic feedback. What is
    judged is the motion that comes of it. Where that collides or misses the goal, the next roadmap
    keeps further from obstacles.

    Source: Kavraki, Svestka, Latombe, Overmars, IEEE Trans. Robotics and Automation 12(4), 1996.
    """

    name: ClassVar[str] = "prm_geometric"

    neighbours: int = setting(
        8, 1, 1000, meaning="How many of the nearest configurations each is joined to."
    )
    margin: float = setting(
        0.02, 0.0, 10.0, unit="m", meaning="How far paths keep from obstacles at first."
    )

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Find paths and follow them until the motion of one is free and reaches the goal."""
        follower = _Follower(problem)
        goal, margin, tried = follower.goal(seed), self.margin, 0
        nearest = follower.still
        if follower.excess(nearest) <= 1.0:
            return _result(problem, nearest, follower, budget, tried)
        budget.restart()  # code for this machine was compiled and loaded until here
        while goal is not None and not budget.spent():
            path = self._path(problem, follower, goal, margin, seed + tried, budget)
            if path is None:
                break
            motion = follower.follow(*path)
            if follower.excess(motion) <= 1.0:
                return _result(problem, motion, follower, budget, tried)
            nearest = min(nearest, motion, key=lambda m: problem.goal_distance(m.x[-1]))
            margin, tried = max(WIDER * margin, 0.005), tried + 1
        return _result(problem, nearest, follower, budget, tried)

    def _path(
        self,
        problem: Problem,
        follower: _Follower,
        goal: Array,
        margin: float,
        seed: int,
        budget: Budget,
    ) -> tuple[Configurations, list[Array]] | None:
        """Return configurations on a path with room on both sides, and what joins them."""
        if follower.steering.paths is None:
            return None
        configurations = Configurations(
            problem, follower.steering, goal, margin, follower.rejections
        )
        if not configurations.differ:
            return None
        roadmap = GeometricRoadmap(configurations, problem.start, goal, seed, self.neighbours)
        while not budget.over:
            path = roadmap.path()
            if path is not None:
                return configurations, path
            roadmap.grow(BATCH, budget)
        return configurations, roadmap.approach(problem.goal_distance)


class _Follower:
    """Makes motions of paths, and judges them."""

    def __init__(self, problem: Problem) -> None:
        self._problem, self.steering, self._judge = problem, Steering(problem), Propagator(problem)
        self.rejections = self._judge.rejections

    def goal(self, seed: int) -> Array | None:
        """Return a free state at rest within the goal, its middle if that is one."""
        generator, problem = np.random.default_rng(seed), self._problem
        for k in range(GOALS):
            x = problem.sample_goal(generator, 1.0 if k else 1e-9)
            x = np.where(ignorable(problem), 0.0, self.steering.ways.straightened(x))
            settled = settle(problem, x)
            if settled is not None and self._ends_well(settled[0]):
                return settled[0]
        return None

    def _ends_well(self, x: Array) -> bool:
        return self._problem.goal_excess(x) <= 1.0 and self._judge.is_free(x.tolist())

    @property
    def still(self) -> Maneuver:
        """The motion that stays at the start."""
        return Maneuver(self._problem.start[None], np.zeros((0, self._problem.model.nu)))

    def excess(self, motion: Maneuver) -> float:
        """Return how far outside the goal a motion ends, at most 1 inside."""
        return self._problem.goal_excess(motion.x[-1])

    def follow(self, configurations: Configurations, path: list[Array]) -> Maneuver:
        """Return the motion along a path, as far as it is free."""
        reached = self.still
        for wanted in self._wanted(configurations, path):
            piece = self.steering.tracker.track(reached.x[-1], wanted)
            if piece is None or not self._is_free(piece):
                break
            reached = reached.then(piece)
        return reached

    def _wanted(self, configurations: Configurations, path: list[Array]) -> Iterator[Maneuver]:
        """Yield what feedback shall follow from one configuration to the next."""
        assert self.steering.paths is not None
        for x0, x1 in pairwise(path):
            motions = (
                self.steering.paths.chain(ways, x0) for ways in configurations.free_ways(x0, x1)
            )
            motion = next((found for found in motions if found is not None), None)
            if motion is None:
                return
            yield motion

    def _is_free(self, motion: Maneuver) -> bool:
        step = self._problem.step
        pairs = zip(motion.x.tolist(), motion.u.tolist(), strict=False)
        return all(self._judge.step(x, u, step)[1] for x, u in pairs)


def _result(
    problem: Problem, motion: Maneuver, follower: _Follower, budget: Budget, tried: int
) -> SearchResult:
    outcome = Outcome.SOLVED
    if follower.excess(motion) > 1.0:
        outcome = Outcome.APPROXIMATE if motion.steps else Outcome.NOT_FOUND
        outcome = Outcome.INTERRUPTED if budget.interrupted else outcome
    times = problem.step * np.arange(motion.steps + 1, dtype=float)
    statistics = {"paths_not_followed": float(tried)}
    shares = follower.rejections.shares()
    return SearchResult(outcome, times, motion.u, budget.iterations, statistics, shares)
