"""One step of the true motion of a machine as it was built, fast enough for thousands of them."""

from __future__ import annotations

import ctypes
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kinolab.problem import Problem
from kinolab.simulation.compiled_step import POINTER, function
from kinolab.simulation.reference import DivergedError, interval

Array: TypeAlias = NDArray[np.float64]

REFERENCE_TOLERANCE = 1e-9  # of a state's scale: how well two lengths of compiled steps must agree
MAX_HALVED_SUBSTEPS = 512  # beyond it the motion is followed as the verifier does


class ReferenceStep:
    """Where a machine without feedback comes to while its inputs are held.

    It is what [integration] truth says: the problem's own step, or the differential equation,
    whose error is controlled. That one is followed by compiled Runge-Kutta steps, halved until two
    lengths of them agree, for SciPy takes about twenty times as long.

    Args:
        problem: Says which truth; whose machine it nearly is.
        parameters: Of the machine as it was built, by name.

    Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.4 (step doubling).
    """

    def __init__(self, problem: Problem, parameters: dict[str, float]) -> None:
        self._plant, self._parameters = problem.model.plant, parameters
        self._scales, settings = problem.scales, problem.scenario.integration
        self._own = settings.substeps if settings.truth == "discrete" else None
        self._start, self._held = np.empty(self._plant.nx), np.empty(self._plant.nu)
        self._p = self._plant.parameter_vector(**parameters)
        types = (POINTER, POINTER, POINTER, ctypes.c_double, POINTER, ctypes.c_int64)
        method = "rk4" if self._own is None else settings.method
        self._step = function(self._plant, f"step_{method}", *types)
        self._substeps = 1  # of the longer steps that agreed last

    def __call__(self, x: Array, held: Array, span: float) -> Array:
        """Return the state after a time.

        Args:
            x: State before it, shape (nx,).
            held: Inputs of the machine, shape (nu,).
            span: How long they are held, in [s].

        Raises:
            DivergedError: If the motion cannot be followed to the end of that time.
        """
        self._start[:], self._held[:] = x, held
        if self._own is None:
            return self._controlled(span)
        after = self._made(span, self._own)
        if not np.isfinite(after).all():
            raise DivergedError(0.0, "a step fails, or its result is not finite")
        return after

    def _controlled(self, span: float) -> Array:
        """Return where steps lead that are short enough; the next ones begin at half as many."""
        substeps = max(1, self._substeps // 2)
        coarse = self._made(span, substeps)
        while substeps < MAX_HALVED_SUBSTEPS:
            fine = self._made(span, 2 * substeps)
            with np.errstate(over="ignore", invalid="ignore"):  # long steps may run away
                apart = np.abs((fine - coarse) / self._scales).max(initial=0.0)
            if apart <= REFERENCE_TOLERANCE:
                self._substeps = substeps
                return fine
            substeps, coarse = 2 * substeps, fine
        self._substeps = MAX_HALVED_SUBSTEPS
        x, held = self._start.copy(), self._held.copy()
        return interval(
            self._plant, x, (0.0, span), held, self._scales, between=False, **self._parameters
        )[0]

    def _made(self, span: float, substeps: int) -> Array:
        """Return where so many steps lead, shape (nx,); NaN where one fails."""
        after = np.empty_like(self._start)
        pointers = (table.ctypes.data for table in (self._start, self._held, self._p))
        failed = self._step(*pointers, span, after.ctypes.data, substeps, 0)
        return np.full_like(after, np.nan) if failed else after
