"""The last step into the goal, from a state that is near it.

A search brings a machine near its goal, hardly to rest in it with every coordinate right. A flat
machine is steered: it brakes and follows a curve. Otherwise the inputs are held piecewise for
several durations, and least squares on the goal's errors at the end moves them, each error counted
in its tolerance.

Source: Betts, Practical Methods for Optimal Control, 2nd ed., 2010, chapter 4 (direct shooting).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from kinolab.cancel import CancellationToken, CancelledError, raise_if_cancelled
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation import Propagator, ZeroOrderHold
from kinolab.steering.nearest_equilibrium import nearest_equilibrium
from kinolab.steering.steering import Steering

MAX_GOAL_STATES = 2  # states in the goal that a flat machine is steered to
CONTROL_INTERVALS = 8  # for which inputs are held, one after the other
DURATIONS = (1.0, 2.0, 4.0, 8.0)  # durations that are tried, in horizons
TOLERANCE_FRACTION = 0.5  # of the tolerance: what is left covers the integrator's error
MAX_ITERATIONS = 15  # of least squares
CONTROL_WEIGHT = 1e-2  # weight of inputs away from their middle, against errors in tolerances
FD_STEP = 1e-4  # of an input's range, for slopes by differences
MAX_ERROR = 1e9  # tolerances from the goal that count as no more than that
STEPS_PER_CANCELLATION_CHECK = 16  # steps of a motion between two looks at whether to stop


class GoalConnection:
    """Looks for the last motion into the goal.

    Args:
        problem: With the goal.
        steps: Of the shortest motion that is tried.
        propagator: Judges what is found.
        stop: Says that the search must end.
        shoots: Whether a flat machine's motions are looked for by shooting as well, which finds
            shorter ones and takes longer.
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
        self._shoots = shoots or problem.system.flat is None
        self._problem, self._propagator, self._stop = problem, propagator, stop
        self._rollout = ZeroOrderHold(problem)
        self._steering = Steering(problem, stop) if problem.system.flat is not None else None
        self._goals = [] if self._steering is None else _goals(problem, self._steering)
        self._failed: Array | None = None  # where nothing was found, so that it is not tried again
        self._holds = [max(1, round(length * steps / CONTROL_INTERVALS)) for length in DURATIONS]

    def inputs(self, x: Array) -> list[tuple[Array, Array]] | None:
        """Return inputs (nu,) and states (nx,) step by step from x into the goal, or None."""
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
        """Return inputs (pieces, nu) that lead into the goal, as far as obstacles allow."""
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
            # what runs away has squares that are not finite
            errors = np.clip(errors, -MAX_ERROR, MAX_ERROR)
            return np.concatenate([errors, CONTROL_WEIGHT * shares])

        def slopes(shares: Array) -> Array:
            base = residual(shares)
            signs = np.where(shares > 0, -FD_STEP, FD_STEP)
            moved = [residual(shares + step) for step in np.diag(signs)]
            return ((np.array(moved) - base) / signs[:, None]).T

        result = least_squares(
            residual, np.zeros(len(span)), slopes, bounds=(-0.5, 0.5), max_nfev=MAX_ITERATIONS
        )
        reached = end(result.x)
        if reached is None or self._problem.goal_excess(reached) > TOLERANCE_FRACTION:
            return None
        found: Array = (middle + result.x * span).reshape(CONTROL_INTERVALS, model.nu)
        return np.clip(found, *model.control_bounds.T)

    def _judged(self, x: Array, rows: Array) -> list[tuple[Array, Array]] | None:
        """Follow inputs until the goal is reached; None where anything is in the way."""
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
    """Return states at rest in the goal, its middle first."""
    generator, found = np.random.default_rng(0), []
    for k in range(MAX_GOAL_STATES):
        x = problem.sample_goal(generator, 1.0 if k else 1e-9)
        settled = nearest_equilibrium(problem, steering.ways.straightened(x))
        if settled is not None and problem.goal_excess(settled[0]) <= TOLERANCE_FRACTION:
            found.append(settled[0])
    return found


MAX_SHOOTING_STEPS = 20  # steps of the shortest motion that is looked for by shooting


class SteeredGoalConnection:
    """Steers from some of a tree's states into the goal.

    A flat machine is steered from anywhere, others from states near the goal alone: there,
    inputs are looked for by shooting, which goes no way around obstacles.

    Args:
        problem: With the goal.
        every: From how many of the states that could be steered from one is.
        goal_region_scale: What counts as near the goal, in its tolerances.
        stop: Says when looking for motions must end.

    Attributes:
        inputs: That lead into the goal from the state tried last, step by step; empty where none
            were found.
    """

    def __init__(
        self, problem: PlanningTask, every: int, goal_region_scale: float, stop: CancellationToken
    ) -> None:
        self.inputs: list[list[float]] = []
        self._every, self._met = every, 0
        self._within = goal_region_scale if problem.system.flat is None else np.inf
        propagator = Propagator(problem)
        self._arrival = GoalConnection(problem, MAX_SHOOTING_STEPS, propagator, stop, shoots=False)

    def connect(self, values: list[float], excess: float) -> bool:
        """Say whether a state is tried, and a motion into the goal was found.

        Args:
            values: A state that the tree has reached.
            excess: How far outside the goal it is, in tolerances.
        """
        self.inputs = []
        if not 1.0 < excess <= self._within:
            return False
        self._met += 1
        if self._met % self._every:
            return False
        motion = self._arrival.inputs(np.array(values))
        self.inputs = [u.tolist() for u, _ in motion or ()]
        return bool(self.inputs)
