"""Calls of a machine's compiled functions from numba kernels, by address.

Addresses are arguments, so that one compilation serves every machine.
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
    """A machine for compiled code: function addresses and parameters."""

    step: int
    step_in_lanes: int  # of LANES states at once; 0 where there is none
    f_in_lanes: int
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
    """Return a problem's machine; the caller must keep the model alive, which owns the code."""
    model = problem.model
    method = problem.scenario.integration.method
    names = [name for name in Machine._fields[4:] if name != "p"]
    # Never empty: the array's address is taken even of a machine without parameters.
    parameters = np.append(model.parameter_vector(), 0.0)
    addresses: dict[str, Any] = {name: model.address(name) for name in names}
    substeps = problem.scenario.integration.substeps
    steps = model.address(f"step_{method}"), *model.in_lanes(method)
    return Machine(*steps, substeps, **addresses, p=parameters)


def _call(builder: Any, address: Any, arguments: list[Any]) -> Any:
    """Emit the call of a C function that returns its status; the last argument is always 0."""
    kinds = [*(argument.type for argument in arguments), ir.IntType(64)]
    function = ir.FunctionType(ir.IntType(32), kinds)
    place = builder.inttoptr(address, function.as_pointer())
    return builder.call(place, [*arguments, ir.Constant(ir.IntType(64), 0)])


def _pointers(builder: Any, addresses: list[Any]) -> list[Any]:
    return [builder.inttoptr(address, ir.IntType(8).as_pointer()) for address in addresses]


def _call_addresses(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
    return _call(builder, arguments[0], _pointers(builder, arguments[1:]))


@intrinsic
def call_step(typing, function, x, u, p, h, out, substeps):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call step(x, u, p, h, out, substeps), h in [s], the others addresses; 0 on success."""
    address = types.int64
    signature = types.int32(address, address, address, address, types.float64, address, address)

    def code(_context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        function, x, u, p, h, out, substeps = arguments
        x, u, p, out = _pointers(builder, [x, u, p, out])
        return _call(builder, function, [x, u, p, h, out, substeps])

    return signature, code


@kernel
def advance(machine, x, u, h, after):  # type: ignore[no-untyped-def]
    """Step by h in [s] from x (nx,) under u (nu,) into ``after``; 0 on success.

    Args:
        machine: ``Machine``.
        x, u: State (nx,) and inputs (nu,).
        h: Step length in [s].
        after: Next state, shape (nx,); written.
    """
    return call_step(
        machine.step, x.ctypes.data, u.ctypes.data, machine.p.ctypes.data, h, after.ctypes.data,
        machine.substeps,
    )  # fmt: skip


@kernel
def advance_in_lanes(machine, x, u, h, after):  # type: ignore[no-untyped-def]
    """Step several states at once; return bits that are set for lanes in which that fails.

    Args:
        machine: ``Machine`` that has a step in lanes.
        x, u: States (nx, LANES) and inputs (nu, LANES).
        h: Step length in [s].
        after: Next states, shape (nx, LANES); written.
    """
    return call_step(
        machine.step_in_lanes, x.ctypes.data, u.ctypes.data, machine.p.ctypes.data, h,
        after.ctypes.data, machine.substeps,
    )  # fmt: skip


@kernel
def derivative_in_lanes(machine, x, u, dx):  # type: ignore[no-untyped-def]
    """Write the derivatives (nx, LANES) of several states (nx, LANES) under inputs (nu, LANES)."""
    p = machine.p.ctypes.data
    call_under(machine.f_in_lanes, x.ctypes.data, u.ctypes.data, p, dx.ctypes.data)


@kernel
def follow(machine, u, h, states):  # type: ignore[no-untyped-def]
    """Roll out inputs (N, nu) in steps of h in [s] from ``states[0]`` into ``states`` (N+1, nx).

    Returns the number of steps before one failed.
    """
    for k in range(u.shape[0]):
        if advance(machine, states[k], u[k], h, states[k + 1]) != 0:
            return k
    return u.shape[0]


def states_under(
    problem: PlanningTask, u: Array, start: Array | None = None, method: str = "", substeps: int = 0
) -> Array:
    """Roll out inputs (N, nu) by the problem's own step map.

    Args:
        u: Inputs, one row per step.
        start: Initial state, shape (nx,); the problem's when left out.
        method, substeps: Of the integrator; the problem's when left out.

    Returns:
        States, shape (N+1, nx); NaN from a failing step on.
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
    return types.int32(address, address, address, address), _call_addresses


@intrinsic
def call_under(typing, function, x, u, p, out):  # type: ignore[no-untyped-def]  # noqa: ARG001
    """Call f(x, u, p, out) or another function of states and inputs; all are addresses."""
    address = types.int64
    return types.int32(address, address, address, address, address), _call_addresses
