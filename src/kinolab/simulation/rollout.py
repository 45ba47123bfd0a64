"""Rollouts of the compiled dynamics: near-exact substeps, or the planner's own steps."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinolab.concurrency.cancel import CancellationToken, never_cancelled, raise_if_cancelled
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.numerics.arrays import Array
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.simulation.compiled_step import CompiledStep
from kinolab.simulation.machine import follow, machine_of
from kinolab.simulation.sensitivities import StepSensitivities

RANDOM_STATES = 10  # at which time constants are computed
STEPS_PER_CANCELLATION_CHECK = 256  # steps between two checks of the token: some milliseconds


class Rollout:
    """Rolls out a machine under zero-order hold, one propagation step per input.

    Args:
        problem: Provides machine and integration settings.
        stop: Cancellation token; raises CancelledError when set.

    Attributes:
        step: Length of a propagation step in [s].
        propagations: Steps made so far.
    """

    def __init__(self, problem: PlanningTask, stop: CancellationToken = never_cancelled) -> None:
        settings, self._stop = problem.scenario.integration, stop
        discrete = settings.truth == "discrete"
        # Euler steps define a discrete-time problem; they approximate no continuous one.
        method = settings.method if discrete else settings.accurate_method
        self._calls = CompiledStep(problem, method)
        self.step, self.propagations = problem.step, 0
        self._pieces = 1 if discrete else _pieces(problem)
        # with two Runge-Kutta steps per propagation step for derivatives
        self._sensitivities = StepSensitivities(problem.model, METHODS[method], self._pieces, 2)

    def follow(self, x0: Array, u: Array) -> Array | None:
        """Return the states at the knots, shape (N+1, nx); None where a step fails.

        Args:
            x0: Initial state, shape (nx,).
            u: Inputs, one row per propagation step, shape (N, nu).
        """
        calls, states = self._calls, np.empty((len(u) + 1, len(x0)))
        states[0] = calls.x[:] = x0.tolist()
        short = self.step / self._pieces
        for k, held in enumerate(u.tolist(), start=1):
            if k % STEPS_PER_CANCELLATION_CHECK == 1:
                raise_if_cancelled(self._stop)
            calls.u[:] = held
            self.propagations += 1
            for _ in range(self._pieces):
                if calls.step(short):
                    return None
                calls.x[:] = calls.next
            states[k] = calls.x
        return states if np.isfinite(states[-1]).all() else None

    def linearise(self, x: Array, u: Array) -> tuple[Array, Array]:
        """Linearise each step: its end state's derivatives by its start state and its inputs.

        Those of two Runge-Kutta steps, also where ``follow`` makes more: enough for a direction.

        Args:
            x: States, shape (N+1, nx).
            u: Inputs, shape (N, nu).

        Returns:
            Shapes (N, nx, nx) and (N, nx, nu).
        """
        nx, nu = x.shape[1], u.shape[1]
        slopes = np.empty((len(u), nx, nx + nu + 1))
        for first in range(0, len(u), STEPS_PER_CANCELLATION_CHECK):
            raise_if_cancelled(self._stop)
            part = slice(first, first + STEPS_PER_CANCELLATION_CHECK)
            after = x[1:][part]
            _, slopes[part] = self._sensitivities.linearized(
                x[:-1][part], u[part], self.step, known=after
            )
        return slopes[:, :, :nx], slopes[:, :, nx : nx + nu]


def _pieces(problem: PlanningTask) -> int:
    """Return the number of Runge-Kutta steps per propagation step."""
    generator, model = np.random.default_rng(0), problem.model
    states = np.array(
        [problem.start, *(problem.sample_goal(generator) for _ in range(RANDOM_STATES))]
    )
    states[1:, model.nq :] *= 0.3
    u = model.null_control()
    A, _ = model.jacobian(states, u)
    fastest = float(np.abs(np.linalg.eigvals(A[np.isfinite(A).all(axis=(1, 2))])).max(initial=0.0))
    # of the fastest time constant: the Runge-Kutta step that errs by some 1e-6 of it
    # Runge-Kutta steps per propagation step
    return int(np.clip(np.ceil(problem.step * fastest / 0.15), 1, 20))


class ZeroOrderHold:
    """Simulates a machine under zero-order hold in propagation steps, without collision checks.

    Attributes:
        propagations: Steps made so far.
    """

    def __init__(self, problem: PlanningTask) -> None:
        self.propagations = 0
        self._model = problem.model  # owns the compiled code
        self._machine, self._step = Record(machine_of(problem)), problem.step

    def end(self, x: Array, u: Array, steps: int) -> Array | None:
        """Return the state after some steps of constant inputs (nu,); None where a step fails."""
        return self.end_of(x, u[None], steps)

    def end_of(self, x: Array, inputs: Array, steps: int) -> Array | None:
        """Return the state after holding each row of inputs (rows, nu) for some steps."""
        held = np.repeat(np.asarray(inputs, dtype=float), steps, axis=0)
        states = np.empty((len(held) + 1, len(x)))
        states[0] = x
        self.propagations += len(held)
        made: int = follow(self._machine, held, self._step, states)
        return states[-1] if made == len(held) and np.isfinite(states[-1]).all() else None


class CandidateRollouts:
    """Rollouts of equal length from one state, one per constant input, without collision checks.

    Args:
        problem: Provides machine and integration settings.
        steps: Propagation steps per rollout.

    Attributes:
        inputs: One per rollout, shape (count, nu); to be set before a call.
        states: Of the rollouts without their start, shape (count, steps, nx).
        propagations: Steps made so far.
    """

    def __init__(self, problem: PlanningTask, count: int, steps: int) -> None:
        model = self._model = problem.model  # owns the compiled code
        self.inputs, self.propagations = np.zeros((count, model.nu)), 0
        self._knots = np.zeros((count, steps + 1, model.nx))
        self.states = self._knots[:, 1:]
        self._machine, self._step = Record(machine_of(problem)), problem.step

    def follow(self, start: Sequence[float], k: int) -> Array:
        """Return the states of rollout k, shape (steps, nx); NaN from a failing step on."""
        self._knots[k, 0] = start
        states: Array = self.states[k]
        held = np.tile(self.inputs[k], (len(states), 1))
        made = follow(self._machine, held, self._step, self._knots[k])
        self.propagations += min(made + 1, len(states))
        states[made:] = np.nan
        return states
