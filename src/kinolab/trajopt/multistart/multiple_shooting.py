"""Direct multiple shooting from infeasible initial guesses to feasible trajectories.

Guesses differ in duration, turns and path. Each is first solved on a coarse grid, with inputs
constant over several steps of the problem, then with a knot at every step. If open-loop errors
would grow too much along the coarse solution, a faster one is computed first.

Source: Bock, Plitt, A multiple shooting algorithm for direct solution of optimal control problems,
IFAC 1984.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from kinolab.concurrency.cancel import never_cancelled
from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge, counted_work
from kinolab.problem import PlanningTask
from kinolab.problem.machines.kinematic_task import follows_every_path
from kinolab.problem.time_steps import covering_steps
from kinolab.simulation.reference import trajectory_under
from kinolab.trajectory import Trajectory
from kinolab.trajopt.exact.exact import make_exact
from kinolab.trajopt.multistart.geometric_path import GeometricPaths
from kinolab.trajopt.multistart.guesses import Guesses
from kinolab.trajopt.multistart.headings import turned_along, turned_for_requirements
from kinolab.trajopt.multistart.lazy_roadmap import LazyRoadmap, straight_roadmap
from kinolab.trajopt.multistart.rest_to_rest import along_corners
from kinolab.trajopt.nlp.decision import Knots
from kinolab.trajopt.nlp.dynamics_constraint import refined, repeatable
from kinolab.trajopt.nlp.options import GUESS, SQP
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.sqp.minimum_cost import minimize_cost
from kinolab.trajopt.sqp.restoration import restore_feasibility

if TYPE_CHECKING:
    from kinolab.trajopt.multistart.two_trees import TwoTrees


def shoot(
    problem: PlanningTask,
    guess: Knots,
    block: int,
    iterations: int,
    cancelled: Callable[[], bool],
    *,
    hasten: bool = True,
) -> Trajectory | None:
    """Return a feasible trajectory from the start to the goal's centre, or None.

    None, too, if a guess's steps are so long that they diverge.

    Args:
        block: Time steps of the problem per knot interval.
        iterations: Maximum number of subproblems on the coarse grid.
        cancelled: Whether to give up.
        hasten: Whether to look for a faster trajectory where errors grow too much along one.
    """
    if len(guess.u) * block > GUESS.max_guess_steps:
        return None
    try:
        with np.errstate(over="raise", invalid="raise"):
            task = TrajectoryProblem(problem, GUESS.clearance, cancelled=cancelled)
            knots = _closed(task, guess, block, iterations)
            motion = None if knots is None else _step_by_step(task, knots, block)
            if knots and motion and not repeatable(task.problem, motion):
                motion = _faster(task, knots, block) if hasten else None
            if motion is None:
                return None
            return make_exact(problem, motion, cancelled, GUESS.fine_iterations, held=True)
    except FloatingPointError:
        return None


def _closed(task: TrajectoryProblem, guess: Knots, block: int, iterations: int) -> Knots | None:
    """Return nearly feasible knots of the same step length, or None."""
    return restore_feasibility(
        task, guess, iterations=iterations, times=block,
        enough=GUESS.few_knots_tolerance / 10, most=GUESS.few_knots_tolerance,
        pace=SQP.min_decrease,
    )  # fmt: skip


def _step_by_step(task: TrajectoryProblem, knots: Knots, block: int) -> Trajectory:
    fine, model = refined(task.problem, knots, block), task.problem.model
    t = fine.h * np.arange(len(fine.u) + 1.0)
    return trajectory_under(model, t, fine.x, fine.u)


def _faster(task: TrajectoryProblem, knots: Knots, block: int) -> Trajectory | None:
    """Return a faster trajectory with fewer whole steps of the problem per knot, or None."""
    exact = _closed(task, knots, block, GUESS.fine_iterations)
    if exact is None:
        return None
    lengths = (GUESS.min_repeatable * knots.h, knots.h)
    fast = minimize_cost(task, exact, lengths, times=block)
    h = task.problem.step
    block = max(1, math.floor(fast.h / h))
    steps = covering_steps(fast.duration, block * h)
    guess = fast.in_steps(steps, task.problem.space)
    longer = Knots(guess.x, guess.u, block * h)
    found = _closed(task, longer, block, GUESS.fine_iterations)
    return None if found is None else _step_by_step(task, found, block)


# Problems whose code is loaded, and the work in [s] of the guess that did it.
_warmed_up: WeakKeyDictionary[PlanningTask, float] = WeakKeyDictionary()


class Multistart:
    """Multistart over initial guesses that differ in duration, turns and path.

    Args:
        knots: Approximate number of knots of a guess.
        cancelled: Whether to give up.
        below: Duration in [s] of the incumbent solution, if any.
        hasten: As for ``shoot``.
    """

    def __init__(
        self,
        problem: PlanningTask,
        knots: int,
        seed: int,
        cancelled: Callable[[], bool],
        below: float = math.inf,
        *,
        hasten: bool = True,
    ) -> None:
        self._problem, self._knots, self._cancelled = problem, knots, cancelled
        self._hasten = hasten
        self._generator = np.random.default_rng([seed, 1])
        self._guesses = Guesses(problem, self._generator)
        self._geometric_paths = GeometricPaths(problem, self._generator, cancelled)
        self._count, self._below, self._most = 0, below, math.inf
        self._least = 0.0  # [s] for which a path was sought in vain
        self._straight: tuple[Array, bool] | None = None  # where it ends, and whether it is free
        self._roadmap: tuple[Array, LazyRoadmap] | None = None  # where it ends

    def prepare(self) -> None:
        """Warm up: compile and load all that a guess needs, by solving a short one.

        Later searches of the same problem find it there, and are charged for it alike.
        """
        problem, path = self._problem, self._guesses.straight()
        self._geometric_paths.is_free(*path)
        if self._trees is not None:
            self._trees.prepare(path[1])
        if problem in _warmed_up:
            charge(_warmed_up[problem])
            return
        guess = Guesses(problem, np.random.default_rng(0)).knots(
            path, GUESS.min_guess_steps, problem.step
        )
        with counted_work() as work:
            shoot(problem, guess, 1, 1, never_cancelled)
        _warmed_up[problem] = work.seconds

    def next(self) -> Trajectory | None:
        """Solve from the next guess; return a motion to the goal's centre, None if that failed.

        Raises:
            CancelledError: If the path search is cancelled.
        """
        if self._count:  # the first takes the nearest state in the goal
            self._guesses.aim(lambda x: self._geometric_paths.are_free(x[None]))
        self._count += 1
        if self._trees is not None and self._count % 2 == 0:
            return self._between_trees(self._trees)
        guess, block = (self._by_computed_torque(), 1) if self._follows_paths else self._guess()
        if guess is None:
            return None
        patience = GUESS.max_iterations[self._count > len(GUESS.durations)]
        return shoot(self._problem, guess, block, patience, self._cancelled, hasten=self._hasten)

    @cached_property
    def _trees(self) -> TwoTrees | None:
        """Guesses by two trees; None where motions do not run backward.

        Nor where shorter motions than a known one are wanted: trees do not look for these.
        """
        from kinolab.trajopt.multistart.two_trees import (  # late: loads compiled trees
            TwoTrees,
            reversal,
        )

        signs = None if math.isfinite(self._below) else reversal(self._problem)
        if signs is None:
            return None
        return TwoTrees(self._problem, signs, self._generator, self._cancelled)

    def _between_trees(self, trees: TwoTrees) -> Trajectory | None:
        """Return a motion from the guesses of two new trees, None if there is none."""
        end = self._guesses.straight()[1]
        if self._problem.goal_excess(end) > 1.0 or not self._geometric_paths.are_free(end[None]):
            return None
        for guess, block in trees.guesses(end, self._knots):
            patience = GUESS.max_iterations[1]
            motion = shoot(
                self._problem, guess, block, patience, self._cancelled, hasten=self._hasten
            )
            if motion is not None:
                return motion
        return None

    def _guess(self) -> tuple[Knots, int]:
        """Return the next guess and its number of steps of the problem per knot interval."""
        guesses, step = self._guesses, self._problem.step
        longer = GUESS.durations[(self._count - 1) % len(GUESS.durations)]
        longer *= math.exp(self._generator.uniform(-GUESS.duration_jitter, GUESS.duration_jitter))
        self._draw_longest()
        path = turned_along(self._problem, self._path())
        if self._count % 2:  # the turns of the others are the optimiser's
            path = turned_for_requirements(self._problem, path, guesses.quickest)
        quickest = guesses.quickest(path) + guesses.starting
        count = max(covering_steps(longer * quickest, step), GUESS.min_guess_steps)
        block = max(1, round(count / self._knots))
        return guesses.knots(path, math.ceil(count / block), block * step), block

    @cached_property
    def _clear_paths(self) -> GeometricPaths:
        """Paths that keep what the optimisation wants to keep from obstacles."""
        return GeometricPaths(self._problem, self._generator, self._cancelled, GUESS.clearance)

    @cached_property
    def _follows_paths(self) -> bool:
        return follows_every_path(self._problem)

    def _by_computed_torque(self) -> Knots | None:
        """Return a motion along a free path with a stop at each corner; None if there is none."""
        begin, end = self._guesses.straight()
        if self._problem.goal_excess(end) > 1.0:
            return None
        self._draw_longest()
        paths = self._clear_paths
        if not paths.are_free(np.stack([begin, end])):
            paths = self._geometric_paths
        path: Array | None = np.stack([begin, end])
        if not paths.is_free(begin, end):
            path = paths.find(begin, end, 1.0, self._short_enough, GUESS.max_branches[1])
        return None if path is None else along_corners(self._problem, path)

    def _draw_longest(self) -> None:
        """Draw how long a path may take, if there is an incumbent: longer than none was found."""
        if math.isfinite(self._below):
            shortest, longest = self._below * np.asarray(GUESS.shorter)
            self._most = self._generator.uniform(min(max(shortest, self._least), longest), longest)

    def _path(self) -> Array:
        """Return a free path that is short enough, or a random detour; shape (m, nx).

        If the straight path is free most paths need no search.
        """
        begin, end = self._guesses.straight()
        turning = float(self._generator.choice((*GUESS.turning, math.nan), p=GUESS.odds))
        if self._straight is None or not np.array_equal(self._straight[0], end):
            self._straight = end, self._geometric_paths.is_free(begin, end)
        straight = self._straight[1]
        if turning == GUESS.turning[0] or not (straight or math.isnan(turning)):
            short = bool(self._count % 2) and math.isfinite(self._below)
            path = self._shortest_path(begin, end) if short and not straight else None
            if path is not None and self._guesses.quickest(path) < self._below:
                return path
            branches = GUESS.max_branches[math.isfinite(self._below)]
            path = self._geometric_paths.find(begin, end, turning, self._short_enough, branches)
            if path is not None and self._short_enough(path):
                return path
            self._least = max(self._least, self._most)
        return self._guesses.winding()

    def _shortest_path(self, begin: Array, end: Array) -> Array | None:
        """Return the shortest path of a roadmap between two states."""
        problem, paths = self._problem, self._geometric_paths
        if self._roadmap is None or not np.array_equal(self._roadmap[0], end):
            ends, times = np.stack([begin, end]), self._guesses.leg_times
            self._roadmap = end, straight_roadmap(problem, paths, times, ends, self._cancelled)
        path = self._roadmap[1].path()
        return None if path is None else paths.shorter(problem.space.continuous(path))

    def _short_enough(self, paths: Array) -> NDArray[np.bool_]:
        return np.asarray(self._guesses.least_times(paths) <= self._most)
