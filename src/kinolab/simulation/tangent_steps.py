"""The right-hand side and the linearly implicit step for stiff machines, with derivatives.

In the step, with W = 1 - gamma h J, where J = df/dx at the step's beginning,

    W k1 = f(x),  W k2 = f(x + h k1) - 2 k1,  after = x + 3/2 h k1 + 1/2 h k2

so that W dk1 = df + gamma d(h J) k1, and alike for k2. What J changes by along a direction is
taken from central differences of the exact J.

Source: Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20(4), 1999, equation (3.1).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from kinolab.dynamics.codegen.integrators import GAMMA
from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.lu import factor, substitute
from kinolab.simulation.machine import call_at, call_under

FD_STEP = 1e-6  # of an entry of a state, or of inputs
SMALL_TURN = 1e-6  # [rad^2] below which the series of sin(a)/a is exact to rounding


class StepScratch(NamedTuple):
    """Scratch memory of a substep, of whatever method; those before ``first`` serve them all."""

    at: Array  # (nx,)
    dat: Array  # (nx, wide)
    k: Array  # (2, nx): of two stages, or of one and of their sum
    dk: Array  # (2, nx, wide)
    jacobian: Array  # (nx + inputs, nx), of whatever
    first: Array  # the same, at the beginning of the step
    matrix: Array  # (nx, nx), the factors of W
    pivots: Array  # (nx,)
    z: Array  # (nx + inputs,)
    bend: Array  # (nx, nx + inputs), the derivative of J k


@kernel
def state_derivative(code, x, dx, u, du, derive, k, dk, jacobian):  # type: ignore[no-untyped-def]
    """Set k to f(x, u), and dk to its derivative along dx and du; 0 if it worked.

    Args:
        code: ``StepCode``.
        x, u: State (nx,) and inputs (inputs,).
        dx, du: Their derivatives, shapes (nx, wide) and (inputs, wide).
        derive: Whether dk is wanted.
        k, dk: Shapes (nx,) and (nx, wide); written.
        jacobian: Scratch, shape (nx + inputs, nx).
    """
    nx, nu = x.shape[0], u.shape[0]
    p = code.p.ctypes.data
    status = call_under(code.f, x.ctypes.data, u.ctypes.data, p, k.ctypes.data)
    if not derive:
        return status
    status |= call_under(code.jacobian, x.ctypes.data, u.ctypes.data, p, jacobian.ctypes.data)
    wide = dx.shape[1]
    for i in range(nx):
        for c in range(wide):
            dk[i, c] = 0.0
        for j in range(nx):
            entry = jacobian[j, i]
            if entry != 0.0:
                for c in range(wide):
                    dk[i, c] += entry * dx[j, c]
        for j in range(nu):
            entry = jacobian[nx + j, i]
            if code.law == 0:
                dk[i, nx + j] += entry
            elif entry != 0.0:
                for c in range(wide):
                    dk[i, c] += entry * du[j, c]
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
def rosenbrock(code, u, du, h, derive, x, dx, scratch):  # type: ignore[no-untyped-def]
    """Make a substep in place; 0 if it worked.

    Args:
        code: ``StepCode``.
        u, du: Inputs (inputs,) and their derivative (inputs, wide).
        h: Of the whole step in [s].
        derive: Whether dx is wanted.
        x, dx: State (nx,) and its derivative (nx, wide); written.
        scratch: ``StepScratch``.
    """
    nx, last = x.shape[0], dx.shape[1] - 1
    fraction = 1.0 / (code.feedback_updates * code.substeps)
    h, p, first = h * fraction, code.p.ctypes.data, scratch.first
    k1, dk1, k2, dk2 = scratch.k[0], scratch.dk[0], scratch.k[1], scratch.dk[1]
    failed = call_under(code.jacobian, x.ctypes.data, u.ctypes.data, p, first.ctypes.data)
    failed |= state_derivative(code, x, dx, u, du, derive, k1, dk1, scratch.jacobian)
    for i in range(nx):
        for j in range(nx):
            scratch.matrix[i, j] = (1.0 if i == j else 0.0) - GAMMA * h * first[j, i]
    failed |= factor(scratch.matrix, scratch.pivots)
    failed |= solve_stage(code, u, du, h, fraction, derive, x, dx, k1, dk1, scratch)
    for i in range(nx):
        scratch.at[i] = x[i] + h * k1[i]
        if derive:
            for c in range(last + 1):
                scratch.dat[i, c] = dx[i, c] + h * dk1[i, c]
            scratch.dat[i, last] += fraction * k1[i]
    failed |= state_derivative(
        code, scratch.at, scratch.dat, u, du, derive, k2, dk2, scratch.jacobian
    )
    for i in range(nx):
        k2[i] -= 2.0 * k1[i]
        if derive:
            for c in range(last + 1):
                dk2[i, c] -= 2.0 * dk1[i, c]
    failed |= solve_stage(code, u, du, h, fraction, derive, x, dx, k2, dk2, scratch)
    for i in range(nx):
        x[i] += h * (1.5 * k1[i] + 0.5 * k2[i])
        if derive:
            for c in range(last + 1):
                dx[i, c] += h * (1.5 * dk1[i, c] + 0.5 * dk2[i, c])
            dx[i, last] += fraction * (1.5 * k1[i] + 0.5 * k2[i])
    return failed


@kernel
def solve_stage(code, u, du, h, fraction, derive, x, dx, k, dk, scratch):  # type: ignore[no-untyped-def]
    """Replace a stage's right-hand side k, and its derivative, by the stage itself; 0 if it worked.

    x and dx are those of the step's beginning.

    Args:
        code, u, du, derive: As ``rosenbrock`` takes them, (inputs,) and (inputs, wide).
        h, fraction: Of the substep in [s], and its share of the step.
        x, dx: Those of the step's beginning, (nx,) and (nx, wide).
        k, dk: The stage and its derivative, (nx,) and (nx, wide); written.
        scratch: ``StepScratch``.
    """
    substitute(scratch.matrix, scratch.pivots, k)
    if not derive:
        return 0
    nx, last = x.shape[0], dx.shape[1] - 1
    failed = bent(code, u, x, k, scratch)
    for c in range(last + 1):
        for i in range(nx):
            change = 0.0
            for j in range(nx):
                change += scratch.bend[i, j] * dx[j, c]
            for j in range(u.shape[0]):
                change += scratch.bend[i, nx + j] * du[j, c]
            dk[i, c] += GAMMA * h * change
    for i in range(nx):
        for j in range(nx):
            dk[i, last] += GAMMA * fraction * scratch.first[j, i] * k[j]
    for c in range(last + 1):
        substitute(scratch.matrix, scratch.pivots, dk[:, c])
    return failed


@kernel
def bent(code, u, x, k, scratch):  # type: ignore[no-untyped-def]
    """Set ``scratch.bend`` to d(J(x, u) k) by x and u for a held k; return 0 if it worked.

    Args:
        code: ``StepCode``.
        u, x: Inputs (inputs,) and state (nx,).
        k: Shape (nx,).
        scratch: ``StepScratch``.
    """
    nx, z, failed = x.shape[0], scratch.z, 0
    for i in range(nx):
        z[i] = x[i]
    for i in range(u.shape[0]):
        z[nx + i] = u[i]
    for j in range(z.shape[0]):
        for i in range(nx):
            scratch.bend[i, j] = 0.0
        before, nudge = z[j], FD_STEP * max(1.0, abs(z[j]))
        for sign in (1.0, -1.0):
            z[j] = before + sign * nudge
            failed |= call_under(
                code.jacobian, z[:nx].ctypes.data, z[nx:].ctypes.data, code.p.ctypes.data,
                scratch.jacobian.ctypes.data,
            )  # fmt: skip
            for i in range(nx):
                for m in range(nx):
                    scratch.bend[i, j] += sign * scratch.jacobian[m, i] * k[m] / (2.0 * nudge)
        z[j] = before
    return failed


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
