"""What the compiled planners have in common: pieces of a search between looks at the clock."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, NamedTuple, Protocol

import numpy as np

from kinolab.numerics.kd_forest import Array
from kinolab.numerics.rng import State, generator
from kinolab.problem import Problem
from kinolab.search.graph import SearchGraph
from kinolab.search.planner import Budget, Outcome, SearchResult, setting, with_default
from kinolab.search.tree.problem_arrays import Question, question_of
from kinolab.search.tree.rejection_sources import culprits
from kinolab.search.tree.tree import (
    COLLISION,
    EQUATIONS,
    FULL,
    LIMIT,
    REACHED,
    TRIED,
    Tree,
    rows_to,
)
from kinolab.search.tree_search import AbstractTreeSearch
from kinolab.simulation.collision_context import Looks, Ways, looks_at, ways_of
from kinolab.simulation.machine import Machine, machine_of
from kinolab.simulation.resimulated_goal import TrueEnds

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kinolab.steering.steered_goal_connection import LastStep

PIECE = 0.005  # [s] of a search between two looks at the clock
FIRST = 64  # iterations of the first piece
MOST = 2048  # iterations of a piece: some milliseconds, and where they get slow still little
GROWTH = 1.5  # of the length of a round over the one before
MISSES = 10  # motions into the goal that the truth refuses, after which a new tree begins
ANY = 2**62  # steps: more than any motion has


class Search(NamedTuple):
    """Everything that a compiled loop works on."""

    machine: Machine
    question: Question
    ways: Ways
    looks: Looks
    random: State


def search_of(problem: Problem, zoom: float, seed: int) -> Search:
    """Gather everything for one search; searches in threads of their own share nothing written."""
    poses, ends = np.zeros((len(problem.bodies), 12)), np.zeros((len(problem.cables), 6))
    ways = ways_of(problem)
    return Search(
        machine_of(problem),
        question_of(problem, zoom, seed),
        ways,
        looks_at(problem, ways, poses, ends),
        generator(seed),
    )


class AbstractGrowth(ABC):
    """A tree that grows in compiled code.

    Attributes:
        nodes: Of the tree.
        best: The node nearest to the goal, and how far outside it is, shape (2,).
    """

    nodes: Tree
    best: Array

    @abstractmethod
    def begin(self) -> None:
        """Leave nothing in the tree but the start."""

    @abstractmethod
    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow by some iterations; return GROWING, REACHED or FULL, and how many were made."""

    def shorten(self, steps: int) -> bool:  # noqa: ARG002
        """Look only for motions of fewer steps from now on; return whether that has a point."""
        return False


@dataclass(frozen=True, kw_only=True)
class AbstractCompiledPlanner(AbstractTreeSearch):
    """A planner whose loop is compiled as a whole, once for all machines."""

    in_threads: ClassVar[bool] = True

    inputs_tried: int = setting(
        1, 1, 1000, meaning="How many inputs are compared before one is held."
    )
    max_nodes: int = setting(
        200_000,
        64,
        20_000_000,
        unit="nodes",
        meaning="How many states are kept at most; then a new tree begins.",
    )
    restart_after: int = with_default(0, AbstractTreeSearch, "restart_after")
    last_step_every: int = setting(
        20_000,
        0,
        1_000_000_000,
        unit="iterations",
        meaning="How often a state of the tree is steered into the goal; 0 for never.",
    )

    @abstractmethod
    def growth(self, problem: Problem, search: Search) -> AbstractGrowth:
        """Return what grows a tree."""

    def asides(self, problem: Problem, seed: int, budget: Budget) -> Sequence[Aside]:  # noqa: ARG002
        """Return other searches that have their turn now and then while the tree grows."""
        return ()

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start until it reaches the goal region, and on while it improves."""
        tree = self.growth(problem, search_of(problem, self.goal_zoom, seed))
        tree.begin()
        tree.grow(0)
        budget.restart()  # code was compiled and loaded until here
        nearest, u, solved = math.inf, np.zeros((0, problem.model.nu)), False
        length = left = float(self.restart_after or math.inf)
        truth, restarts, pieces = TrueEnds(problem), 0, Pieces(budget)
        asides = Asides(
            [Arrivals(problem, self, seed, budget), *self.asides(problem, seed, budget)]
        )
        own_map = problem.scenario.integration.truth == "discrete"  # what was applied is the truth
        improvement = Improvement(problem, budget)
        while not improvement.over and (iterations := pieces.next(min(left, asides.due))):
            ended, made = tree.grow(iterations)
            pieces.done(made)
            budget.show(lambda: explored(tree.nodes))
            left -= made
            found = asides.after(made, tree)
            if ended == REACHED:
                found = rows_to(tree.nodes, int(tree.nodes.size[0]) - 1)
            if found is not None and improvement.wants(len(found)):
                if own_map or truth.excess(found) <= 1.0:
                    solved, u = True, found
                    improvement.found(len(u), tree)
                else:
                    left = left if truth.refused % MISSES else 0.0
            elif ended == FULL or left <= 0:
                nearest, u = (nearest, u) if solved else nearer(tree, nearest, u)
                length *= GROWTH
                left, restarts = length, restarts + 1
                tree.begin()
        if not solved:
            nearest, u = nearer(tree, nearest, u)
        statistics = {**truth.statistics, "restarts": float(restarts), **improvement.statistics}
        outcome = result(problem, budget, u, tree.nodes, statistics, solved=solved)
        if solved or budget.interrupted:
            return outcome
        return replace(outcome, rejections=culprits(problem, tree.nodes, self.max_steps, budget))


class Improvement:
    """How long a search goes on after its first motion into the goal, for shorter ones.

    Args:
        problem: Says how long at most, unless the budget does.
        budget: Of the search.

    Attributes:
        statistics: The duration of the first motion in [s], and how many were shorter.
    """

    def __init__(self, problem: Problem, budget: Budget) -> None:
        own = budget.improve
        self._seconds = problem.scenario.planner.improve if own is None else own
        self._step, self._clock = problem.step, budget.clock
        self._until, self._steps, self._pointless = math.inf, ANY, False
        self.statistics: dict[str, float] = {}

    @property
    def over(self) -> bool:
        """Whether the search has come to its end."""
        return self._pointless or self._clock() >= self._until

    def wants(self, steps: int) -> bool:
        """Say whether a motion of so many steps is shorter than all before."""
        return steps < self._steps

    def found(self, steps: int, tree: AbstractGrowth) -> None:
        """Take a motion of so many steps, and have a tree look for shorter ones."""
        if self.statistics:
            self.statistics["improvements"] += 1.0
        else:
            self.statistics = {"first_duration": steps * self._step, "improvements": 0.0}
            self._until = self._clock() + self._seconds
        self._steps = steps
        self._pointless = self.over or not tree.shorten(steps)


class Aside(Protocol):
    """A search beside the tree.

    Attributes:
        due: Iterations of the tree until its next turn.
    """

    due: float

    def after(self, iterations: int, tree: AbstractGrowth) -> Array | None:
        """Return inputs from the start into the goal, where a turn was due and found some."""


class Asides:
    """Several searches beside a tree."""

    def __init__(self, members: Sequence[Aside]) -> None:
        self._members = members

    @property
    def due(self) -> float:
        """Iterations of the tree until the next turn of any."""
        return min(member.due for member in self._members)

    def after(self, iterations: int, tree: AbstractGrowth) -> Array | None:
        """Return what any of them found; each one counts all iterations."""
        found = [member.after(iterations, tree) for member in self._members]
        return next((inputs for inputs in found if inputs is not None), None)


class Arrivals:
    """Steers some of a tree's states into the goal, where growth alone would have to hit it.

    Args:
        problem: What to plan.
        planner: Says how often, and what counts as near the goal.
        seed: Of the choice of states.
        budget: Of the search.

    Attributes:
        due: Iterations until the next attempt.
    """

    def __init__(
        self, problem: Problem, planner: AbstractCompiledPlanner, seed: int, budget: Budget
    ) -> None:
        self._problem, self._zoom, self._budget = problem, planner.goal_zoom, budget
        self._every = self.due = planner.last_step_every or math.inf
        self._generator = np.random.default_rng(seed)

    @cached_property
    def _last_step(self) -> LastStep:
        with self._budget.preparing():
            from kinolab.steering.steered_goal_connection import (
                LastStep,  # brings SciPy's optimisers
            )

            return LastStep(self._problem, 1, self._zoom, lambda: self._budget.over)

    def after(self, iterations: int, tree: AbstractGrowth) -> Array | None:
        """Return inputs from the start into the goal, where an attempt was due and found some."""
        self.due -= iterations
        if self.due > 0:
            return None
        self.due = self._every
        node = int(self._generator.integers(tree.nodes.size[0]))
        x = tree.nodes.x[node]
        if not self._last_step.leads_in(x.tolist(), self._problem.goal_excess(x)):
            return None
        return np.concatenate([rows_to(tree.nodes, node), self._last_step.inputs])


class Pieces:
    """How many iterations to make before the next look at the clock.

    Args:
        budget: Of the search.
    """

    def __init__(self, budget: Budget) -> None:
        self._budget, self._size, self._begun = budget, FIRST, 0.0

    def next(self, most: float = math.inf) -> int:
        """Return how many iterations may be made now; 0 when the search must end."""
        if self._budget.over:
            return 0
        left = self._budget.left
        self._begun = self._budget.clock()
        return int(max(1, min(self._size, left, most)))

    def done(self, iterations: int) -> None:
        """Count iterations made, and fit the next piece to the time they took."""
        self._budget.spend(iterations)
        took = max(self._budget.clock() - self._begun, 1e-6)
        fitting = iterations * PIECE / took
        # Slowly upward: the first iterations of a tree are far quicker than those that follow.
        self._size = int(min(max(fitting, self._size / 4, 1), 2 * self._size, MOST))


def rows(problem: Problem, u: Array) -> tuple[Array, Array]:
    """Return times (N+1,) and inputs (N, nu) of a motion."""
    return problem.step * np.arange(len(u) + 1.0), u


def nearer(tree: AbstractGrowth, nearest: float, u: Array) -> tuple[float, Array]:
    """Return the motion of a tree that ends nearest to the goal, if it is nearer than another."""
    if tree.best[1] < nearest:
        return float(tree.best[1]), rows_to(tree.nodes, int(tree.best[0]))
    return nearest, u


def result(
    problem: Problem,
    budget: Budget,
    u: Array,
    nodes: Tree,
    statistics: dict[str, float],
    *,
    solved: bool,
) -> SearchResult:
    """Return what a search found, with what was refused by cause."""
    outcome = Outcome.SOLVED
    if not solved:
        outcome = Outcome.APPROXIMATE if len(u) else Outcome.NOT_FOUND
        outcome = Outcome.INTERRUPTED if budget.interrupted else outcome
    named = {"limit": LIMIT, "collision": COLLISION, "equations": EQUATIONS}
    counts = {f"rejected_by_{cause}": float(nodes.tally[k]) for cause, k in named.items()}
    counts |= {"propagations": float(nodes.tally[TRIED]), "nodes": float(nodes.size[0])}
    times, inputs = rows(problem, u)
    return SearchResult(
        outcome, times, inputs, budget.iterations, counts | statistics, graph=explored(nodes)
    )


def explored(nodes: Tree) -> SearchGraph:
    """Return a copy of a tree, thinned where it is large."""
    return SearchGraph.of_tree(lambda kept: nodes.x[kept], nodes.parent[: int(nodes.size[0])])
