"""The default planner: a portfolio of the planners that perform best in our benchmarks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, final

from kinolab.concurrency.cancel import CancelledError
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.planners.kpiece_fast import KPIECEFast
from kinolab.planners.rrt_fast import RRTFast
from kinolab.problem import PlanningTask
from kinolab.search import Budget, with_default
from kinolab.search.tree import (
    AbstractCompiledPlanner,
    AbstractTreeExtension,
    SearchState,
    SubSearch,
)

if TYPE_CHECKING:
    from kinolab.trajopt.multistart.kinematic_multistart import KinematicMultistart
    from kinolab.trajopt.multistart.multiple_shooting import GuessResult, Multistart

GUESS_KNOTS = 80  # knots of a guess
# tree iterations before the first guess: some milliseconds
ITERATIONS_BEFORE_GUESSES = 4000
ITERATIONS_PER_GUESS_STEP = 20.0  # tree iterations per time step of a guess
MEMBERS: tuple[type[AbstractCompiledPlanner], ...] = (KPIECEFast, RRTFast)


@final
@dataclass(frozen=True, kw_only=True)
class Auto(AbstractCompiledPlanner):
    """A portfolio: kpiece_fast and rrt_fast take turns, with guesses of shooting in between.

    The first solves nearly all our benchmarks; the second is not misled by cells; optimised guesses
    solve machines that swing and fly. If the inputs accelerate a rolling machine along all that its
    constraints leave, and they leave few velocities, most guesses are motions without masses.

    Source: Gomes, Selman, Algorithm portfolios, Artificial Intelligence 126(1-2), 2001.
    """

    name: ClassVar[str] = "auto"

    control_samples: int = with_default(4, AbstractCompiledPlanner, "control_samples")
    goal_region_scale: float = with_default(10.0, AbstractCompiledPlanner, "goal_region_scale")
    restart_after: int = with_default(10_000, AbstractCompiledPlanner, "restart_after")
    goal_connection_period: int = with_default(
        5000, AbstractCompiledPlanner, "goal_connection_period"
    )

    def sub_searches(self, problem: PlanningTask, seed: int, budget: Budget) -> Sequence[SubSearch]:
        """Return the multistart search."""
        return [_Multistart(problem, seed, budget)]

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:
        """Return the tree extension."""
        shared = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return _Portfolio([member(**shared).extension(problem, search) for member in MEMBERS])


class _Multistart:
    """Trajectory optimisation from guesses, interleaved with the trees.

    Args:
        problem: The planning problem.
        seed: Random seed.
        budget: Of the search.

    Attributes:
        due: Tree iterations until the next guess.
        statistics: Empty: guesses are not counted.
    """

    statistics: ClassVar[Mapping[str, float]] = {}

    def __init__(self, problem: PlanningTask, seed: int, budget: Budget) -> None:
        again = math.isfinite(budget.below)  # if so, every other search begins with a guess
        self.due: float = 1 if again and seed % 2 else ITERATIONS_BEFORE_GUESSES
        self._problem, self._seed, self._budget = problem, seed, budget
        self._count = 0

    @cached_property
    def _multistart(self) -> Multistart:
        """Guesses for the dynamics."""
        with self._budget.preparing():
            from kinolab.trajopt.multistart.multiple_shooting import Multistart  # late: rarely due

            multistart = Multistart(*self._given)
            multistart.prepare()
            return multistart

    @cached_property
    def _kinematic(self) -> KinematicMultistart | None:
        """Guesses by way of the kinematic reduction; None without one.

        They pay where constraints leave few velocities: with as many as a mobile arm has, motions
        of the reduction take about as long to find, and are followed less often.
        """
        if 2 * self._problem.model.nv > self._problem.model.nq:
            return None
        with self._budget.preparing(), suppress(InputError):
            from kinolab.trajopt.multistart.kinematic_multistart import KinematicMultistart

            multistart = KinematicMultistart(*self._given)
            multistart.prepare()
            return multistart
        return None

    @property
    def _given(self) -> tuple[PlanningTask, int, int, Callable[[], bool], float]:
        budget = self._budget
        return self._problem, GUESS_KNOTS, self._seed, budget.expired, budget.below

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:  # noqa: ARG002
        """Optimise a guess if due; return inputs (N, nu) into the goal, or None."""
        self.due -= iterations
        if self.due > 0:
            return None
        try:
            guess = self._next()
        except CancelledError:
            return None
        self._count += 1
        self.due = ITERATIONS_PER_GUESS_STEP * guess.steps
        return None if guess.motion is None else guess.motion.u

    def _next(self) -> GuessResult:
        """Optimise a guess: of three, two are by way of the reduction, which take less time."""
        if self._count % 3 and self._kinematic is not None:
            return self._kinematic.next()
        return self._multistart.next()


class _Portfolio(AbstractTreeExtension):
    """Alternates between trees, one per restart."""

    def __init__(self, trees: Sequence[AbstractTreeExtension]) -> None:
        self._trees, self._turn = trees, -1

    def begin(self) -> None:
        """Switch to the next tree."""
        if self._turn < 0:
            for tree in self._trees:  # all are compiled before the clock starts
                tree.begin()
                tree.grow(0)
        self._turn += 1
        self._now = self._trees[self._turn % len(self._trees)]
        self._now.begin()
        self.nodes, self.best = self._now.nodes, self._now.best

    def grow(self, iterations: int) -> tuple[int, int]:
        """Grow the current tree for some iterations."""
        return self._now.grow(iterations)
