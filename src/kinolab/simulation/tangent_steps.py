"""A substep of each integrator together with its exact derivative.

The methods are those that ``codegen/integrators`` emits, and one of order 8 for long steps. In the
kernels ``step`` is a ``Substep``, states and slopes are ``Dual`` unless a shape is told, and
``scratch`` is a ``StepScratch``.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from kinolab.dynamics.codegen.integrators import GAMMA
from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import allocating_kernel, kernel
from kinolab.numerics.lu import factor, substitute
from kinolab.simulation.dop853_coefficients import STAGES, A, B
from kinolab.simulation.machine import call_at, call_under

FD_STEP = 1e-6  # of an entry of a state, or of inputs
SMALL_TURN = 1e-6  # [rad^2] below which the series of sin(a)/a is exact to rounding


class Dual(NamedTuple):
    """Numbers with their derivative by state and inputs before a whole step, and by its length."""

    value: Array  # (n,)
    tangent: Array  # (n, wide), the step's length last


class StepScratch(NamedTuple):
    """Scratch memory of a substep, of whatever method; those before ``first`` serve them all."""

    at: Dual  # of nx numbers
    k1: Dual  # of two stages, or of one and of their sum
    k2: Dual
    jacobian: Array  # (nx + inputs, nx), of whatever
    first: Array  # the same, at the beginning of the step
    matrix: Array  # (nx, nx), the factors of W, or the derivative of the projection
    pivots: Array  # (nx,)
    z: Array  # (nx + inputs,)
    curvature: Array  # (nx, nx + inputs), the derivative of J k
    slopes: Array  # (STAGES, nx), of the method of order 8
    slope_tangents: Array  # (STAGES, nx, wide)


class Substep(NamedTuple):
    """A substep but for the state; no scratch, for numba copies all of a tuple at every call."""

    code: Any  # ``StepCode``
    u: Dual  # inputs
    h: float  # its length in [s]
    fraction: float  # of the whole step
    derive: int  # whether tangents are wanted


@allocating_kernel
def dual(n, wide):  # type: ignore[no-untyped-def]
    """Return a ``Dual`` of n numbers, not yet set."""
    return Dual(np.empty(n), np.empty((n, wide)))


@allocating_kernel
def step_scratch(nx, inputs, wide):  # type: ignore[no-untyped-def]
    """Return a ``StepScratch`` for states, inputs and columns of a derivative."""
    return StepScratch(
        dual(nx, wide), dual(nx, wide), dual(nx, wide),
        np.empty((nx + inputs, nx)), np.empty((nx + inputs, nx)), np.empty((nx, nx)),
        np.empty(nx), np.empty(nx + inputs), np.empty((nx, nx + inputs)),
        np.empty((STAGES, nx)), np.empty((STAGES, nx, wide)),
    )  # fmt: skip


@kernel
def state_derivative(step, x, k, jacobian):  # type: ignore[no-untyped-def]
    """Set k to f(x, u), jacobian (nx + inputs, nx) being scratch; 0 if it worked."""
    code, u = step.code, step.u.value
    nx, wide = x.tangent.shape
    p = code.p.ctypes.data
    status = call_under(code.f, x.value.ctypes.data, u.ctypes.data, p, k.value.ctypes.data)
    if not step.derive:
        return status
    status |= call_under(code.jacobian, x.value.ctypes.data, u.ctypes.data, p, jacobian.ctypes.data)
    for i in range(nx):
        for c in range(wide):
            k.tangent[i, c] = 0.0
        for j in range(nx):
            entry = jacobian[j, i]
            if entry != 0.0:
                for c in range(wide):
                    k.tangent[i, c] += entry * x.tangent[j, c]
        for j in range(u.shape[0]):
            entry = jacobian[nx + j, i]
            if code.law == 0:
                k.tangent[i, nx + j] += entry
            elif entry != 0.0:
                for c in range(wide):
                    k.tangent[i, c] += entry * step.u.tangent[j, c]
    return status


@kernel
def euler(step, x, scratch):  # type: ignore[no-untyped-def]
    """Make a substep x + h f(x), on SO(3) along the geodesic, in place; 0 if it worked."""
    k, attitudes = scratch.k1, step.code.attitudes
    failed = state_derivative(step, x, k, scratch.jacobian)
    begin = 0
    for n in range(attitudes.shape[0]):
        q, end = attitudes[n], attitudes[n] + 4
        add(step, 1.0, part(k, begin, q), part(x, begin, q))
        turn(step, part(k, q, end), part(x, q, end))
        begin = end
    nx = x.value.shape[0]
    add(step, 1.0, part(k, begin, nx), part(x, begin, nx))
    return failed


@kernel
def part(x, begin, end):  # type: ignore[no-untyped-def]
    """Return a view of some of a ``Dual``'s numbers."""
    return Dual(x.value[begin:end], x.tangent[begin:end])


@kernel
def turn(step, k, q):  # type: ignore[no-untyped-def]
    """Move a quaternion along the great circle of its derivative k: q cos a + h k sin(a)/a.

    Here a = h |k|; all coefficients are functions of a^2, which is smooth at rest too.
    """
    h, wide = step.h, q.tangent.shape[1]
    square = 0.0
    for i in range(4):
        square += k.value[i] * k.value[i]
    a2 = h * h * square
    a = math.sqrt(a2)
    cosine = math.cos(a)
    if a2 < SMALL_TURN:
        sinc, dsinc = 1.0 - a2 / 6.0 + a2 * a2 / 120.0, -1.0 / 6.0 + a2 / 60.0
    else:
        sinc = math.sin(a) / a
        dsinc = (cosine - sinc) / (2.0 * a2)  # with respect to a^2
    if step.derive:
        for c in range(wide):
            da2 = 0.0
            for i in range(4):
                da2 += 2.0 * h * h * k.value[i] * k.tangent[i, c]
            dh = 0.0
            if c == wide - 1:
                dh = step.fraction
                da2 += 2.0 * h * dh * square
            for i in range(4):
                q.tangent[i, c] = (
                    cosine * q.tangent[i, c] - 0.5 * sinc * da2 * q.value[i]
                    + h * sinc * k.tangent[i, c] + (dh * sinc + h * dsinc * da2) * k.value[i]
                )  # fmt: skip
    for i in range(4):
        q.value[i] = cosine * q.value[i] + h * sinc * k.value[i]


@kernel
def runge_kutta(step, x, scratch):  # type: ignore[no-untyped-def]
    """Make a substep of the classical Runge-Kutta method in place; 0 if it worked."""
    failed, at, k, total = 0, scratch.at, scratch.k1, scratch.k2
    copy(step.derive, x, total)
    for stage in range(4):
        ahead = 0.0 if stage == 0 else (1.0 if stage == 3 else 0.5)
        weight = 1.0 / 6.0 if stage in (0, 3) else 1.0 / 3.0
        copy(step.derive, x, at)
        if stage > 0:
            add(step, ahead, k, at)
        failed |= state_derivative(step, at, k, scratch.jacobian)
        add(step, weight, k, total)
    copy(step.derive, total, x)
    return failed


@kernel
def dormand_prince(step, x, scratch):  # type: ignore[no-untyped-def]
    """Make a substep of the Runge-Kutta method of order 8 in place; 0 if it worked.

    Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.5 (DOP853).
    """
    failed, at = 0, scratch.at
    for stage in range(STAGES):
        copy(step.derive, x, at)
        for before in range(stage):
            if A[stage, before] != 0.0:
                add(step, A[stage, before], slope_of(scratch, before), at)
        failed |= state_derivative(step, at, slope_of(scratch, stage), scratch.jacobian)
    for stage in range(STAGES):
        if B[stage] != 0.0:
            add(step, B[stage], slope_of(scratch, stage), x)
    return failed


@kernel
def slope_of(scratch, stage):  # type: ignore[no-untyped-def]
    """Return a stage's slope, as ``dormand_prince`` keeps it."""
    return Dual(scratch.slopes[stage], scratch.slope_tangents[stage])


@kernel
def copy(derive, x, target):  # type: ignore[no-untyped-def]
    """Copy x to ``target``, with or without its derivative."""
    for i in range(x.value.shape[0]):
        target.value[i] = x.value[i]
        if derive:
            for c in range(x.tangent.shape[1]):
                target.tangent[i, c] = x.tangent[i, c]


@kernel
def add(step, weight, k, x):  # type: ignore[no-untyped-def]
    """Add a weight times h k to x."""
    h, wide = weight * step.h, x.tangent.shape[1]
    for i in range(x.value.shape[0]):
        x.value[i] += h * k.value[i]
        if step.derive:
            for c in range(wide):
                x.tangent[i, c] += h * k.tangent[i, c]
            x.tangent[i, wide - 1] += weight * step.fraction * k.value[i]


@kernel
def rosenbrock(step, x, scratch):  # type: ignore[no-untyped-def]
    """Make a linearly implicit substep, for stiff machines, in place; 0 if it worked.

    With W = 1 - gamma h J, where J = df/dx at the substep's beginning,

        W k1 = f(x),  W k2 = f(x + h k1) - 2 k1,  after = x + 3/2 h k1 + 1/2 h k2

    so that W dk1 = df + gamma d(h J) k1, and alike for k2.

    Source: Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20(4), 1999, equation (3.1).
    """
    code, h = step.code, step.h
    nx, wide = x.tangent.shape
    first, at, k1, k2 = scratch.first, scratch.at, scratch.k1, scratch.k2
    failed = call_under(
        code.jacobian, x.value.ctypes.data, step.u.value.ctypes.data, code.p.ctypes.data,
        first.ctypes.data,
    )  # fmt: skip
    failed |= state_derivative(step, x, k1, scratch.jacobian)
    for i in range(nx):
        for j in range(nx):
            scratch.matrix[i, j] = (1.0 if i == j else 0.0) - GAMMA * h * first[j, i]
    failed |= factor(scratch.matrix, scratch.pivots)
    failed |= solve_stage(step, x, k1, scratch)
    copy(step.derive, x, at)
    add(step, 1.0, k1, at)
    failed |= state_derivative(step, at, k2, scratch.jacobian)
    for i in range(nx):
        k2.value[i] -= 2.0 * k1.value[i]
        if step.derive:
            for c in range(wide):
                k2.tangent[i, c] -= 2.0 * k1.tangent[i, c]
    failed |= solve_stage(step, x, k2, scratch)
    for i in range(nx):
        k2.value[i] = 1.5 * k1.value[i] + 0.5 * k2.value[i]
        if step.derive:
            for c in range(wide):
                k2.tangent[i, c] = 1.5 * k1.tangent[i, c] + 0.5 * k2.tangent[i, c]
    add(step, 1.0, k2, x)
    return failed


@kernel
def solve_stage(step, x, k, scratch):  # type: ignore[no-untyped-def]
    """Replace a stage's right-hand side k by the stage itself, x being where the substep begins.

    Returns 0 if it worked.
    """
    substitute(scratch.matrix, scratch.pivots, k.value)
    if not step.derive:
        return 0
    (nx, wide), bend = x.tangent.shape, scratch.curvature
    failed = jacobian_derivative(step, x.value, k.value, scratch)
    for c in range(wide):
        for i in range(nx):
            change = 0.0
            for j in range(nx):
                change += bend[i, j] * x.tangent[j, c]
            for j in range(step.u.value.shape[0]):
                change += bend[i, nx + j] * step.u.tangent[j, c]
            k.tangent[i, c] += GAMMA * step.h * change
    for i in range(nx):
        for j in range(nx):
            k.tangent[i, wide - 1] += GAMMA * step.fraction * scratch.first[j, i] * k.value[j]
    for c in range(wide):
        substitute(scratch.matrix, scratch.pivots, k.tangent[:, c])
    return failed


@kernel
def jacobian_derivative(step, x, k, scratch):  # type: ignore[no-untyped-def]
    """Set ``curvature`` to the derivative of J(x, u) k by x and u; 0 if it worked.

    By central differences of the exact J, k (nx,) being constant.
    """
    code, jacobian, bend, z = step.code, scratch.jacobian, scratch.curvature, scratch.z
    nx, failed = x.shape[0], 0
    for i in range(nx):
        z[i] = x[i]
    for i in range(step.u.value.shape[0]):
        z[nx + i] = step.u.value[i]
    for j in range(z.shape[0]):
        for i in range(nx):
            bend[i, j] = 0.0
        before, nudge = z[j], FD_STEP * max(1.0, abs(z[j]))
        for sign in (1.0, -1.0):
            z[j] = before + sign * nudge
            failed |= call_under(
                code.jacobian, z[:nx].ctypes.data, z[nx:].ctypes.data, code.p.ctypes.data,
                jacobian.ctypes.data,
            )  # fmt: skip
            for i in range(nx):
                for m in range(nx):
                    bend[i, j] += sign * jacobian[m, i] * k[m] / (2.0 * nudge)
        z[j] = before
    return failed


@kernel
def project(step, x, scratch):  # type: ignore[no-untyped-def]
    """Project a state onto constraints and unit quaternions in place."""
    nx, wide = x.tangent.shape
    matrix, product = scratch.matrix, scratch.k1.tangent
    before, after = scratch.k1.value, scratch.k2.value
    if step.derive:
        projection_jacobian(step.code, x.value, scratch)
        for i in range(nx):
            for c in range(wide):
                product[i, c] = 0.0
            for j in range(nx):
                for c in range(wide):
                    product[i, c] += matrix[i, j] * x.tangent[j, c]
        copy(step.derive, Dual(x.value, product), x)
    for i in range(nx):
        before[i] = x.value[i]
    newton_steps(step.code, before, after)
    for i in range(nx):
        x.value[i] = after[i]


@kernel
def projection_jacobian(code, x, scratch):  # type: ignore[no-untyped-def]
    """Set ``matrix`` to the derivative of the projection at x (nx,), by central differences."""
    nx, matrix = x.shape[0], scratch.matrix
    before, after = scratch.k1.value, scratch.k2.value
    for j in range(code.moving, nx):
        for i in range(nx):
            matrix[i, j] = 1.0 if i == j else 0.0
    for j in range(code.moving):
        h = FD_STEP * max(1.0, abs(x[j]))
        for i in range(nx):
            matrix[i, j] = 0.0
        for sign in (1.0, -1.0):
            for i in range(nx):
                before[i] = x[i]
            before[j] += sign * h
            newton_steps(code, before, after)
            for i in range(nx):
                matrix[i, j] += sign * after[i] / (2.0 * h)


@kernel
def newton_steps(code, x, after):  # type: ignore[no-untyped-def]
    """Move a state x (nx,) onto the constraints, in two Newton steps as the integrators do."""
    p = code.p.ctypes.data
    call_at(code.project, x.ctypes.data, p, after.ctypes.data)
    for i in range(x.shape[0]):
        x[i] = after[i]
    call_at(code.project, x.ctypes.data, p, after.ctypes.data)
