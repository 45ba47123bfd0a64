"""Goal connection: a final motion from a state near the goal into it.

A sampling-based search brings a machine near its goal, but hardly to rest in it with every
coordinate right. A flat machine is steered: it brakes and follows a curve. Otherwise, for several
durations, piecewise-constant inputs are found by nonlinear least squares on the goal errors at the
end, each in its tolerance.

Source: Betts, Practical Methods for Optimal Control, 2nd ed., 2010, chapter 4 (direct shooting).
"""

from __future__ import annotations

import numpy as np
import scipy

from kinolab.concurrency.cancel import CancellationToken, CancelledError, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation import Propagator, ZeroOrderHold
from kinolab.steering.maneuver import STEPS_PER_CANCELLATION_CHECK
from kinolab.steering.nearest_equilibrium import nearest_equilibrium
from kinolab.steering.steering import Steering

CONTROL_INTERVALS = 8  # intervals of constant inputs
DURATIONS = (1.0, 2.0, 4.0, 8.0)  # durations to try, in multiples of the shortest
TOLERANCE_FRACTION = 0.5  # of the tolerance: the rest covers the integration error


class GoalConnection:
    """Finds final motions into the goal.

    Args:
        steps: Length of the shortest motion to try.
        propagator: Checks the motion.
        stop: Cancellation token.
        shoots: Whether to use shooting for flat machines too, which finds shorter motions but takes
            longer.
    """

    def __init__(
        self,
        problem: PlanningTask,
        steps: int,
        propagator: Propagator,
        stop: CancellationToken,
        *,
        shoots: bool = True,
    ) -> None:
        self._shoots = shoots or problem.machine.flat is None
        self._problem, self._propagator, self._stop = problem, propagator, stop
        self._rollout = ZeroOrderHold(problem)
        self._steering = Steering(problem, stop) if problem.machine.flat is not None else None
        self._goals = [] if self._steering is None else _goals(problem, self._steering)
        self._failed: Array | None = None  # last state that failed, not to be retried
        self._holds = [max(1, round(length * steps / CONTROL_INTERVALS)) for length in DURATIONS]

    @property
    def propagations(self) -> int:
        """Steps simulated so far, with those of the propagator."""
        steered = 0 if self._steering is None else self._steering.rollout.propagations
        return self._propagator.propagations + self._rollout.propagations + steered

    def inputs(self, x: Array) -> list[tuple[Array, Array]] | None:
        """Return inputs (nu,) and states (nx,) per step from x (nx,) into the goal, or None."""
        if self._failed is not None and np.array_equal(x, self._failed):
            return None
        found: list[list[tuple[Array, Array]]] = []
        try:
            for path in (self._steered, self._shot):
                motion = path(x)
                found += [] if motion is None else [motion]
        except CancelledError:
            return found[0] if found else None
        if not found:
            self._failed = x
        return min(reversed(found), key=len, default=None)

    def _shot(self, x: Array) -> list[tuple[Array, Array]] | None:
        """Return the shortest motion by shooting, as ``inputs`` does."""
        for hold in dict.fromkeys(self._holds) if self._shoots else ():
            rows = self._shoot(x, hold)
            if rows is not None:
                motion = self._judged(x, np.repeat(rows, hold, axis=0))
                if motion is not None:
                    return motion
        return None

    def _steered(self, x: Array) -> list[tuple[Array, Array]] | None:
        """Return a motion along a flat machine's curves, as ``inputs`` does."""
        if self._steering is None:
            return None
        for goal in self._goals:
            raise_if_cancelled(self._stop)
            for motion in self._steering.steer(x, goal, self._looks_free):
                judged = self._judged(x, motion.u)
                if judged is not None:
                    return judged
                raise_if_cancelled(self._stop)
        return None

    def _looks_free(self, states: Array) -> bool:
        raise_if_cancelled(self._stop)
        return all(self._propagator.is_free(state) for state in states.tolist())

    def _shoot(self, x: Array, hold: int) -> Array | None:
        """Return inputs (intervals, nu) that lead into the goal, ignoring obstacles; or None."""
        model = self._problem.model
        lower, upper = (np.tile(b, CONTROL_INTERVALS) for b in model.control_bounds.T)
        span, middle = upper - lower, (lower + upper) / 2

        def end(shares: Array) -> Array | None:
            raise_if_cancelled(self._stop)
            inputs = (middle + shares * span).reshape(CONTROL_INTERVALS, model.nu)
            return self._rollout.end_of(x, inputs, hold)

        def residual(shares: Array) -> Array:
            reached = end(shares)
            errors = self._problem.goal_residual(x if reached is None else reached)
            # diverged states would have infinite squares
            errors = np.clip(errors, -1e9, 1e9)
            # 1e-2 of inputs' deviation from mid-range, relative to errors in tolerances
            return np.concatenate([errors, 1e-2 * shares])

        def slopes(shares: Array) -> Array:
            base = residual(shares)
            signs = np.where(shares > 0, -1e-4, 1e-4)  # finite difference, of an input's range
            moved = [residual(shares + step) for step in np.diag(signs)]
            return ((np.array(moved) - base) / signs[:, None]).T

        # 15 evaluations of least squares
        result = scipy.optimize.least_squares(
            residual, np.zeros(len(span)), slopes, bounds=(-0.5, 0.5), max_nfev=15
        )
        reached = end(result.x)
        if reached is None or self._problem.goal_excess(reached) > TOLERANCE_FRACTION:
            return None
        found: Array = (middle + result.x * span).reshape(CONTROL_INTERVALS, model.nu)
        return np.clip(found, *model.control_bounds.T)

    def _judged(self, x: Array, rows: Array) -> list[tuple[Array, Array]] | None:
        """Propagate inputs (N, nu); None on a collision or violation, or outside the goal."""
        motion = []
        for k, u in enumerate(rows):
            if k % STEPS_PER_CANCELLATION_CHECK == 0:
                raise_if_cancelled(self._stop)
            reached, free = self._propagator.step(x.tolist(), u.tolist(), self._problem.step)
            if not free:
                return None
            x = np.array(reached)
            motion.append((u, x))
        return motion if self._problem.goal_excess(x) <= 1.0 else None


def _goals(problem: PlanningTask, steering: Steering) -> list[Array]:
    """Return equilibria (nx,) in the goal, its centre first."""
    generator, found = np.random.default_rng(0), []
    for k in range(2):  # goal states that a flat machine is steered to
        x = problem.sample_goal(generator, 1.0 if k else 1e-9)
        settled = nearest_equilibrium(problem, steering.family.straightened(x))
        if settled is not None and problem.goal_excess(settled[0]) <= TOLERANCE_FRACTION:
            found.append(settled[0])
    return found


class SteeredGoalConnection:
    """Goal connections from some of a tree's states.

    A flat machine is steered from anywhere, others only from states near the goal: there inputs are
    found by shooting, which finds no path around obstacles.

    Args:
        every: Try one in this many eligible states.
        goal_region_scale: What counts as near the goal, in its tolerances.
        stop: Cancellation token.

    Attributes:
        inputs: Per step, from the last state tried into the goal; empty if none were found.
    """

    def __init__(
        self, problem: PlanningTask, every: int, goal_region_scale: float, stop: CancellationToken
    ) -> None:
        self.inputs: list[list[float]] = []
        self._every, self._met, self._tried = every, 0, 0
        self._within = goal_region_scale if problem.machine.flat is None else np.inf
        propagator = Propagator(problem)
        # 20 steps of the shortest motion to try by shooting
        self._arrival = GoalConnection(problem, 20, propagator, stop, shoots=False)

    @property
    def propagations(self) -> int:
        """Steps simulated so far."""
        return self._arrival.propagations

    @property
    def statistics(self) -> dict[str, float]:
        """Return the numbers of states that were tried and of steps that this took, by name."""
        return {
            "goal_connections": float(self._tried),
            "goal_connection_propagations": float(self.propagations),
        }

    def connect(self, values: list[float], excess: float) -> bool:
        """Say whether the state was tried and a motion into the goal found.

        Args:
            values: A state that the tree has reached, shape (nx,).
            excess: Its normalised goal error, 1 at the tolerance.
        """
        self.inputs = []
        if not 1.0 < excess <= self._within:
            return False
        self._met += 1
        if self._met % self._every:
            return False
        self._tried += 1
        motion = self._arrival.inputs(np.array(values))
        self.inputs = [u.tolist() for u, _ in motion or ()]
        return bool(self.inputs)
