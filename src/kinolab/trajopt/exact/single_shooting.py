"""Single shooting: lead the end of a motion into the goal's centre by its last inputs alone.

Inputs change by the same amount over each of a few blocks of steps, so that a Gauss-Newton step
takes as many simulations as there are changes. Multiple shooting needs derivatives by all states
at all knots instead: of a machine with many states one of its subproblems takes longer than all
that is done here.

Source: Bryson, Ho, Applied Optimal Control, 1975, section 7.3 (neighbouring extremals); Nocedal,
Wright, Numerical Optimization, 2nd ed., section 10.3 (Gauss-Newton).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.work import charge
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import DivergedError, reference_motion, trajectory_under
from kinolab.trajectory import Trajectory
from kinolab.trajopt.nlp.feasibility_check import satisfies_all_at_knots
from kinolab.trajopt.nlp.goal_constraint import GoalConstraint
from kinolab.trajopt.nlp.options import END
from kinolab.trajopt.nlp.problem import TrajectoryProblem


def end_by_single_shooting(
    problem: PlanningTask, trajectory: Trajectory, cancelled: Callable[[], bool]
) -> Trajectory | None:
    """Return a motion that differs only in its last inputs and ends in the goal's centre, or None.

    Limits, requirements and gaps are looked at where steps end; the verifier decides the rest.

    Args:
        problem: The problem that the motion solves.
        trajectory: A motion from the problem's start.
        cancelled: Whether to give up.
    """
    task = TrajectoryProblem(problem, 0.0)
    for steps in END.tail_steps:
        begin = max(len(trajectory.u) - steps, 0)
        t, motion, inputs = trajectory.t[begin:], trajectory.x[begin:], trajectory.inputs[begin:]
        made = _Tail(problem, t, motion, inputs).ended(cancelled)
        if made is not None:
            tail = trajectory_under(problem.model, made.t, made.motion, made.inputs)
            whole = trajectory.with_piece(begin, len(trajectory.u), tail, problem.space)
            if satisfies_all_at_knots(task, whole):
                return whole
        if begin == 0 or cancelled():
            break
    return None


@dataclass(frozen=True, eq=False)
class _Tail:
    """The last part of a motion.

    Attributes:
        problem: The problem.
        t: Times of its knots in [s], shape (N+1,).
        motion: States there, shape (N+1, nx).
        inputs: Shape (N, nu).
    """

    problem: PlanningTask
    t: Array
    motion: Array
    inputs: Array

    def under(self, inputs: Array) -> _Tail | None:
        """Return the tail under other inputs, simulated; None where that stops before the end."""
        charge(END.cost_of_state * len(inputs) * self.problem.model.nx)
        try:
            motion = reference_motion(self.problem, self.motion[0], self.t, inputs, between=False)
        except DivergedError:
            return None
        return replace(self, t=motion.t, motion=motion.x, inputs=inputs)

    def ended(self, cancelled: Callable[[], bool]) -> _Tail | None:
        """Return a tail near this one that ends in the goal's centre."""
        tail = self.under(self.inputs)
        for step in range(END.newton_steps + 1):
            if tail is None or cancelled():
                return None
            missing = tail.missing()
            if np.abs(missing).sum() <= END.goal_tolerance:
                return tail
            if step < END.newton_steps:
                tail = tail.nearer(missing, cancelled)
        return None

    def missing(self) -> Array:
        """Return the scaled goal residual at the end, shape (ng,)."""
        end = self.motion[-1]
        return GoalConstraint(self.problem, end).residual(end)

    def nearer(self, missing: Array, cancelled: Callable[[], bool]) -> _Tail | None:
        """Return the tail after a short Gauss-Newton step within limits, with backtracking."""
        slopes = self._slopes(missing, cancelled)
        if slopes is None:
            return None
        short = END.ridge * np.linalg.norm(slopes) * np.eye(slopes.shape[1])
        change = scipy.optimize.lsq_linear(
            np.vstack([slopes, short]), np.append(-missing, np.zeros(len(short))), self._room()
        ).x
        share = 1.0
        while share >= END.least_share:
            tried = self.under(self._moved(share * change))
            if tried is not None and np.linalg.norm(tried.missing()) < np.linalg.norm(missing):
                return tried
            share /= 2
        return None

    def _slopes(self, missing: Array, cancelled: Callable[[], bool]) -> Array | None:
        """Return derivatives of the goal residual by all changes, shape (ng, blocks nu)."""
        columns, (low, high) = [], self._room()
        for k, unit in enumerate(np.eye(len(low))):
            step = END.fd_step if high[k] > -low[k] else -END.fd_step  # away from the nearer limit
            tried = None if cancelled() else self.under(self._moved(step * unit))
            if tried is None:
                return None
            columns.append((tried.missing() - missing) / step)
        return np.column_stack(columns)

    def _blocks(self) -> NDArray[np.int64]:
        """Return the block of each step, shape (N,)."""
        return np.arange(len(self.inputs), dtype=np.int64) * END.blocks // len(self.inputs)

    def _room(self) -> tuple[Array, Array]:
        """Return by how much each block's inputs may fall and rise, in half ranges."""
        lower, upper = self.problem.model.control_bounds.T
        half, blocks = (upper - lower) / 2, self._blocks()
        rows = [self.inputs[blocks == k] for k in range(END.blocks)]
        low = [((lower - own) / half).max(axis=0, initial=-2.0) for own in rows]
        high = [((upper - own) / half).min(axis=0, initial=2.0) for own in rows]
        # 1e-12 of half an input's range: no room is a little room
        return np.concatenate(low) - 1e-12, np.concatenate(high) + 1e-12

    def _moved(self, change: Array) -> Array:
        """Return inputs that differ by a change (blocks nu,), in half ranges, within limits."""
        lower, upper = self.problem.model.control_bounds.T
        rows = change.reshape(END.blocks, -1) * (upper - lower) / 2
        moved: Array = np.clip(self.inputs + rows[self._blocks()], lower, upper)
        return moved
