"""The right-hand side of the equations of motion and its derivative, for compiled code."""

from __future__ import annotations

from kinolab.numerics.jit import kernel
from kinolab.simulation.machine import call_under


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
