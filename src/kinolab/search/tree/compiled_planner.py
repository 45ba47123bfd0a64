"""Base class of the compiled planners: a tree that grows in time slices, work and all."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np

from kinolab.dynamics.codegen.methods import METHODS
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge, in_whole_ticks
from kinolab.problem import PlanningTask
from kinolab.problem.goals_reached import SAME_TIME
from kinolab.problem.objective.costed import costed
from kinolab.problem.time_steps import covering_steps
from kinolab.scenario import improvement_seconds
from kinolab.search.budget import Budget
from kinolab.search.planner import AbstractTreeSearch
from kinolab.search.result import Outcome, SearchResult, unsolved
from kinolab.search.tree.sub_searches import GoalConnections, InterleavedSearches, SubSearch
from kinolab.search.tree.time_slices import RestartRounds, TimeSlices
from kinolab.search.tree.tree import (
    COST_UNIT,
    FULL,
    REACHED,
    controls_to,
    nearer,
    step_counts,
)
from kinolab.search.tree.tree_extension import (
    UNBOUNDED_STEPS,
    AbstractTreeExtension,
    SearchState,
    search_state,
)
from kinolab.settings import setting, with_default
from kinolab.simulation import Propagator
from kinolab.simulation.reference import cost_of_inputs
from kinolab.simulation.resimulated_goal import TrueEnds

ITERATION_SECONDS = 1.5e-6  # [s] of work for an iteration of a tree, its steps apart


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
            return self._grow(problem, seed, budget, tree)

    def _grow(
        self, problem: PlanningTask, seed: int, budget: Budget, tree: AbstractTreeExtension
    ) -> SearchResult:
        tree.begin()
        tree.grow(0)
        section, objective = problem.scenario.planner, problem.scenario.objective
        seconds = improvement_seconds(section.improve if budget.improve is None else budget.improve)
        budget.restart()  # code was compiled and loaded until here
        own = problem if tree.nodes.cost_entry < 0 else costed(problem) or problem
        cost = len if own is problem else partial(trees_cost, problem)
        best = IncumbentImprovement(budget, seconds, problem.step, cost)
        best.longest = (objective and objective.max_time) or math.inf
        best.bound(tree)
        sub_searches = self.beside(problem, seed, budget) if own is problem else ()
        beside, predicate = InterleavedSearches(sub_searches), own.goal.predicate
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
                        best.found(found, tree)
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


def rejection_sources(
    problem: PlanningTask, states: Array, max_steps: int, budget: Budget
) -> dict[str, dict[str, float]]:
    """Estimate the fractions of rejections by cause and source, as ``Rejections.shares``.

    Args:
        states: From which motions begin, shape (n, nx), at least one.
        max_steps: Maximum control duration in steps.
        budget: Of the finished search; if no time is left, few motions are made.
    """
    with budget.preparing():
        generator, judge = np.random.default_rng(0), Propagator(problem)
    lower, upper = problem.model.control_bounds.T
    # a few similar motions are repeated: the compiled loop counts causes, not their sources
    for node in generator.integers(len(states), size=100):
        # [s] allowed for them beyond the search's time limit
        if budget.elapsed > budget.time_limit + 0.02:
            break
        x, u = states[node].tolist(), generator.uniform(lower, upper).tolist()
        for _ in range(generator.integers(max_steps) + 1):
            x, free = judge.step(x, u, problem.step)
            if not free:
                break
    return judge.rejections.shares()


class IncumbentImprovement:
    """The incumbent solution and the time limit of its improvement.

    Args:
        seconds: Time to continue after the first solution, in [s].
        step: Time step of the motions in [s].
        cost: Returns what inputs (N, nu) cost; the number of steps when left out.

    Attributes:
        longest: Duration in [s] that none may exceed.
        u: Inputs of the shortest solution (N, nu); None before there is one.
        statistics: Duration of the first solution in [s], and the number of improvements.
    """

    def __init__(
        self, budget: Budget, seconds: float, step: float, cost: Callable[[Array], int] = len
    ) -> None:
        self._clock, self._seconds, self._step = budget.clock, seconds, step
        self._cost = cost
        self._until, self._pointless = math.inf, False
        self._most, self._gained, self._patience = UNBOUNDED_STEPS, math.inf, budget.patience
        # A duration says nothing of what else a motion costs.
        if math.isfinite(budget.below) and seconds > 0 and cost is len:
            self._most = covering_steps(budget.below, step)
            self._gained = self._clock()
        self.longest = math.inf
        self.u: Array | None = None
        self.statistics: dict[str, float] = {}

    @property
    def over(self) -> bool:
        """Whether the search must end."""
        now = self._clock()
        return self._pointless or now >= self._until or now - self._gained >= self._patience

    def bound(self, tree: AbstractTreeExtension) -> None:
        """Bound a tree from its beginning where a motion is known already."""
        if self._most < UNBOUNDED_STEPS:
            tree.shorten(self._most)

    def wants(self, u: Array) -> bool:
        """Say whether inputs (N, nu) are shorter, or cost less, than the incumbent."""
        return len(u) * self._step <= self.longest + SAME_TIME and self._cost(u) < self._most

    def found(self, u: Array, tree: AbstractTreeExtension) -> None:
        """Accept inputs (N, nu) as the incumbent, and bound the tree by their length."""
        if self.u is None:
            self.statistics = {"first_duration": len(u) * self._step, "improvements": 0.0}
            self._until = self._clock() + self._seconds
        else:
            self.statistics["improvements"] += 1.0
        self.u, self._most, self._gained = u, self._cost(u), self._clock()
        self._pointless = self.over or not tree.shorten(self._most)


def trees_cost(problem: PlanningTask, u: Array) -> int:
    """Return what inputs (N, nu) cost by [objective], as trees count it."""
    return int(min(cost_of_inputs(problem, u) / COST_UNIT, UNBOUNDED_STEPS - 1.0))


def step_seconds(problem: PlanningTask) -> float:
    """Return what a step in a tree takes on an idle computer with all that belongs to it, in [s].

    Fitted to the scenarios that come with kinolab and to dynobench (one core of an AMD EPYC); it
    holds within a factor of two for most, and of four for all of them.
    """
    integration, operations = problem.scenario.integration, problem.model.operations
    method = METHODS[integration.method]
    evaluations = integration.substeps * method.evaluations(problem.model.nx)
    shapes = sum(len(body.shapes) for body in problem.bodies) + len(problem.cables)
    seconds = 4e-7 + operations * (7e-9 + 7e-10 * evaluations) + 1.5e-7 * shapes
    if problem.model.plant is not problem.model:
        seconds += 4e-6  # the law
    if problem.machine.requirements:
        seconds *= 2.0
    if problem.machine.modes:
        seconds += 2e-5  # every step may end a mode
    return in_whole_ticks(seconds)  # the sum of steps is the same in whatever parts they are made


def growth_seconds(each_step: float, steps: int, iterations: int) -> float:
    """Return what the growth of a tree takes on an idle computer, in [s].

    Args:
        each_step: What a step takes, in [s].
        steps, iterations: That were made.
    """
    return steps * each_step + iterations * ITERATION_SECONDS
