"""Sliding-window shortening: segments of a motion replaced by faster ones between the same states.

Systems are time-invariant, so a segment may be replaced by any other motion between the same two
states; cyclic coordinates, such as how far wheels have rolled, need not match. The run time is
linear in the length of the motion: windows are shifted by half from one sweep to the next, grow
while they succeed, and shrink where inputs held constant for that long fail.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.goal import Goal, PartTarget
from kinolab.problem.time_steps import covering_steps
from kinolab.steering.cyclic_coordinates import cyclic_coordinates
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.decision import Knots, resampled
from kinolab.trajopt.nlp.dynamics_constraint import is_discrete, refined, true_trajectory
from kinolab.trajopt.nlp.feasibility_check import satisfies_all
from kinolab.trajopt.nlp.options import LOOSE, SHORT, SQP
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.sqp.minimum_cost import minimize_cost
from kinolab.trajopt.sqp.restoration import restore_feasibility


class Segments:
    """Faster segments between two states of a motion.

    Args:
        problem: The problem that the whole motion solves.
        clearance: Safety margin of distances on the coarse grid, in machine sizes.
        cancelled: Whether to give up.
        room: The same margin in [m], at least.
        spare: Time in [s] by which a segment may be longer, where its duration is not what it
            costs.

    Attributes:
        task: The trajectory optimisation problem.
        space: The state space.
    """

    def __init__(
        self,
        problem: PlanningTask,
        clearance: float,
        cancelled: Callable[[], bool],
        room: float = 0.0,
        spare: float = 0.0,
    ) -> None:
        self.problem, self.space, self.cancelled = problem, problem.space, cancelled
        self.spare = spare
        self.task = TrajectoryProblem(
            problem,
            clearance,
            room=room,
            fraction=SHORT.segment_limit_fraction,
            near=SHORT.near_gaps,
            cancelled=cancelled,
        )

    def quicker(self, motion: Trajectory, knots: int, *, last: bool) -> Trajectory | None:
        """Return a faster segment near the given one; None if infeasible or the gain is small.

        Args:
            knots: Maximum number of knots.
            last: Whether it ends in the problem's goal.
        """
        task = self._between(motion.x[0], None if last else motion.x[-1])
        count = max(SHORT.min_steps, min(knots, len(motion.u)))
        few = resampled(motion.t, motion.x, motion.inputs, count, self.space)
        lengths = (SHORT.eased[0] * few.h, SHORT.eased[1] * few.h)
        below = (1 - SHORT.min_segment_gain) * self.problem.cost_of(motion)
        return self._made(task, few, lengths, SQP.closure_iterations, below)

    def along(self, guess: Knots, motion: Trajectory, *, last: bool) -> Trajectory | None:
        """Like ``quicker``, but from a guess of another path."""
        task = self._between(motion.x[0], None if last else motion.x[-1])
        lengths = (SHORT.stretch[0] * guess.h, SHORT.stretch[1] * guess.h)
        below = (1 - SHORT.min_segment_gain) * self.problem.cost_of(motion)
        return self._made(
            task, guess, lengths, SHORT.far_iterations, below, penalty=SQP.bold_penalty
        )

    def ended(self, motion: Trajectory) -> Trajectory | None:
        """Return a segment near the last one that ends in the goal, not made faster; or None."""
        task = self._between(motion.x[0], None)
        count = max(SHORT.min_steps, min(SHORT.tail_knots, len(motion.u)))
        few = resampled(motion.t, motion.x, motion.inputs, count, self.space)
        lengths = (SHORT.stretch[0] * few.h, SHORT.stretch[1] * few.h)
        knots = self._closed(task, few, lengths, SHORT.far_iterations)
        return None if knots is None else self._true(task, knots, self._steps(lengths[1], knots.h))

    def _between(self, begin: Array, end: Array | None) -> TrajectoryProblem:
        problem = self.problem
        if end is None:
            return self.task.of(replace(problem, start=begin))
        return self.task.of(segment_problem(problem, begin, end))

    def _made(
        self,
        task: TrajectoryProblem,
        guess: Knots,
        lengths: tuple[float, float],
        iterations: int,
        below: float,
        penalty: float = SQP.violation_penalty,
    ) -> Trajectory | None:
        """Restore feasibility from a guess, minimise cost and re-simulate; None if that fails.

        The result costs less than ``below``.
        """
        knots = self._closed(task, guess, lengths, iterations, penalty)
        if knots is None:
            return None
        times, least = self._steps(lengths[1], knots.h), SHORT.min_segment_duration * knots.h
        price, longest = self.problem.cost_of, knots.h
        if self.problem.cost_entry is not None:
            longest = max(
                min(times * self.problem.step, longest + self.spare / len(knots.u)), longest
            )
        fast = minimize_cost(task, knots, (least, longest), times=times, tolerances=LOOSE)
        times = self._steps(times * self.problem.step, fast.h)
        found = self._true(task, fast, times) if price(fast) < below else None
        return found if found is not None and price(found) < below else None

    def _closed(
        self,
        task: TrajectoryProblem,
        guess: Knots,
        lengths: tuple[float, float],
        iterations: int,
        penalty: float = SQP.violation_penalty,
    ) -> Knots | None:
        """Return feasible knots near a guess; None if that fails or its steps diverge."""
        try:
            with np.errstate(over="raise", invalid="raise"):
                return restore_feasibility(
                    task, guess, iterations=iterations,
                    times=self._times(lengths[1]), lengths=lengths,
                    enough=SQP.closure_tolerance, pace=SQP.min_decrease, penalty=penalty,
                )  # fmt: skip
        except FloatingPointError:
            return None

    def _true(self, task: TrajectoryProblem, knots: Knots, times: int) -> Trajectory | None:
        """Re-simulate knots with each step split into ``times``; None if infeasible.

        Violations between the coarse knots are repaired on the fine grid.
        """
        fine = refined(task.problem, knots, times)
        found = self._kept(task, fine)
        if found is not None:
            return found
        lengths = (fine.h, max(self.problem.step, fine.h))
        mended = restore_feasibility(
            task,
            fine,
            iterations=SQP.closure_iterations,
            lengths=lengths,
            enough=SQP.closure_tolerance,
        )
        return None if mended is None else self._kept(task, mended)

    def _kept(self, task: TrajectoryProblem, knots: Knots) -> Trajectory | None:
        made = true_trajectory(task.problem, knots)
        return made if made is not None and satisfies_all(task, made) else None

    def _steps(self, longest: float, h: float) -> int:
        """Return the number of steps of the problem in a step of length ``h`` in [s].

        With feedback the motion depends on its update times, so there the number is fixed to that
        of the longest step.
        """
        model = self.problem.model
        return self._times(h if model.plant is model else longest)

    def _times(self, h: float) -> int:
        """Return the least number of steps of the problem that cover ``h`` in [s]."""
        return max(1, covering_steps(h, self.problem.step))


def segment_problem(problem: PlanningTask, begin: Array, end: Array) -> PlanningTask:
    """Return the two-point problem between two states, with the same machine and world.

    Args:
        begin: Start state, shape (nx,).
        end: Goal state, shape (nx,).
    """
    model, matters = problem.model, ~cyclic_coordinates(problem)
    for part in model.space.spheres:
        matters[part.own] = False
    met = tuple(np.flatnonzero(matters).tolist())
    parts = tuple(
        PartTarget(part, tuple(end[part.own].tolist()), SHORT.end_tolerance)
        for part in model.space.spheres
    )
    near = SHORT.end_tolerance * problem.scales[list(met)]
    goal = Goal(met, end[list(met)], near, problem.circular[list(met)], parts=parts)
    return replace(problem, start=begin, goal=goal)


def straight(problem: PlanningTask, begin: Array, end: Array) -> Array:
    """Return the shortest straight path between two states, shape (2, nx)."""
    near = problem.space.nearest(begin, end)
    return np.stack([begin, np.where(cyclic_coordinates(problem), begin, near)])


class SlidingWindow:
    """Sweeps a window along a motion, segment by segment."""

    def __init__(self, segments: Segments) -> None:
        self._segments, self._step = segments, segments.problem.step
        self._held, self._sweeps = SHORT.steps_per_knot, 0

    def sweep(self, motion: Trajectory) -> Iterator[Trajectory]:
        """Sweep once; yield a motion with one faster segment, with two, and so on."""
        begin, fraction = 0, 0.5 if self._sweeps % 2 else 1.0
        knots = SHORT.window_knots[min(self._sweeps, len(SHORT.window_knots) - 1)]
        self._sweeps += 1
        while begin < len(motion.u) and not self._segments.cancelled():
            length = fraction * knots * self._held * self._step
            t = motion.t
            end = min(int(np.searchsorted(t, t[begin] + length)), len(t) - 1)
            if t[-1] - t[end] < SHORT.min_remainder * length:
                end = len(t) - 1
            given, last = motion.piece(begin, end), end == len(motion.u)
            segment = self._segments.quicker(given, knots, last=last)
            if segment is not None:
                motion = motion.with_piece(begin, end, segment, self._segments.space)
                yield motion
                begin, fraction = begin + len(segment.u), 1.0
                self._held = min(SHORT.window_growth * self._held, SHORT.max_steps_per_knot)
            elif self._held > SHORT.min_steps_per_knot:
                self._held = max(SHORT.window_shrinkage * self._held, SHORT.min_steps_per_knot)
            else:
                begin, fraction = end, 1.0


def is_long(problem: PlanningTask, trajectory: Trajectory) -> bool:
    """Say whether a motion is long enough to be optimised in segments.

    Discrete ones never are: their step length is fixed, so a segment cannot take slightly less.
    """
    return not is_discrete(problem) and trajectory.duration > SHORT.long_steps * problem.step
