"""One knot to the next, and the exact derivative of that: what joins the knots of a trajectory.

The derivative is carried along with the integrator's own stages, so that it belongs to the map that
is used and not to the differential equation that the map approximates. Where the machine has
feedback, its law is evaluated at the beginning of a step and held, as the map itself does; where
a step stands for several ones of the map, at the beginning of each.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics import Model
from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import allocating_kernel, kernel
from kinolab.numerics.struct import Record
from kinolab.simulation.machine import call_at, call_under
from kinolab.simulation.rosenbrock import StepScratch, rosenbrock, state_derivative

STAGES = {"euler": 1, "rosenbrock": 2, "rk4": 4}  # by which a method is told in compiled code
FD_STEP = 1e-6  # of a state, for the derivative of the projection onto constraints
SMALL_TURN = 1e-6  # [rad^2] below which the series of sin(a)/a is exact to rounding


class StepCode(NamedTuple):
    """A machine's step for compiled code; f and its derivative are those without feedback."""

    f: int
    jacobian: int
    law: int  # 0 where there is no feedback
    law_jacobian: int
    inputs: int  # how many act
    project: int
    p: Array
    stages: int  # of the method, see STAGES
    feedback_updates: int  # how often the law is asked in a step
    substeps: int  # from one time to the next
    projects: int  # whether a step ends on constraints and unit quaternions
    attitudes: NDArray[np.int64]  # where quaternions begin


class StepSensitivities:
    """The states after steps of any length, and their derivatives.

    Args:
        model: The machine.
        method: Of integration: ``rk4``, ``euler`` or ``rosenbrock``.
        substeps: Of which each step is made, or each part of it after which feedback acts anew.
        derived: Of which it is made for derivatives; fewer are faster and enough for a direction.
        acts: How often feedback acts in a step.
    """

    def __init__(
        self, model: Model, method: str, substeps: int, derived: int | None = None, acts: int = 1
    ) -> None:
        self._model = model  # owns the code
        self._code = _code(model, method, substeps, acts)
        self._coarse = _code(model, method, derived, acts) if derived else self._code

    def after(self, x: Array, u: Array, h: float) -> Array:
        """Return where every step leads, shape (N, nx); NaN where it fails.

        Args:
            x: States at the beginning of each step, shape (N, nx).
            u: Inputs, shape (N, nu).
            h: Length of all steps in [s].
        """
        return self.linearized(x, u, h, derive=False)[0]

    def linearized(
        self, x: Array, u: Array, h: float, *, derive: bool = True
    ) -> tuple[Array, Array]:
        """Return where every step leads and the derivatives of that.

        Returns:
            States, shape (N, nx), and derivatives with respect to x, u and h, shape
            (N, nx, nx + nu + 1).
        """
        count, nx, nu = len(u), self._model.nx, self._model.nu
        after = np.empty((count, nx))
        tangents = np.empty((count if derive else 1, nx, nx + nu + 1))
        before, held = np.ascontiguousarray(x[:count]), np.ascontiguousarray(u)
        if derive:
            linearise(self._coarse, before, held, h, 1, after, tangents)
        if self._coarse is not self._code or not derive:
            linearise(self._code, before, held, h, 0, after, tangents[:1].copy())
        return after, tangents


def _code(model: Model, method: str, substeps: int, acts: int) -> Record:
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
            stages=STAGES[method],
            feedback_updates=acts,
            substeps=substeps,
            projects=int(model.projects),
            attitudes=np.array(list(model.attitudes.values()), dtype=np.int64),
        )
    )


@allocating_kernel
def linearise(code, x, u, h, derive, after, tangents):  # type: ignore[no-untyped-def]
    """Fill ``after`` and ``tangents`` of all steps; NaN where one fails.

    Args:
        code: ``StepCode``.
        x, u: States (N, nx) and inputs (N, nu) at the beginning of each step.
        h: Of each step in [s].
        derive: Whether ``tangents`` are wanted.
        after, tangents: Shapes (N, nx) and (N, nx, nx + nu + 1); written.
    """
    nx, wide = x.shape[1], x.shape[1] + u.shape[1] + 1
    inputs = code.inputs
    acting, dacting = np.empty(inputs), np.empty((inputs, wide))
    gains = np.empty((nx + u.shape[1], inputs))
    side, projection = np.empty((2, nx)), np.empty((nx, nx))
    scratch = StepScratch(
        np.empty(nx), np.empty((nx, wide)), np.empty((2, nx)), np.empty((2, nx, wide)),
        np.empty((nx + inputs, nx)), np.empty((nx + inputs, nx)), np.empty((nx, nx)),
        np.empty(nx), np.empty(nx + inputs), np.empty((nx, nx + inputs)),
    )  # fmt: skip
    for n in range(x.shape[0]):
        state, tangent = after[n], tangents[n if derive else 0]
        tangent[:] = 0.0
        for i in range(nx):
            state[i] = x[n, i]
            tangent[i, i] = 1.0
        refused = 0
        for part in range(code.feedback_updates * code.substeps):
            if part % code.substeps == 0:
                refused = apply_law(code, state, tangent, u[n], derive, acting, dacting, gains)
            if code.stages == 1:
                failed = euler(code, acting, dacting, h, derive, state, tangent, scratch)
            elif code.stages == 2:
                failed = rosenbrock(code, acting, dacting, h, derive, state, tangent, scratch)
            else:
                failed = runge_kutta(code, acting, dacting, h, derive, state, tangent, scratch)
            failed |= refused
            if code.projects:
                land(code, derive, state, tangent, side, projection, scratch.dk[0])
            if failed:
                state[:] = math.nan
                tangent[:] = 0.0
                break


@kernel
def apply_law(code, x, dx, u, derive, acting, dacting, gains):  # type: ignore[no-untyped-def]
    """Set the inputs that act from a state on, and their derivative; 0 if it worked.

    Args:
        code: ``StepCode``.
        x, dx: State (nx,) and its derivative (nx, wide).
        u: What is chosen, shape (nu,).
        derive: Whether ``dacting`` is wanted.
        acting, dacting: Inputs (inputs,) and their derivative (inputs, wide); written.
        gains: Scratch, shape (nx + nu, inputs).
    """
    nx, chosen, inputs = x.shape[0], u.shape[0], acting.shape[0]
    for j in range(inputs):
        for c in range(dacting.shape[1]):
            dacting[j, c] = 0.0
    if code.law == 0:
        for j in range(inputs):
            acting[j] = u[j]
            dacting[j, nx + j] = 1.0
        return 0
    p = code.p.ctypes.data
    status = call_under(code.law, x.ctypes.data, u.ctypes.data, p, acting.ctypes.data)
    if derive:
        status |= call_under(code.law_jacobian, x.ctypes.data, u.ctypes.data, p, gains.ctypes.data)
        for j in range(inputs):
            for c in range(chosen):
                dacting[j, nx + c] = gains[nx + c, j]
            for i in range(nx):
                if gains[i, j] != 0.0:
                    for c in range(dx.shape[1]):
                        dacting[j, c] += gains[i, j] * dx[i, c]
    return status


@kernel
def euler(code, u, du, h, derive, x, dx, scratch):  # type: ignore[no-untyped-def]
    """Make a substep x + h f(x), on SO(3) along the geodesic, in place.

    Args:
        code, u, du, h, derive: As ``rosenbrock`` takes them.
        x, dx: State (nx,) and its derivative (nx, wide); written.
        scratch: ``StepScratch``.
    """
    nx, wide = dx.shape
    k, dk = scratch.k[0], scratch.dk[0]
    fraction = 1.0 / (code.feedback_updates * code.substeps)
    h = h * fraction
    failed = state_derivative(code, x, dx, u, du, derive, k, dk, scratch.jacobian)
    first, turns = 0, code.attitudes.shape[0]
    i = 0
    while i < nx:
        if first < turns and i == code.attitudes[first]:
            turn(i, h, fraction, derive, x, dx, k, dk)
            first, i = first + 1, i + 4
            continue
        x[i] += h * k[i]
        if derive:
            for c in range(wide):
                dx[i, c] += h * dk[i, c]
            dx[i, wide - 1] += fraction * k[i]
        i += 1
    return failed


@kernel
def turn(first, h, fraction, derive, x, dx, k, dk):  # type: ignore[no-untyped-def]
    """Move a quaternion along the great circle of its derivative: q cos a + h q_dot sin(a)/a.

    Here a = h |q_dot|; all coefficients are functions of a^2, which is smooth at rest too.

    Args:
        first: Where the quaternion begins.
        h, fraction: Of the substep in [s], and its share of the step.
        derive: Whether dx is wanted.
        x, dx: State (nx,) and its derivative (nx, wide); written.
        k, dk: The slope (nx,) and its derivative (nx, wide).
    """
    wide = dx.shape[1]
    square = 0.0
    for i in range(first, first + 4):
        square += k[i] * k[i]
    a2 = h * h * square
    a = math.sqrt(a2)
    cosine = math.cos(a)
    if a2 < SMALL_TURN:
        sinc, bend = 1.0 - a2 / 6.0 + a2 * a2 / 120.0, -1.0 / 6.0 + a2 / 60.0
    else:
        sinc = math.sin(a) / a
        bend = (cosine - sinc) / (2.0 * a2)  # of sinc with respect to a^2
    if derive:
        for c in range(wide):
            da2 = 0.0
            for i in range(first, first + 4):
                da2 += 2.0 * h * h * k[i] * dk[i, c]
            dh = 0.0
            if c == wide - 1:
                dh = fraction
                da2 += 2.0 * h * fraction * square
            for i in range(first, first + 4):
                dx[i, c] = (
                    cosine * dx[i, c] - 0.5 * sinc * da2 * x[i]
                    + h * sinc * dk[i, c] + (dh * sinc + h * bend * da2) * k[i]
                )  # fmt: skip
    for i in range(first, first + 4):
        x[i] = cosine * x[i] + h * sinc * k[i]


@kernel
def runge_kutta(code, u, du, h, derive, x, dx, scratch):  # type: ignore[no-untyped-def]
    """Make a substep of the classical Runge-Kutta method in place.

    Args:
        code, u, du, h, derive: As ``rosenbrock`` takes them.
        x, dx: State (nx,) and its derivative (nx, wide); written.
        scratch: ``StepScratch``.
    """
    fraction = 1.0 / (code.feedback_updates * code.substeps)
    h, failed = h * fraction, 0
    at, dat, k, dk = scratch.at, scratch.dat, scratch.k[0], scratch.dk[0]
    total, dtotal = scratch.k[1], scratch.dk[1]
    copy(x, dx, derive, total, dtotal)
    for stage in range(4):
        ahead = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        copy(x, dx, derive, at, dat)
        if stage > 0:
            add(ahead * h, ahead * fraction, k, dk, derive, at, dat)
        failed |= state_derivative(code, at, dat, u, du, derive, k, dk, scratch.jacobian)
        add(weight * h, weight * fraction, k, dk, derive, total, dtotal)
    copy(total, dtotal, derive, x, dx)
    return failed


@kernel
def copy(x, dx, derive, target, dtarget):  # type: ignore[no-untyped-def]
    """Copy a state and its derivative.

    Args:
        x, dx: State (nx,) and its derivative (nx, wide).
        derive: Whether the derivative is copied.
        target, dtarget: The same; written: (nx,) and (nx, wide).
    """
    for i in range(x.shape[0]):
        target[i] = x[i]
        if derive:
            for c in range(dx.shape[1]):
                dtarget[i, c] = dx[i, c]


@kernel
def add(h, fraction, k, dk, derive, x, dx):  # type: ignore[no-untyped-def]
    """Add h k to a state, where ``fraction`` is the derivative of h with respect to the step.

    Args:
        h, fraction: In [s], and its derivative.
        k, dk: The slope (nx,) and its derivative (nx, wide).
        derive: Whether dx is wanted.
        x, dx: State (nx,) and its derivative (nx, wide); written.
    """
    wide = dx.shape[1]
    for i in range(x.shape[0]):
        x[i] += h * k[i]
        if derive:
            for c in range(wide):
                dx[i, c] += h * dk[i, c]
            dx[i, wide - 1] += fraction * k[i]


@kernel
def projected(code, x, target):  # type: ignore[no-untyped-def]
    """Move a state onto the constraints, in two Newton steps as the integrators do."""
    p = code.p.ctypes.data
    call_at(code.project, x.ctypes.data, p, target.ctypes.data)
    for i in range(x.shape[0]):
        x[i] = target[i]
    call_at(code.project, x.ctypes.data, p, target.ctypes.data)


@kernel
def land(code, derive, x, dx, side, projection, product):  # type: ignore[no-untyped-def]
    """Project a state in place, and its derivative with it.

    Args:
        code: ``StepCode``.
        derive: Whether dx is wanted.
        x, dx: State (nx,) and its derivative (nx, wide); written.
        side, projection, product: Scratch, shapes (2, nx), (nx, nx) and (nx, wide).
    """
    nx, wide = dx.shape
    if derive:
        projection_at(code, x, side, projection)
        for i in range(nx):
            for c in range(wide):
                product[i, c] = 0.0
            for j in range(nx):
                for c in range(wide):
                    product[i, c] += projection[i, j] * dx[j, c]
        copy(x, product, 1, x, dx)
    for i in range(nx):
        side[0, i] = x[i]
    projected(code, side[0], side[1])
    for i in range(nx):
        x[i] = side[1, i]


@kernel
def projection_at(code, x, side, projection):  # type: ignore[no-untyped-def]
    """Write the derivative (nx, nx) of the projection, by central differences."""
    nx = x.shape[0]
    for j in range(nx):
        h = FD_STEP * max(1.0, abs(x[j]))
        for i in range(nx):
            projection[i, j] = 0.0
        for sign in (1.0, -1.0):
            for i in range(nx):
                side[0, i] = x[i]
            side[0, j] += sign * h
            projected(code, side[0], side[1])
            for i in range(nx):
                projection[i, j] += sign * side[1, i] / (2.0 * h)
