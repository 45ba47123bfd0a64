"""Where inputs lead, without a look at obstacles: many short simulations."""

from __future__ import annotations

import ctypes
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.simulation.compiled_step import CompiledStep

Array: TypeAlias = NDArray[np.float64]


class ZeroOrderHold:
    """Simulates a machine in steps of the problem's length."""

    def __init__(self, problem: Problem) -> None:
        self._calls = CompiledStep(problem)
        self._step, self._nx = problem.step, problem.model.nx
        self._bytes = ctypes.sizeof(ctypes.c_double) * self._nx

    def end(self, x: Array, u: Array, steps: int) -> Array | None:
        """Return the state after some steps with inputs (nu,) held; None where that fails."""
        calls = self._calls
        calls.x[:], calls.u[:] = x.tolist(), u.tolist()
        for _ in range(steps):
            if calls.step(self._step):
                return None
            ctypes.memmove(calls.x, calls.next, self._bytes)
        reached = np.array(calls.x)
        return reached if np.isfinite(reached).all() else None

    def end_of(self, x: Array, inputs: Array, steps: int) -> Array | None:
        """Return the state after each row of inputs (rows, nu) was held for some steps."""
        for row in inputs:
            reached = self.end(x, row, steps)
            if reached is None:
                return None
            x = reached
        return x
