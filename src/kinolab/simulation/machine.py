"""Calls of a machine's functions from compiled code, by their addresses.

Addresses are arguments, so that what is compiled here serves every machine.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask


class Machine(NamedTuple):
    """A machine for compiled code: where its functions are, and its parameters."""

    step: int
    substeps: int
    f: int
    frames: int
    frames_tangent: int
    cables: int
    point_speed: int
    cable_speed: int
    requirements: int
    velocity: int
    p: Array


def machine_of(problem: PlanningTask) -> Machine:
    """Return a problem's machine; whoever keeps it must keep the model too, which owns the code."""
    model = problem.model
    stepper = f"step_{problem.scenario.integration.method}"
    names = [name for name in Machine._fields[2:] if name != "p"]
    # Parameters of a machine without any: an address is asked of the array all the same.
    parameters = np.append(model.parameter_vector(), 0.0)
    addresses: dict[str, Any] = {name: model.address(name) for name in names}
    substeps = problem.scenario.integration.substeps
    return Machine(model.address(stepper), substeps, **addresses, p=parameters)


def _call(builder: Any, address: Any, arguments: list[Any]) -> Any:
    """Emit the call of a C function that returns its status; the last argument is always 0."""
    kinds = [*(argument.type for argument in arguments), ir.IntType(64)]
    function = ir.FunctionType(ir.IntType(32), kinds)
    place = builder.inttoptr(address, function.as_pointer())
    return builder.call(place, [*arguments, ir.Constant(ir.IntType(64), 0)])


def _pointers(builder: Any, addresses: list[Any]) -> list[Any]:
    return [builder.inttoptr(address, ir.IntType(8).as_pointer()) for address in addresses]


@intrinsic
def call_step(typing, function, x, u, p, h, out, substeps):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call step(x, u, p, h, out, substeps), h in [s], the others addresses; 0 if it worked."""
    address = types.int64
    signature = types.int32(address, address, address, address, types.float64, address, address)

    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        function, x, u, p, h, out, substeps = arguments
        x, u, p, out = _pointers(builder, [x, u, p, out])
        return _call(builder, function, [x, u, p, h, out, substeps])

    return signature, code


@kernel
def advance(machine, x, u, h, after):  # type: ignore[no-untyped-def]
    """Make a step of h in [s] from x (nx,) under u (nu,) into ``after``; 0 if it worked.

    Args:
        machine: ``Machine``.
        x, u: State (nx,) and inputs (nu,).
        h: In [s].
        after: The state reached, shape (nx,); written.
    """
    return call_step(
        machine.step, x.ctypes.data, u.ctypes.data, machine.p.ctypes.data, h, after.ctypes.data,
        machine.substeps,
    )  # fmt: skip


@kernel
def follow(machine, u, h, states):  # type: ignore[no-untyped-def]
    """Follow inputs (N, nu) in steps of h in [s] from the first of ``states`` (N+1, nx), written.

    Returns how many steps were made before one failed.
    """
    for k in range(u.shape[0]):
        if advance(machine, states[k], u[k], h, states[k + 1]) != 0:
            return k
    return u.shape[0]


def states_under(
    problem: PlanningTask, u: Array, start: Array | None = None, method: str = "", substeps: int = 0
) -> Array:
    """Return the states (N+1, nx) under inputs (N, nu), by the problem's own map.

    Args:
        problem: With the start.
        u: Inputs, one row per step.
        start: Another start, shape (nx,).
        method, substeps: Of the integrator, where they are not the problem's own.

    Returns:
        States; NaN from a step on that fails.
    """
    machine = machine_of(problem)
    if method:
        step = problem.model.address(f"step_{method}")
        machine = machine._replace(step=step, substeps=substeps)
    states = np.full((len(u) + 1, problem.model.nx), np.nan)
    states[0] = problem.start if start is None else start
    made = follow(Record(machine), np.ascontiguousarray(u, dtype=float), problem.step, states)
    states[made + 1 :] = np.nan
    return states


@intrinsic
def call_at(typing, function, x, p, out):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call frames(x, p, out) or cables(x, p, out); all are addresses."""
    address = types.int64
    signature = types.int32(address, address, address, address)

    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _call(builder, arguments[0], _pointers(builder, arguments[1:]))

    return signature, code


@intrinsic
def call_under(typing, function, x, u, p, out):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call f(x, u, p, out) or another function of states and inputs; all are addresses."""
    address = types.int64
    signature = types.int32(address, address, address, address, address)

    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        return _call(builder, arguments[0], _pointers(builder, arguments[1:]))

    return signature, code
