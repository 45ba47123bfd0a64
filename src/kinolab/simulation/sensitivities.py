"""One knot to the next, and the exact derivative of that: what joins the knots of a trajectory.

The derivative is carried along with the integrator's own stages, so that it belongs to the map that
is used and not to the differential equation that the map approximates. Where the machine has
feedback, its law is evaluated at the beginning of a step and held, as the map itself does; where
a step stands for several ones of the map, at the beginning of each.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from kinolab.concurrency.rows import in_parts
from kinolab.dynamics import Model
from kinolab.dynamics.codegen.methods import Method
from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import allocating_kernel, kernel
from kinolab.numerics.manifolds.state_parts import sphere_table
from kinolab.numerics.struct import Record
from kinolab.simulation.machine import call_under
from kinolab.simulation.tangent_steps import (
    Dual,
    Substep,
    advance_dual,
    dual,
    project,
    step_scratch,
)


class StepCode(NamedTuple):
    """A machine's step for compiled code; f and its derivative are those without feedback."""

    f: int
    jacobian: int
    law: int  # 0 where there is no feedback
    law_jacobian: int
    inputs: int  # how many act
    project: int
    p: Array
    a: Array  # (stages, stages), of the method, as ``Method`` has them
    b: Array  # (stages,)
    c: Array  # (stages, stages)
    gamma: float
    geodesic: int
    feedback_updates: int  # how often the law is asked in a step
    substeps: int  # from one time to the next
    projects: int  # whether a step ends on constraints and unit spheres
    spheres: Integers  # (spheres, 3), as ``sphere_table``
    moving: int  # entries of a state that change smoothly: all but the mode


class StepSensitivities:
    """The states after steps of any length, and their derivatives.

    Args:
        method: Of integration.
        substeps: Of which each step is made, or each part of it after which feedback acts anew.
        derived: Of which it is made for derivatives; fewer are faster and enough for a direction.
        acts: How often feedback acts in a step.
    """

    def __init__(
        self, model: Model, method: Method, substeps: int, derived: int | None = None, acts: int = 1
    ) -> None:
        self._model = model  # owns the code
        self._code = _code(model, method, substeps, acts)
        self._coarse = _code(model, method, derived, acts) if derived else self._code

    @property
    def evaluations(self) -> int:
        """How often a step with derivatives evaluates the equations of motion."""
        code = self._coarse.held
        return int(code.feedback_updates * code.substeps * len(code.b))

    def seconds(self, steps: int, *, derive: bool = True) -> float:
        """Return the work of so many steps in [s], with derivatives or without."""
        evaluated, operations = steps * self.evaluations, self._model.operations
        if derive:
            return evaluated * self._model.nx * (8e-8 + 6e-10 * operations)
        return 1.4e-9 * (evaluated * operations)

    def after(self, x: Array, u: Array, h: float | Array) -> Array:
        """Return where every step leads, shape (N, nx); NaN where it fails.

        Args:
            x: States at the beginning of each step, shape (N, nx).
            u: Inputs, shape (N, nu).
            h: Length of all steps in [s], or of each, shape (N,).
        """
        return self.linearized(x, u, h, derive=False)[0]

    def linearized(
        self,
        x: Array,
        u: Array,
        h: float | Array,
        *,
        derive: bool = True,
        known: Array | None = None,
    ) -> tuple[Array, Array]:
        """Return where every step leads and the derivatives of that.

        Args:
            x: States at the beginning of each step, shape (N, nx).
            u: Inputs, shape (N, nu).
            h: Length of all steps in [s], or of each, shape (N,).
            derive: Whether derivatives are wanted.
            known: Where the steps lead, as ``after`` has returned it, shape (N, nx).

        Returns:
            States, shape (N, nx), and derivatives with respect to x, u and h, shape
            (N, nx, nx + nu + 1).
        """
        count, nx, nu = len(u), self._model.nx, self._model.nu
        after = np.empty((count, nx))
        tangents = np.empty((count if derive else 1, nx, nx + nu + 1))
        before, held = np.ascontiguousarray(x[:count]), np.ascontiguousarray(u)
        spans = np.ascontiguousarray(np.broadcast_to(np.asarray(h, dtype=float), count))

        def work(code: Record, rows: slice, *, derive: bool) -> None:
            slopes = tangents[rows] if derive else np.empty((1, nx, nx + nu + 1))
            linearise(code, before[rows], held[rows], spans[rows], int(derive), after[rows], slopes)

        if derive:
            in_parts(partial(work, self._coarse, derive=True), count, self.seconds(count))
        if known is not None:
            return known, tangents
        if self._coarse is not self._code or not derive:
            seconds = self.seconds(count, derive=False)
            in_parts(partial(work, self._code, derive=False), count, seconds)
        return after, tangents


@lru_cache(maxsize=64)  # each subproblem of a trajectory asks for the same few
def _code(model: Model, method: Method, substeps: int, acts: int) -> Record:
    plant, closed = model.plant, model.plant is not model
    return Record(
        StepCode(
            f=plant.address("f"),
            jacobian=plant.address("jacobian"),
            law=model.address("law") if closed else 0,
            law_jacobian=model.address("law_jacobian") if closed else 0,
            inputs=plant.nu,
            project=model.address("project"),
            p=np.append(model.parameter_vector(), 0.0),
            a=_table(method, method.a),
            b=np.array(method.b),
            c=_table(method, method.c),
            gamma=method.gamma,
            geodesic=int(method.geodesic),
            feedback_updates=acts,
            substeps=substeps,
            projects=int(model.projects),
            spheres=sphere_table(model.space.spheres),
            moving=model.nx - bool(model.machine.modes),
        )
    )


def _table(method: Method, rows: Sequence[Sequence[float]]) -> Array:
    """Return weights of former stages, (stages, stages)."""
    table = np.zeros((method.stages, method.stages))
    for line, row in zip(table, rows, strict=False):
        line[: len(row)] = row
    return table


@allocating_kernel
def linearise(code, x, u, h, derive, after, tangents):  # type: ignore[no-untyped-def]
    """Fill ``after`` and ``tangents`` of all steps; NaN where one fails.

    Args:
        code: ``StepCode``.
        x, u: States (N, nx) and inputs (N, nu) at the beginning of each step.
        h: Lengths of the steps in [s], shape (N,).
        derive: Whether ``tangents`` are wanted.
        after, tangents: Shapes (N, nx) and (N, nx, nx + nu + 1); written.
    """
    nx, wide = x.shape[1], x.shape[1] + u.shape[1] + 1
    inputs, fraction = code.inputs, 1.0 / (code.feedback_updates * code.substeps)
    acting, gains = dual(inputs, wide), np.empty((nx + u.shape[1], inputs))
    scratch = step_scratch(nx, inputs, wide, code.b.shape[0])
    for n in range(x.shape[0]):
        step = Substep(code, acting, h[n] * fraction, fraction, derive)
        state = Dual(after[n], tangents[n if derive else 0])
        for i in range(nx):
            state.value[i] = x[n, i]
        if derive:
            state.tangent[:] = 0.0
            for i in range(nx):
                state.tangent[i, i] = 1.0
        refused = 0
        for part in range(code.feedback_updates * code.substeps):
            if part % code.substeps == 0:
                refused = apply_law(step, state, u[n], gains)
            failed = advance_dual(step, state, scratch)
            if code.projects:
                project(step, state, scratch)
            if failed or refused:
                state.value[:] = math.nan
                state.tangent[:] = 0.0
                break


@kernel
def apply_law(step, x, u, gains):  # type: ignore[no-untyped-def]
    """Set a substep's inputs to those that act from a state x on; 0 if it worked.

    Chosen are u, shape (nu,); gains, shape (nx + nu, inputs), are scratch.
    """
    code, acting, nx = step.code, step.u, x.value.shape[0]
    inputs, wide = acting.tangent.shape
    if step.derive:
        acting.tangent[:] = 0.0
    if code.law == 0:
        for j in range(inputs):
            acting.value[j] = u[j]
            if step.derive:
                acting.tangent[j, nx + j] = 1.0
        return 0
    at, given, p = x.value.ctypes.data, u.ctypes.data, code.p.ctypes.data
    status = call_under(code.law, at, given, p, acting.value.ctypes.data)
    if step.derive:
        status |= call_under(code.law_jacobian, at, given, p, gains.ctypes.data)
        for j in range(inputs):
            for c in range(u.shape[0]):
                acting.tangent[j, nx + c] = gains[nx + c, j]
            for i in range(nx):
                if gains[i, j] != 0.0:
                    for c in range(wide):
                        acting.tangent[j, c] += gains[i, j] * x.tangent[i, c]
    return status
