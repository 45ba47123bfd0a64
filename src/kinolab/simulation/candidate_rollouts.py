"""Where a machine would go under several inputs, without a look at obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.simulation.compiled_step import stepper

Array: TypeAlias = NDArray[np.float64]


class CandidateRollouts:
    """Motions of equal length from one state, each under an input that is held.

    Args:
        problem: Whose machine moves.
        count: How many motions.
        steps: Propagation steps of each.

    Attributes:
        inputs: One per motion, shape (count, nu); set them before a call.
        states: Of the motions, their start left out, shape (count, steps, nx).
    """

    def __init__(self, problem: Problem, count: int, steps: int) -> None:
        model, h, substeps = problem.model, problem.step, problem.scenario.integration.substeps
        self.inputs = np.zeros((count, model.nu))
        self._knots = np.zeros((count, steps + 1, model.nx))
        self.states = self._knots[:, 1:]
        self._model, self._p = model, model.parameter_vector()  # kept: addresses point into them
        self._step = stepper(problem)
        p = self._p.ctypes.data
        self._calls = [
            [
                (row[j].ctypes.data, u.ctypes.data, p, h, row[j + 1].ctypes.data, substeps, 0)
                for j in range(steps)
            ]
            for row, u in zip(self._knots, self.inputs, strict=True)
        ]

    def follow(self, start: Sequence[float], k: int) -> Array:
        """Return the states of one motion, shape (steps, nx); NaN from a step that fails."""
        self._knots[k, 0] = start
        for j, arguments in enumerate(self._calls[k]):
            if self._step(*arguments):
                self.states[k, j:] = np.nan
                break
        states: Array = self.states[k]
        return states
