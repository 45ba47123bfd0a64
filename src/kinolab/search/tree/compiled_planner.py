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
from kinolab.search.planner import (
    AbstractTreeSearch,
    Budget,
    Outcome,
    SearchResult,
    setting,
    with_default,
)
from kinolab.search.tree.problem_arrays import ProblemArrays, gather_problem
from kinolab.search.tree.rejection_sources import rejection_sources
from kinolab.search.tree.tree import (
    ALL_STEPS,
    COLLISION,
    EQUATIONS,
    FULL,
    LIMIT,
    REACHED,
    Tree,
    controls_to,
)
from kinolab.simulation.collision_context import (
    CollisionContext,
    CollisionScratch,
    collision_context,
    collision_scratch,
)
from kinolab.simulation.machine import Machine, machine_of
from kinolab.simulation.resimulated_goal import TrueEnds

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kinolab.steering.steered_goal_connection import SteeredGoalConnection

SLICE_SECONDS = 0.005  # [s] of a search between two looks at the clock
FIRST_SLICE_ITERATIONS = 64  # iterations of the first piece
# iterations of a piece: some milliseconds, and where they get slow still little
MAX_SLICE_ITERATIONS = 2048
RESTART_FACTOR = 1.5  # of the length of a round over the one before
# motions into the goal that the truth refuses, after which a new tree begins
MAX_RESIMULATION_FAILURES = 10
UNBOUNDED_STEPS = 2**62  # steps: more than any motion has


class SearchState(NamedTuple):
    """Everything that a compiled loop works on."""

    machine: Machine
    problem: ProblemArrays
    collision: CollisionContext
    scratch: CollisionScratch
    random: State


def search_state(problem: Problem, goal_region_scale: float, seed: int) -> SearchState:
    """Gather everything for one search; searches in threads of their own share nothing written."""
    poses, ends = np.zeros((len(problem.bodies), 12)), np.zeros((len(problem.cables), 6))
    context = collision_context(problem)
    return SearchState(
        machine_of(problem),
        gather_problem(problem, goal_region_scale, seed),
        context,
        collision_scratch(problem, context, poses, ends),
        generator(seed),
    )


class AbstractTreeExtension(ABC):
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

    control_samples: int = setting(
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
    goal_connection_period: int = setting(
        20_000,
        0,
        1_000_000_000,
        unit="iterations",
        meaning="How often a state of the tree is steered into the goal; 0 for never.",
    )

    @abstractmethod
    def extension(self, problem: Problem, search: SearchState) -> AbstractTreeExtension:
        """Return what grows a tree."""

    def sub_searches(self, problem: Problem, seed: int, budget: Budget) -> Sequence[SubSearch]:  # noqa: ARG002
        """Return other searches that have their turn now and then while the tree grows."""
        return ()

    def solve(self, problem: Problem, seed: int, budget: Budget) -> SearchResult:
        """Grow a tree from the start until it reaches the goal region, and on while it improves."""
        tree = self.extension(problem, search_state(problem, self.goal_region_scale, seed))
        tree.begin()
        tree.grow(0)
        budget.restart()  # code was compiled and loaded until here
        nearest, u, solved = math.inf, np.zeros((0, problem.model.nu)), False
        length = left = float(self.restart_after or math.inf)
        truth, restarts, slices = TrueEnds(problem), 0, TimeSlices(budget)
        interleaved = InterleavedSearches(
            [
                GoalConnections(problem, self, seed, budget),
                *self.sub_searches(problem, seed, budget),
            ]
        )
        own_map = problem.scenario.integration.truth == "discrete"  # what was applied is the truth
        improvement = IncumbentImprovement(problem, budget)
        while not improvement.over and (iterations := slices.next(min(left, interleaved.due))):
            ended, made = tree.grow(iterations)
            slices.done(made)
            budget.show(lambda: explored(tree.nodes))
            left -= made
            found = interleaved.advance(made, tree)
            if ended == REACHED:
                found = controls_to(tree.nodes, int(tree.nodes.size[0]) - 1)
            if found is not None and improvement.wants(len(found)):
                if own_map or truth.excess(found) <= 1.0:
                    solved, u = True, found
                    improvement.found(len(u), tree)
                else:
                    left = left if truth.refused % MAX_RESIMULATION_FAILURES else 0.0
            elif ended == FULL or left <= 0:
                nearest, u = (nearest, u) if solved else nearer(tree, nearest, u)
                length *= RESTART_FACTOR
                left, restarts = length, restarts + 1
                tree.begin()
        if not solved:
            nearest, u = nearer(tree, nearest, u)
        statistics = {**truth.statistics, "restarts": float(restarts), **improvement.statistics}
        outcome = result(problem, budget, u, tree.nodes, statistics, solved=solved)
        if solved or budget.interrupted:
            return outcome
        return replace(
            outcome, rejections=rejection_sources(problem, tree.nodes, self.max_steps, budget)
        )


class IncumbentImprovement:
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
        self._until, self._steps, self._pointless = math.inf, UNBOUNDED_STEPS, False
        self.statistics: dict[str, float] = {}

    @property
    def over(self) -> bool:
        """Whether the search has come to its end."""
        return self._pointless or self._clock() >= self._until

    def wants(self, steps: int) -> bool:
        """Say whether a motion of so many steps is shorter than all before."""
        return steps < self._steps

    def found(self, steps: int, tree: AbstractTreeExtension) -> None:
        """Take a motion of so many steps, and have a tree look for shorter ones."""
        if self.statistics:
            self.statistics["improvements"] += 1.0
        else:
            self.statistics = {"first_duration": steps * self._step, "improvements": 0.0}
            self._until = self._clock() + self._seconds
        self._steps = steps
        self._pointless = self.over or not tree.shorten(steps)


class SubSearch(Protocol):
    """A search beside the tree.

    Attributes:
        due: Iterations of the tree until its next turn.
    """

    due: float

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:
        """Return inputs from the start into the goal, where a turn was due and found some."""


class InterleavedSearches:
    """Several searches beside a tree."""

    def __init__(self, members: Sequence[SubSearch]) -> None:
        self._members = members

    @property
    def due(self) -> float:
        """Iterations of the tree until the next turn of any."""
        return min(member.due for member in self._members)

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:
        """Return what any of them found; each one counts all iterations."""
        found = [member.advance(iterations, tree) for member in self._members]
        return next((inputs for inputs in found if inputs is not None), None)


class GoalConnections:
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
        self._problem, self._zoom, self._budget = problem, planner.goal_region_scale, budget
        self._every = self.due = planner.goal_connection_period or math.inf
        self._generator = np.random.default_rng(seed)

    @cached_property
    def _last_step(self) -> SteeredGoalConnection:
        with self._budget.preparing():
            from kinolab.steering.steered_goal_connection import (
                SteeredGoalConnection,  # brings SciPy's optimisers
            )

            return SteeredGoalConnection(self._problem, 1, self._zoom, lambda: self._budget.over)

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:
        """Return inputs from the start into the goal, where an attempt was due and found some."""
        self.due -= iterations
        if self.due > 0:
            return None
        self.due = self._every
        node = int(self._generator.integers(tree.nodes.size[0]))
        x = tree.nodes.x[node]
        if not self._last_step.connect(x.tolist(), self._problem.goal_excess(x)):
            return None
        return np.concatenate([controls_to(tree.nodes, node), self._last_step.inputs])


class TimeSlices:
    """How many iterations to make before the next look at the clock.

    Args:
        budget: Of the search.
    """

    def __init__(self, budget: Budget) -> None:
        self._budget, self._size, self._begun = budget, FIRST_SLICE_ITERATIONS, 0.0

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
        fitting = iterations * SLICE_SECONDS / took
        # Slowly upward: the first iterations of a tree are far quicker than those that follow.
        self._size = int(min(max(fitting, self._size / 4, 1), 2 * self._size, MAX_SLICE_ITERATIONS))


def rows(problem: Problem, u: Array) -> tuple[Array, Array]:
    """Return times (N+1,) and inputs (N, nu) of a motion."""
    return problem.step * np.arange(len(u) + 1.0), u


def nearer(tree: AbstractTreeExtension, nearest: float, u: Array) -> tuple[float, Array]:
    """Return a tree's inputs (steps, nu) to its nearest node to the goal, if nearer than others."""
    if tree.best[1] < nearest:
        return float(tree.best[1]), controls_to(tree.nodes, int(tree.best[0]))
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
    """Return what a search found, inputs of shape (steps, nu), with what was refused by cause."""
    outcome = Outcome.SOLVED
    if not solved:
        outcome = Outcome.APPROXIMATE if len(u) else Outcome.NOT_FOUND
        outcome = Outcome.INTERRUPTED if budget.interrupted else outcome
    named = {"limit": LIMIT, "collision": COLLISION, "equations": EQUATIONS}
    counts = {f"rejected_by_{cause}": float(nodes.rejections[k]) for cause, k in named.items()}
    counts |= {"propagations": float(nodes.rejections[ALL_STEPS]), "nodes": float(nodes.size[0])}
    times, inputs = rows(problem, u)
    return SearchResult(
        outcome, times, inputs, budget.iterations, counts | statistics, graph=explored(nodes)
    )


def explored(nodes: Tree) -> SearchGraph:
    """Return a copy of a tree, thinned where it is large."""
    return SearchGraph.of_tree(lambda kept: nodes.x[kept], nodes.parent[: int(nodes.size[0])])
