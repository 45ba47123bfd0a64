"""A substep of each integrator together with its exact derivative.

The methods are those that ``codegen/integrators`` emits, from the same coefficients. In the
kernels ``step`` is a ``Substep``, states and slopes are ``Dual`` unless a shape is told, and
``scratch`` is a ``StepScratch``.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import allocating_kernel, kernel
from kinolab.numerics.lu import factor, substitute
from kinolab.simulation.machine import call_at, call_under

FD_STEP = 1e-6  # of an entry of a state, or of inputs


class Dual(NamedTuple):
    """Numbers with their derivative by state and inputs before a whole step, and by its length."""

    value: Array  # (n,)
    tangent: Array  # (n, wide), the step's length last


class StepScratch(NamedTuple):
    """Scratch memory of a substep, of whatever method; those before ``first`` serve them all."""

    at: Dual  # of nx numbers
    begin: Dual
    jacobian: Array  # (nx + inputs, nx), of whatever
    first: Array  # the same, at the beginning of the step
    matrix: Array  # (nx, nx), the factors of 1 - gamma h J, or the derivative of the projection
    pivots: Array  # (nx,)
    z: Array  # (nx + inputs,)
    curvature: Array  # (nx, nx + inputs), the derivative of J k
    slopes: Array  # (stages, nx)
    slope_tangents: Array  # (stages, nx, wide)


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
def step_scratch(nx, inputs, wide, stages):  # type: ignore[no-untyped-def]
    """Return a ``StepScratch`` for states, inputs, columns of a derivative, and stages."""
    return StepScratch(
        dual(nx, wide), dual(nx, wide),
        np.empty((nx + inputs, nx)), np.empty((nx + inputs, nx)), np.empty((nx, nx)),
        np.empty(nx), np.empty(nx + inputs), np.empty((nx, nx + inputs)),
        np.empty((stages, nx)), np.empty((stages, nx, wide)),
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
def advance_dual(step, x, scratch):  # type: ignore[no-untyped-def]
    """Make a substep of the method in place; 0 if it worked. Its coefficients say what it is.

    With W = 1 - gamma h J, where J = df/dx at the substep's beginning, a stage solves W k = r, so
    that W dk = dr + gamma d(h J) k.
    """
    code, at, begin, failed = step.code, scratch.at, scratch.begin, 0
    copy(step.derive, x, begin)
    if code.gamma > 0.0:
        failed |= factor_stages(step, x, scratch)
    for i in range(code.b.shape[0]):
        stage = slope_of(scratch, i)
        copy(step.derive, begin, at)
        for j in range(i):
            if code.a[i, j] != 0.0:
                add(step, code.a[i, j], slope_of(scratch, j), at)
        failed |= state_derivative(step, at, stage, scratch.jacobian)
        for j in range(i):
            if code.c[i, j] != 0.0:
                add_beside(step.derive, code.c[i, j], slope_of(scratch, j), stage)
        if code.gamma > 0.0:
            failed |= solve_stage(step, begin, stage, scratch)
        if code.b[i] != 0.0 and not code.geodesic:
            add(step, code.b[i], stage, x)
    if code.geodesic:
        along_geodesics(step, slope_of(scratch, 0), x)
    return failed


@kernel
def along_geodesics(step, k, x):  # type: ignore[no-untyped-def]
    """Set x to x + h k, on spheres to the end of the great circle along k."""
    spheres, begin = step.code.spheres, 0
    for n in range(spheres.shape[0]):
        q, end = spheres[n, 0], spheres[n, 0] + spheres[n, 1]
        add(step, 1.0, part(k, begin, q), part(x, begin, q))
        turn(step, part(k, q, end), part(x, q, end))
        begin = end
    nx = x.value.shape[0]
    add(step, 1.0, part(k, begin, nx), part(x, begin, nx))


@kernel
def part(x, begin, end):  # type: ignore[no-untyped-def]
    """Return a view of some of a ``Dual``'s numbers."""
    return Dual(x.value[begin:end], x.tangent[begin:end])


@kernel
def turn(step, k, q):  # type: ignore[no-untyped-def]
    """Move a unit vector along the great circle of its derivative k: q cos a + h k sin(a)/a.

    Here a = h |k|; all coefficients are functions of a^2, which is smooth at rest too.
    """
    h, wide = step.h, q.tangent.shape[1]
    square = 0.0
    for i in range(q.value.shape[0]):
        square += k.value[i] * k.value[i]
    a2 = h * h * square
    a = math.sqrt(a2)
    cosine = math.cos(a)
    if a2 < 1e-6:  # [rad^2] below which the series of sin(a)/a is exact to rounding
        sinc, dsinc = 1.0 - a2 / 6.0 + a2 * a2 / 120.0, -1.0 / 6.0 + a2 / 60.0
    else:
        sinc = math.sin(a) / a
        dsinc = (cosine - sinc) / (2.0 * a2)  # with respect to a^2
    if step.derive:
        for c in range(wide):
            da2 = 0.0
            for i in range(q.value.shape[0]):
                da2 += 2.0 * h * h * k.value[i] * k.tangent[i, c]
            dh = 0.0
            if c == wide - 1:
                dh = step.fraction
                da2 += 2.0 * h * dh * square
            for i in range(q.value.shape[0]):
                q.tangent[i, c] = (
                    cosine * q.tangent[i, c] - 0.5 * sinc * da2 * q.value[i]
                    + h * sinc * k.tangent[i, c] + (dh * sinc + h * dsinc * da2) * k.value[i]
                )  # fmt: skip
    for i in range(q.value.shape[0]):
        q.value[i] = cosine * q.value[i] + h * sinc * k.value[i]


@kernel
def slope_of(scratch, stage):  # type: ignore[no-untyped-def]
    """Return a stage."""
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
def add_beside(derive, weight, k, stage):  # type: ignore[no-untyped-def]
    """Add a weight times a former stage k to the right-hand side of a stage."""
    for i in range(k.value.shape[0]):
        stage.value[i] += weight * k.value[i]
        if derive:
            for c in range(k.tangent.shape[1]):
                stage.tangent[i, c] += weight * k.tangent[i, c]


@kernel
def factor_stages(step, x, scratch):  # type: ignore[no-untyped-def]
    """Factor 1 - gamma h J at the beginning of a substep; 0 if it worked."""
    code, first = step.code, scratch.first
    failed = call_under(
        code.jacobian, x.value.ctypes.data, step.u.value.ctypes.data, code.p.ctypes.data,
        first.ctypes.data,
    )  # fmt: skip
    for i in range(x.value.shape[0]):
        for j in range(x.value.shape[0]):
            own = 1.0 if i == j else 0.0
            scratch.matrix[i, j] = own - code.gamma * step.h * first[j, i]
    return failed | factor(scratch.matrix, scratch.pivots)


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
            k.tangent[i, c] += step.code.gamma * step.h * change
    share = step.code.gamma * step.fraction
    for i in range(nx):
        for j in range(nx):
            k.tangent[i, wide - 1] += share * scratch.first[j, i] * k.value[j]
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
    """Project a state onto constraints and unit spheres in place."""
    nx, wide = x.tangent.shape
    matrix, product = scratch.matrix, scratch.at.tangent
    before, after = scratch.at.value, scratch.begin.value
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
    before, after = scratch.at.value, scratch.begin.value
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
