"""The machine's compiled functions on buffers made once: a planner's step, and the true one."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

from kinolab.dynamics.codegen.machine_code import STEP, bound
from kinolab.errors import SingularError
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import DivergedError, follow_each


class CompiledStep:
    """One step of the machine, and where it leads.

    Args:
        method: Of integration; that of the problem when left out.

    Attributes:
        x: The state before a step.
        u: The inputs held during it.
        next: The state after it.
        poses: Of the bodies at ``next``, shape (bodies, 12).
        ends: Of the cables at ``next``, shape (cables, 6).
    """

    def __init__(self, problem: PlanningTask, method: str | None = None) -> None:
        model, bodies, cables = problem.model, len(problem.bodies), len(problem.cables)
        self.x: Any = (ctypes.c_double * model.nx)()
        self.next: Any = (ctypes.c_double * model.nx)()
        self.u: Any = (ctypes.c_double * model.nu)()
        self.poses, self.ends = np.zeros((bodies, 12)), np.zeros((cables, 6))
        self._has_cables = cables > 0
        self._model = model  # owns the machine code behind the addresses
        step = f"step_{method or problem.scenario.integration.method}"
        self._step: Callable[..., int] = STEP(model.address(step))
        self._p, u = model.parameter_vector(), self.u
        x, after, held = map(ctypes.addressof, (self.x, self.next, u))
        self._before_step = (x, held, self._p.ctypes.data)
        self._after_step = (after, problem.scenario.integration.substeps, 0)

        def call(name: str, *arrays: Any) -> Callable[[], int]:
            return bound(model.address(name), *arrays)

        self._frames = call("frames", self.next, self._p, self.poses)
        self._cables = call("cables", self.next, self._p, self.ends)

    def step(self, duration: float) -> int:
        """Set ``next`` from ``x`` and ``u``; nonzero where that fails."""
        return self._step(*self._before_step, duration, *self._after_step)

    def frames(self) -> None:
        """Set ``poses`` and ``ends`` from ``next``."""
        self._frames()
        if self._has_cables:
            self._cables()


class ReferenceStep:
    """Where a machine without feedback comes to while its inputs are held.

    It is what [integration] truth says: the problem's own step, or the differential equation,
    whose error is controlled.

    Args:
        problem: Says which truth; whose machine it nearly is.
        parameters: Of the machine as it was built, by name.
    """

    def __init__(self, problem: PlanningTask, parameters: dict[str, float]) -> None:
        self._plant, self._parameters = problem.model.plant, parameters
        self._scales, self._settings = problem.scales, problem.scenario.integration

    def __call__(self, x: Array, held: Array, span: float) -> Array:
        """Return the state after a time.

        Args:
            x: State before it, shape (nx,).
            held: Inputs of the machine, shape (nu,).
            span: How long they are held, in [s].

        Raises:
            DivergedError: If the motion cannot be followed to the end of that time.
        """
        settings, parameters = self._settings, self._parameters
        if settings.truth != "discrete":
            t, one, held = np.array([0.0, span]), x[None], held[None]
            each = follow_each(self._plant, one, t, held, self._scales, parameters=parameters)
            return np.asarray(each[0])
        try:
            after = self._plant.step(
                x, held, span, method=settings.method, substeps=settings.substeps, **parameters
            )
        except SingularError as error:
            raise DivergedError(0.0, str(error)) from error
        if not np.isfinite(after).all():
            raise DivergedError(0.0, "the state is not finite")
        return after
