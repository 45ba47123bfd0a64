"""The right-hand side and the linearly implicit step for stiff machines, with derivatives.

In the step, with W = 1 - gamma h J, where J = df/dx at the step's beginning,

    W k1 = f(x),  W k2 = f(x + h k1) - 2 k1,  after = x + 3/2 h k1 + 1/2 h k2

so that W dk1 = df + gamma d(h J) k1, and alike for k2. What J changes by along a direction is
taken from central differences of the exact J.

Source: Verwer, Spee, Blom, Hundsdorfer, SIAM J. Sci. Comput. 20(4), 1999, equation (3.1).
"""

from __future__ import annotations

from typing import NamedTuple

from kinolab.dynamics.codegen.integrators import GAMMA
from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.simulation.machine import call_under

FD_STEP = 1e-6  # of an entry of a state, or of inputs
SINGULAR_PIVOT = 1e-300  # the compiled step calls smaller pivots singular, too


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
def factor(A, pivots):  # type: ignore[no-untyped-def]
    """Factor a matrix in place with row pivoting; 0 if it is regular."""
    n, failed = A.shape[0], 0
    for k in range(n):
        row = k
        for i in range(k, n):
            if abs(A[i, k]) > abs(A[row, k]):
                row = i
        pivots[k] = row
        failed |= 0 if abs(A[row, k]) > SINGULAR_PIVOT else 1
        for j in range(n):
            A[k, j], A[row, j] = A[row, j], A[k, j]
        for i in range(k + 1, n):
            A[i, k] /= A[k, k]
            for j in range(k + 1, n):
                A[i, j] -= A[i, k] * A[k, j]
    return failed


@kernel
def substitute(A, pivots, b):  # type: ignore[no-untyped-def]
    """Replace b by what the factored matrix takes to b.

    Source: Golub, Van Loan, Matrix Computations, 4th ed., algorithm 3.4.1.
    """
    n = b.shape[0]
    for k in range(n):
        row = int(pivots[k])
        b[k], b[row] = b[row], b[k]
    for k in range(n):
        for i in range(k + 1, n):
            b[i] -= A[i, k] * b[k]
    for k in range(n - 1, -1, -1):
        b[k] /= A[k, k]
        for i in range(k):
            b[i] -= A[i, k] * b[k]
