"""Run an OMPL control planner on a problem and read its solution path."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from ompl import base as ob
from ompl import util as ou

from kinolab.search.budget import Budget
from kinolab.search.graph import SearchGraph
from kinolab.search.ompl.simple_setup import OmplSetup
from kinolab.search.ompl.solution_path import path_in, with_last_step
from kinolab.search.result import Outcome, SearchResult, unsolved
from kinolab.simulation.resimulated_goal import TrueEnds


def search(
    setup: OmplSetup,
    begin: Callable[[OmplSetup], Any],
    again: Callable[[OmplSetup, Any], Any],
    seed: int,
    budget: Budget,
    restart_after: int = 0,
) -> SearchResult:
    """Search with an OMPL planner.

    OMPL is reproducible only if its random numbers are seeded before the planner is constructed.

    Args:
        begin: Returns a planner that is ready to solve.
        again: Returns a planner with an empty tree, given a used one.
        budget: When to stop.
        restart_after: Iterations of the first round; then the planner restarts, with a longer round
            each time. 0 for a single round.

    Source: Wedge, Branicky, On heavy-tailed runtimes and restarts in rapidly-exploring random
    trees, AAAI 2008.
    """
    problem, definition = setup.problem, setup.problem_definition
    ou.RNG.setSeed(ompl_seed(seed))  # after the setup, which samples to size its cells
    planner = begin(setup)
    budget.restart()  # code for this machine was compiled and loaded until here
    rounds = _Rounds(budget, restart_after, lambda: _graph(setup, planner))
    condition = ob.PlannerTerminationCondition(rounds.ended)
    nearest, reached = (math.inf, np.zeros((0, problem.model.nu))), False
    truth = TrueEnds(problem)
    while not rounds.all_over:
        begun = budget.iterations
        planner.solve(condition)
        excess, u = path_in(problem, definition)
        if definition.hasExactSolution():
            u = with_last_step(u, setup.last_step)
            true = budget.breaking(partial(truth.excess, u))
            if true is None:
                rounds.all_over, nearest = True, (excess, u)  # interrupted during re-simulation
                break
            excess = true
            if excess <= 1.0:
                nearest, reached = (excess, u), True
                break  # otherwise the next solve continues with the same tree
        if excess < nearest[0]:
            nearest = excess, u
        definition.clearSolutionPaths()
        if rounds.over:
            setup.forget()
            planner = again(setup, planner)
            rounds.begin_next()
        elif budget.iterations == begun:
            rounds.all_over = True  # OMPL rejects the start, which lies within the safety margin
    u = nearest[1]
    statistics = {f"rejected_by_{cause}": float(n) for cause, n in setup.rejections.counts.items()}
    statistics |= {**truth.statistics, "restarts": float(rounds.restarts), **setup.statistics}
    shares = setup.rejections.shares()
    graph = None if rounds.all_over else _graph(setup, planner)  # would exceed the time limit
    outcome = Outcome.SOLVED if reached else unsolved(budget, len(u))
    t = problem.step * np.arange(len(u) + 1.0)
    return SearchResult(outcome, t, u, budget.iterations, statistics, shares, graph)


def _graph(setup: OmplSetup, planner: Any) -> SearchGraph:
    """Copy a planner's tree out of OMPL."""
    data = ob.PlannerData(setup.problem_definition.getSpaceInformation())
    planner.getPlannerData(data)
    size = data.numVertices()
    parents = np.full(size, -1)
    for k in range(size):
        parents[list(data.getEdges(k))] = k

    def states(kept: Any) -> Any:
        return np.array([setup.read(data.getVertex(int(k)).getState()) for k in kept])

    # states copied out of OMPL, at 40 us each
    return SearchGraph.of_tree(states, parents, most=3000)


class _Rounds:
    """Restart schedule: ends rounds and the search, and shows snapshots of the tree.

    Attributes:
        over: Whether the round's iterations are used up.
        all_over: Whether the budget is spent.
        restarts: Number of finished rounds.
    """

    def __init__(self, budget: Budget, first: int, explored: Callable[[], SearchGraph]) -> None:
        self._explored = explored
        self._budget, self._length, self._end = budget, float(first), float(first or math.inf)
        self.over = self.all_over = False
        self.restarts = 0

    def ended(self) -> bool:
        """Termination condition; counts one more iteration if the planner may continue."""
        self.over = self._budget.iterations >= self._end
        self.all_over = not self.over and self._budget.spent()
        self._budget.show(self._explored)  # the tree is consistent whenever the planner asks
        return self.over or self.all_over

    def begin_next(self) -> None:
        """Begin a longer round."""
        self._length *= 1.5  # ratio of consecutive round lengths
        self._end = self._budget.iterations + self._length
        self.over, self.restarts = False, self.restarts + 1


def ompl_seed(seed: int) -> int:
    """Return a seed for OMPL, which takes 32 bits and ignores 0."""
    mixed = int(np.random.SeedSequence(seed).generate_state(1)[0])
    return mixed or 1
