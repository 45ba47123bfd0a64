"""Trajectory optimisation from guesses, for machines that swing and fly."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count
from typing import ClassVar, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from kinolab.optimize.free_ways import FreeWays
from kinolab.optimize.guesses import Guesses
from kinolab.optimize.shooting import shoot
from kinolab.problem import Problem
from kinolab.search import AbstractPlanner, Budget, Outcome, SearchResult, setting
from kinolab.stopping import StoppedError
from kinolab.trajectory import Trajectory

Array: TypeAlias = NDArray[np.float64]

SLOWER = (2.0, 3.0, 1.4, 4.0, 2.5, 6.0)
JITTER = 0.3
TURNING = (0.1, 1.0)
PATIENCE = (20, 30)  # subproblems for each of the first guesses, and for later ones
FEWEST = 10  # steps of a guess


@final
@dataclass(frozen=True, kw_only=True)
class Shooting(AbstractPlanner):
    """Direct multiple shooting from guesses that differ in duration, turns and way.

    Source: Bock, Plitt, IFAC 1984; guesses of geometric planners: Ortiz-Haro, Hoenig, Hartmann,
    Toussaint, IEEE Trans. Robotics 41, 2025, for what they are worth.
    """

    name: ClassVar[str] = "shooting"

    knots: int = setting(80, 10, 10_000, meaning="How many knots a guess has, more or less.")

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Try one guess after another until one leads into the goal."""
        guesses = Guesses(problem, np.random.default_rng(seed))
        generator = np.random.default_rng([seed, 1])
        ways = FreeWays(problem, generator, lambda: budget.late)
        stream = _stream(guesses, ways, generator)
        budget.restart()
        motion, tried = None, 0
        while motion is None and not budget.spent():
            try:
                way, times, patience = next(stream)
            except StoppedError:
                break
            tried += 1
            least = guesses.quickest(way) + guesses.starting
            duration = max(times * least, FEWEST * problem.step)
            block = max(1, round(duration / (self.knots * problem.step)))
            steps = max(FEWEST, math.ceil(duration / (block * problem.step)))
            guess = guesses.knots(way, steps, block * problem.step)
            motion = shoot(problem, guess, block, patience, lambda: budget.late)
        return _result(problem, motion, budget, tried)


def _stream(
    guesses: Guesses, ways: FreeWays, generator: np.random.Generator
) -> Iterator[tuple[Array, float, int]]:
    """Yield ways, each with how much longer than the quickest to take, and patience."""
    begin, end = guesses.straight()
    for k in count():
        times, patience = SLOWER[k % len(SLOWER)], PATIENCE[k >= len(SLOWER)]
        if k >= len(SLOWER):
            times *= float(np.exp(generator.uniform(-JITTER, JITTER)))
        way = ways.find(begin, end, TURNING[k % 3]) if k % 3 < 2 else None
        if way is None or (k and ways.is_free(begin, end)):
            way = guesses.winding()
        yield way, times, patience


def _result(
    problem: Problem, motion: Trajectory | None, budget: Budget, tried: int
) -> SearchResult:
    statistics = {"guesses": float(tried)}
    if motion is None:
        outcome = Outcome.INTERRUPTED if budget.interrupted else Outcome.NOT_FOUND
        nothing = np.zeros((0, problem.model.nu))
        return SearchResult(outcome, np.zeros(1), nothing, budget.iterations, statistics)
    return SearchResult(Outcome.SOLVED, motion.t, motion.u, budget.iterations, statistics)
