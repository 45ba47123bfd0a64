"""The default planner: a portfolio of the planners that perform best in our benchmarks."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, ClassVar, final

import numpy as np

from kinolab.concurrency.cancel import CancelledError
from kinolab.concurrency.coroutine import Coroutine
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import WorkClock, charge, counted_work
from kinolab.planners.flat_connect import FlatConnect
from kinolab.planners.kpiece_fast import KPIECEFast
from kinolab.planners.rrt_fast import RRTFast
from kinolab.problem import PlanningTask
from kinolab.problem.machines.standing import standing
from kinolab.search import Budget, Outcome, SearchResult, with_default
from kinolab.search.tree import (
    ITERATION_SECONDS,
    AbstractCompiledPlanner,
    AbstractTreeExtension,
    SearchState,
    SubSearch,
    growth_seconds,
    search_state,
    step_seconds,
)
from kinolab.search.tree.threads import OtherTrees
from kinolab.steering.bounded_curvature import curvature_car

if TYPE_CHECKING:
    from kinolab.trajectory import Trajectory
    from kinolab.trajopt.multistart.kinematic_multistart import KinematicMultistart
    from kinolab.trajopt.multistart.multiple_shooting import Multistart
    from kinolab.trajopt.multistart.velocity_tuning import VelocityTuning

WORK_PER_TURN = 5e-3  # [s] of a guess at least
EVEN_WORK = 0.2  # [s] of the trees, until which they and guesses get the same time
LATER_SHARE = 1 / 2  # of the time of guesses, for trees that have not arrived by then
FLAT_ITERATIONS = 5000  # in flat outputs, before anything else: some milliseconds, too
MEMBERS: tuple[type[AbstractCompiledPlanner], ...] = (KPIECEFast, RRTFast)


@final
@dataclass(frozen=True, kw_only=True)
class Auto(AbstractCompiledPlanner):
    """A portfolio: kpiece_fast and rrt_fast take turns, with guesses of shooting beside them.

    The first solves nearly all our benchmarks; the second is not misled by cells; optimised guesses
    solve machines that swing and fly. For machines whose mechanics switch, which get none, the same
    trees grow with other random numbers on another processor. If the inputs accelerate a rolling
    machine along all that its constraints leave, and they leave few velocities, most guesses are
    motions without masses. Of cars of bounded curvature the shortest curves come first, of machines
    whose inputs accelerate all that can move a motion in their flat outputs.

    Source: Gomes, Selman, Algorithm portfolios, Artificial Intelligence 126(1-2), 2001.
    """

    name: ClassVar[str] = "auto"

    control_samples: int = with_default(4, AbstractCompiledPlanner, "control_samples")
    goal_region_scale: float = with_default(10.0, AbstractCompiledPlanner, "goal_region_scale")
    restart_after: int = with_default(10_000, AbstractCompiledPlanner, "restart_after")
    goal_connection_period: int = with_default(
        2000, AbstractCompiledPlanner, "goal_connection_period"
    )

    def solve(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult:
        """Take a car's shortest curves, or a motion in flat outputs; else grow trees."""
        # Where a motion is known, or was refused, others are wanted.
        first = math.isinf(budget.below) and not budget.refused
        motion = self._curve(problem, seed, budget) if first else None
        if motion is not None:
            return SearchResult(Outcome.SOLVED, motion.t, motion.inputs, budget.iterations)
        found = None if budget.refused else self._flat(problem, seed, budget)
        return found or super().solve(problem, seed, budget)

    def _flat(self, problem: PlanningTask, seed: int, budget: Budget) -> SearchResult | None:
        """Return what is found in flat outputs, by little work; None where that is nothing."""
        with suppress(InputError):  # of a machine that is not flat
            most = budget.iterations + int(min(FLAT_ITERATIONS, budget.left))
            own = replace(
                budget,
                max_iterations=most,
                improve=None,  # all shortcuts: they take less time than any improvement
                cancelled=lambda: budget.interrupted or budget.cancelled(),
            )
            found = FlatConnect().solve(problem, seed, own)
            charge(FlatConnect.work_per_iteration * (own.iterations - budget.iterations))
            budget.started, budget.prepared = own.started, own.prepared  # without compilation
            budget.iterations = own.iterations
            if found.outcome is Outcome.SOLVED:
                return found
        return None

    def _curve(self, problem: PlanningTask, seed: int, budget: Budget) -> Trajectory | None:
        """Return a motion along the curves of a car of bounded curvature, None without one."""
        if (car := curvature_car(problem)) is None:
            return None
        with budget.preparing():
            from kinolab.trajopt.multistart.car_curves import CarCurves  # late: for such cars

            curves = CarCurves(problem, car, np.random.default_rng([seed, 2]), budget.expired)
        return curves.next()

    def beside(self, problem: PlanningTask, seed: int, budget: Budget) -> Sequence[SubSearch]:
        """Return guesses, too, or the same trees with other random numbers where there are none."""
        if not problem.machine.modes:
            return (*super().beside(problem, seed, budget), _Multistart(problem, seed, budget))
        if math.isfinite(budget.below):  # these know of no bound
            return ()

        def make() -> AbstractTreeExtension:
            other = int(np.random.SeedSequence([seed, 1]).generate_state(1, np.uint64)[0])
            return self.extension(problem, search_state(problem, self.goal_region_scale, other))

        return (OtherTrees(problem, make, self.restart_after),)

    def extension(self, problem: PlanningTask, search: SearchState) -> AbstractTreeExtension:
        """Return the tree extension."""
        shared = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return _Portfolio([member(**shared).extension(problem, search) for member in MEMBERS])


class _Multistart:
    """Trajectory optimisation from guesses, in a thread beside the trees.

    Turns of both end by counts, of work and of steps, so that what comes of them does not depend on
    how fast they are, nor on the number of processors.

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
        # tree iterations before the first guess: some milliseconds
        self.due: float = 1 if again and seed % 2 else 4000
        self._problem, self._seed, self._budget = problem, seed, budget
        self._count = 0
        self._guess: Coroutine[Trajectory | None] | None = None
        self._clock, self._paid = WorkClock(), 0.0  # of the guess; until the last turn's end
        self._turn = WORK_PER_TURN  # [s] of work that the guess may do in this turn
        self._iterations = 0
        self._trees_paid = self._trees_due = 0.0  # [s] of trees: for all turns, until the next one
        self._step_seconds = step_seconds(problem)

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

    @cached_property
    def _tuned(self) -> VelocityTuning | None:
        """Guesses by way of the world that stands still; None where nothing moves."""
        if standing(self._problem) is None:
            return None
        with self._budget.preparing():
            from kinolab.trajopt.multistart.velocity_tuning import VelocityTuning

            tuned = VelocityTuning(*self._given)
            tuned.prepare()
            return tuned

    @property
    def _given(self) -> tuple[PlanningTask, int, int, Callable[[], bool], float]:
        budget = self._budget
        return self._problem, 80, self._seed, self._stop, budget.below  # knots of a guess

    def _stop(self) -> bool:
        """End the turn of the guess when it is over; say whether the search is, too."""
        guess = self._guess
        over = self._clock.seconds - self._paid >= self._turn
        ended = guess is not None and (guess.suspend() if over else guess.closed)
        return ended or self._budget.expired()

    def advance(self, iterations: int, tree: AbstractTreeExtension) -> Array | None:
        """End a turn of a guess and begin the next, if due; return inputs (N, nu), or None."""
        self._iterations += iterations
        self.due -= iterations
        if self.due > 0 or self._waits_for(tree):
            return None
        found = None if self._guess is None else self._end_turn(self._guess, tree)
        if found is None:
            self._begin_turn(tree)
        return found

    def _end_turn(
        self, guess: Coroutine[Trajectory | None], tree: AbstractTreeExtension
    ) -> Array | None:
        """Wait for the end of a turn; return the guess's inputs if it leads into the goal."""
        over = guess.wait()
        spent, self._paid = self._clock.seconds - self._paid, self._clock.seconds
        charge(spent)
        self._trees_paid += self._share(tree) * spent
        if not over:
            return None
        self._guess = None
        try:
            motion = guess.result
        except CancelledError:
            return None
        self._count += 1
        return None if motion is None else motion.inputs

    def _begin_turn(self, tree: AbstractTreeExtension) -> None:
        """Let the guess, or the next one, go on beside the trees.

        They are due when the trees have done the work of all turns so far, and of a short one.
        The guess may take as long as that takes them, so that neither waits for the other.
        """
        if self._guess is None:
            self._guess = Coroutine(partial(self._counted, self._next()))
        done = self._work_of(tree)
        self._trees_paid = max(self._trees_paid, done)
        self._trees_due = self._trees_paid + self._share(tree) * WORK_PER_TURN
        self._turn = max(WORK_PER_TURN, self._trees_due - done)
        self._guess.resume()
        self._waits_for(tree)

    def _share(self, tree: AbstractTreeExtension) -> float:
        """Return the work of trees for that of guesses."""
        return 1.0 if self._work_of(tree) <= EVEN_WORK else LATER_SHARE

    def _work_of(self, tree: AbstractTreeExtension) -> float:
        """Return the work of the trees so far in [s]."""
        return growth_seconds(self._step_seconds, tree.steps_made, self._iterations)

    def _waits_for(self, tree: AbstractTreeExtension) -> bool:
        """Say whether the trees are to do more work first, and set when to ask again."""
        done = self._work_of(tree)
        left = self._trees_due - done
        self.due = max(1.0, left * self._iterations / max(done, ITERATION_SECONDS))
        return left > 0

    def close(self) -> None:
        """Give up the guess."""
        if self._guess is not None:
            self._guess.close()

    def _counted(self, guess: Callable[[], Trajectory | None]) -> Trajectory | None:
        with counted_work(apart=True) as clock:
            self._clock, self._paid = clock, 0.0
            return guess()

    def _next(self) -> Callable[[], Trajectory | None]:
        """Return what optimises a guess, prepared.

        Of three, two are by way of the reduction, which take less time; where something moves,
        every other one by way of what stands still.
        """
        if self._count % 3 and self._kinematic is not None:
            return self._kinematic.next
        if self._count % 2 == 0 and self._tuned is not None:
            return self._tuned.next
        return self._multistart.next


class _Portfolio(AbstractTreeExtension):
    """Alternates between trees, one per restart."""

    def __init__(self, trees: Sequence[AbstractTreeExtension]) -> None:
        self._trees, self._turn = trees, -1

    @property
    def steps_made(self) -> int:
        """Steps of the machine that were tried in all trees so far."""
        return sum(tree.steps_made for tree in self._trees)

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

    def close(self) -> None:
        """End what grows the trees."""
        for tree in self._trees:
            tree.close()
