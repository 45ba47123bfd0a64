"""Base class of the compiled planners: a tree that grows in time slices, work and all."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np

from kinolab.numerics.work import charge, in_whole_ticks
from kinolab.problem import PlanningTask
from kinolab.problem.objective.costed import costed
from kinolab.scenario import improvement_seconds
from kinolab.search.budget import Budget
from kinolab.search.planner import AbstractTreeSearch
from kinolab.search.rejection_sources import rejection_sources
from kinolab.search.result import Outcome, SearchResult, unsolved
from kinolab.search.tree.growth_work import ITERATION_SECONDS, step_seconds
from kinolab.search.tree.incumbent_improvement import IncumbentImprovement, trees_cost
from kinolab.search.tree.search_state import SearchState, search_state
from kinolab.search.tree.sub_searches import GoalConnections, InterleavedSearches, SubSearch
from kinolab.search.tree.time_slices import RestartRounds, TimeSlices
from kinolab.search.tree.tree import (
    FULL,
    REACHED,
    controls_to,
    nearer,
    step_counts,
)
from kinolab.search.tree.tree_extension import AbstractTreeExtension
from kinolab.settings import setting, with_default
from kinolab.simulation.resimulated_goal import TrueEnds


@dataclass(frozen=True, kw_only=True)
class AbstractCompiledPlanner(AbstractTreeSearch):
    """A planner whose whole loop is compiled, once for all machines."""

    in_threads: ClassVar[bool] = True
    work_per_iteration: ClassVar[float] = 0.0  # which is charged while a tree grows

    control_samples: int = setting(
        1, 1, 1000, meaning="Inputs that are compared before one is held."
    )
    max_nodes: int = setting(
        200_000,
        64,
        20_000_000,
        unit="nodes",
        meaning="Most states that a tree keeps; then a new one begins.",
    )
    restart_after: int = with_default(0, AbstractTreeSearch, "restart_after")
    goal_connection_period: int = setting(
        20_000,
        0,
        1_000_000_000,
        unit="iterations",
        meaning="How often a state of the tree is steered into the goal; 0 for never.",
    )

    @abstractmethod
    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:
        """Return the tree extension."""

    def beside(self, problem: PlanningTask, seed: int, budget: Budget) -> Sequence[SubSearch]:
        """Return what takes turns with the tree: connections, but where a machine has modes."""
        if problem.machine.modes:
            return ()
        period, scale = self.goal_connection_period, self.goal_region_scale
        return (GoalConnections(problem, period, scale, seed, budget),)

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start into the goal region, then improve the solution."""
        priced = (self.compares_costs and costed(problem)) or problem
        tree = self.extension(priced, search_state(priced, self.goal_region_scale, seed))
        with closing(tree):
            return self._grow(problem, priced, seed, budget, tree)

    def _grow(
        self,
        problem: PlanningTask,
        own: PlanningTask,
        seed: int,
        budget: Budget,
        tree: AbstractTreeExtension,
    ) -> SearchResult:
        """Return the result; the tree's own problem may have a state more, which is the cost."""
        tree.begin()
        tree.grow(0)
        section, objective = problem.scenario.planner, problem.scenario.objective
        seconds = improvement_seconds(section.improve if budget.improve is None else budget.improve)
        budget.restart()  # code was compiled and loaded until here
        sub_searches = self.beside(problem, seed, budget) if own is problem else ()
        beside, predicate = InterleavedSearches(sub_searches), own.goal.predicate
        cost = len if own is problem else partial(trees_cost, problem)
        best = IncumbentImprovement(tree, budget, seconds, problem.step, cost)
        best.longest = (objective and objective.max_time) or math.inf
        truth, rounds = TrueEnds(problem), RestartRounds(self.restart_after)
        slices = TimeSlices(budget, rounds)
        own_map = problem.scenario.integration.truth == "discrete"  # no re-simulation needed
        approach, each_step = (math.inf, np.zeros((0, problem.model.nu))), step_seconds(problem)
        each_iteration = in_whole_ticks(ITERATION_SECONDS)
        with closing(beside):
            while not best.over and (iterations := slices.next(beside.due)):
                before = tree.steps_made
                ended, made = tree.grow(iterations)
                charge(each_step * (tree.steps_made - before) + each_iteration * made)
                slices.done(made)
                budget.show(tree.explored)
                found = beside.advance(made, tree)
                if ended == REACHED:
                    last = int(tree.nodes.size[0]) - 1
                    inside = predicate is None or predicate(tree.nodes.x[last])
                    found = controls_to(tree.nodes, last) if inside else None
                accepted = False
                if found is not None and best.wants(found):
                    accepted = own_map or truth.excess(found) <= 1.0
                    if accepted:
                        best.found(found)
                    # solutions rejected by re-simulation after which the tree restarts
                    elif truth.refused % 10 == 0:
                        rounds.left = 0.0
                # Also where a tree arrives again and again in the same way that truth refuses.
                if not accepted and (ended == FULL or rounds.over):
                    approach = nearer(tree.nodes, tree.best, *approach)
                    rounds.begin()
                    tree.begin()
        u, outcome = best.u, Outcome.SOLVED
        if u is None:
            u = nearer(tree.nodes, tree.best, *approach)[1]
            outcome = unsolved(budget, len(u))
        statistics = truth.statistics | {"restarts": float(rounds.restarts)} | best.statistics
        statistics |= beside.statistics
        result = SearchResult(
            outcome,
            problem.step * np.arange(len(u) + 1.0),
            u,
            budget.iterations,
            step_counts(tree.nodes) | statistics,
            graph=tree.explored(),
        )
        there_is_one = outcome is Outcome.SOLVED or budget.below < math.inf
        if there_is_one or budget.interrupted:
            return result  # nobody asks why none was found
        states = tree.nodes.x[: int(tree.nodes.size[0])]
        return replace(result, rejections=rejection_sources(own, states, self.max_steps, budget))
