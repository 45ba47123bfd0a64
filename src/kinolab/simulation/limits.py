"""Limits of a state and of a step: of state and rates, requirements and keep-out cones."""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array, Integers, allocate
from kinolab.numerics.jit import kernel
from kinolab.problem import PlanningTask
from kinolab.problem.goal_kernel import axis_angle, carried
from kinolab.simulation.collision_context import SAFETY_FACTOR, place_machine
from kinolab.simulation.machine import advance, call_under

REQUIREMENT_SAMPLES = 4  # of what a machine demands, along a step
KEPT = -1  # index where no limit is violated


class LimitArrays(NamedTuple):
    """Limits of a problem and scratch memory, for compiled kernels."""

    lower: Array  # (nx,) of the state
    upper: Array  # (nx,)
    rate_lower: Array  # (nt,) of all rates, or (0,) if none is limited
    rate_upper: Array  # (nt,)
    body: Integers  # (cones,) body whose axis must stay outside
    axis: Array  # (cones, 3) in the body frame
    direction: Array  # (cones, 3) of the cone, in the world frame
    half_angle: Array  # (cones,) in [rad]
    requirements: int  # number of requirements
    still: Annotated[Array, "nu"]  # zero inputs, for which rates are evaluated
    rates: Annotated[Array, "rates"]  # scratch
    margins: Annotated[Array, "margins"]  # scratch
    slope: Annotated[Array, 2, "nx"]  # scratch
    beside: Annotated[Array, "nx"]  # scratch


def limit_arrays(problem: PlanningTask) -> LimitArrays:
    """Collect a problem's limits."""
    model, cones = problem.model, problem.keep_outs
    rates = problem.rate_bounds if np.isfinite(problem.rate_bounds).any() else np.zeros((0, 2))
    requirements = len(problem.machine.requirements)
    sizes = {"nx": model.nx, "nu": model.nu}
    sizes |= {"rates": max(model.nt, 1), "margins": max(requirements, 1)}
    return allocate(
        LimitArrays,
        sizes,
        lower=np.ascontiguousarray(problem.bounds[:, 0]),
        upper=np.ascontiguousarray(problem.bounds[:, 1]),
        rate_lower=np.ascontiguousarray(rates[:, 0]),
        rate_upper=np.ascontiguousarray(rates[:, 1]),
        body=np.array([cone.body for cone in cones], dtype=np.int64),
        axis=np.array([cone.axis for cone in cones], dtype=float).reshape(-1, 3),
        direction=np.array([cone.direction for cone in cones], dtype=float).reshape(-1, 3),
        half_angle=np.array([cone.half_angle for cone in cones], dtype=float),
        requirements=requirements,
    )


def limit_names(problem: PlanningTask) -> list[str]:
    """Name the limits by the indices that ``passed_limit`` returns."""
    model, limited = problem.model, np.isfinite(problem.rate_bounds).any()
    axes = [f"the axis of {problem.bodies[cone.body].name}" for cone in problem.keep_outs]
    return [*model.state_names, *(model.rate_names if limited else ()), "a requirement", *axes]


@kernel
def keeps_limits(limits, x):  # type: ignore[no-untyped-def]
    """Say whether a state (nx,) is within its limits; NaN is not."""
    kept = True
    for i in range(x.shape[0]):
        kept = kept and limits.lower[i] <= x[i] <= limits.upper[i]
    return kept


@kernel
def passed_limit(machine, limits, x, u, after, h, scratch):  # type: ignore[no-untyped-def]
    """Return the index of a limit that the step from x to ``after`` violates, KEPT if none.

    The state derivatives at its ends are in ``limits.slope``, as ``slopes_of_step`` leaves them.

    Args:
        machine, limits: ``Machine`` and ``LimitArrays``.
        x, u, after: State (nx,), inputs (nu,) and the state reached (nx,).
        h: Step length in [s].
        scratch: ``CollisionScratch``.
    """
    passed = passed_at(machine, limits, after)
    if passed == KEPT:
        passed = passed_within(limits, x, after, h)
    requirement = x.shape[0] + limits.rate_lower.shape[0]
    if passed == KEPT and not keeps_requirements(machine, limits, x, u, h, scratch):
        passed = requirement
    if passed == KEPT:
        cone = entered_cone(machine, limits, x, u, after, h, scratch)
        if cone != KEPT:
            passed = requirement + 1 + cone
    return passed


@kernel
def passed_at(machine, limits, x):  # type: ignore[no-untyped-def]
    """Return the index of a limit of state or rates that a state (nx,) violates, KEPT if none."""
    if not keeps_limits(limits, x):
        for i in range(x.shape[0]):
            if not limits.lower[i] <= x[i] <= limits.upper[i]:
                return i
    if limits.rate_lower.shape[0] == 0:
        return KEPT
    call_under(
        machine.velocity, x.ctypes.data, limits.still.ctypes.data, machine.p.ctypes.data,
        limits.rates.ctypes.data,
    )  # fmt: skip
    for i in range(limits.rate_lower.shape[0]):
        if not limits.rate_lower[i] <= limits.rates[i] <= limits.rate_upper[i]:
            return x.shape[0] + i
    return KEPT


@kernel
def slopes_of_step(machine, limits, x, u, after):  # type: ignore[no-untyped-def]
    """Write the state derivatives at the ends of a step to ``limits.slope``.

    Args:
        machine, limits: ``Machine`` and ``LimitArrays``.
        x, u, after: State (nx,), inputs (nu,) and the state reached (nx,).
    """
    p = machine.p.ctypes.data
    first, last = limits.slope[0], limits.slope[1]
    call_under(machine.f, x.ctypes.data, u.ctypes.data, p, first.ctypes.data)
    call_under(machine.f, after.ctypes.data, u.ctypes.data, p, last.ctypes.data)


@kernel
def passed_within(limits, x, after, h):  # type: ignore[no-untyped-def]
    """Return the entry of the state whose extremum inside a step violates a limit, KEPT if none.

    If its derivatives a and b at the ends have opposite signs, the extremum exceeds the ends by
    about h/2 |a b| / (|a| + |b|), at most h/2 times the smaller derivative.

    Args:
        limits: ``LimitArrays``.
        x, after: State (nx,) and the state reached (nx,).
        h: Step length in [s].
    """
    first, last = limits.slope[0], limits.slope[1]
    for i in range(x.shape[0]):
        if first[i] * last[i] < 0.0:
            over = SAFETY_FACTOR * 0.5 * h * min(abs(first[i]), abs(last[i]))
            low, high = min(x[i], after[i]) - over, max(x[i], after[i]) + over
            if low < limits.lower[i] or high > limits.upper[i]:
                return i
    return KEPT


@kernel
def keeps_requirements(machine, limits, x, u, h, scratch):  # type: ignore[no-untyped-def]
    """Check the machine's requirements at samples of a step, its beginning included.

    Those that depend on the inputs, such as constraint forces, jump with them there.

    Args:
        machine, limits: ``Machine`` and ``LimitArrays``.
        x, u: State (nx,) and inputs (nu,).
        h: Step length in [s].
        scratch: ``CollisionScratch``.
    """
    if limits.requirements == 0:
        return True
    at, under, p = x.ctypes.data, u.ctypes.data, machine.p.ctypes.data
    for k in range(REQUIREMENT_SAMPLES + 1):
        if k > 0:
            advance(machine, x, u, h * k / REQUIREMENT_SAMPLES, scratch.x)
            at = scratch.x.ctypes.data
        call_under(machine.requirements, at, under, p, limits.margins.ctypes.data)
        for i in range(limits.requirements):
            if not limits.margins[i] >= 0.0:
                return False
    return True


@kernel
def entered_cone(machine, limits, x, u, after, h, scratch):  # type: ignore[no-untyped-def]
    """Check keep-out cones at samples of a step so dense that no axis turns far in between.

    The state derivatives at its ends are those left by ``slopes_of_step``.

    Args:
        machine, limits: ``Machine`` and ``LimitArrays``.
        x, u, after: State (nx,), inputs (nu,) and the state reached (nx,).
        h: Step length in [s].
        scratch: ``CollisionScratch``.

    Returns:
        The index of a cone that an axis is in, or KEPT.
    """
    if limits.body.shape[0] == 0:
        return KEPT
    fastest = max(
        turning(machine, limits, x, limits.slope[0], scratch),
        turning(machine, limits, after, limits.slope[1], scratch),
    )
    # [rad] that an axis may turn between two checks of a keep-out cone
    count = max(1.0, math.ceil(SAFETY_FACTOR * fastest * h / 0.01))
    if not count < 1e6:  # NaN included
        return 0
    for k in range(1, int(count) + 1):
        advance(machine, x, u, h * k / count, limits.beside)
        place_machine(machine, limits.beside, scratch)
        cone = cone_at(limits, scratch)
        if cone != KEPT:
            return cone
    return KEPT


@kernel
def cone_at(limits, scratch):  # type: ignore[no-untyped-def]
    """Return the index of a keep-out cone that an axis of a placed machine is in, or KEPT."""
    for c in range(limits.body.shape[0]):
        angle = axis_angle(scratch.poses[limits.body[c]], limits.axis[c], limits.direction[c])
        if not angle >= limits.half_angle[c]:
            return c
    return KEPT


@kernel
def turning(machine, limits, x, slope, scratch):  # type: ignore[no-untyped-def]
    """Return the largest angular speed of any axis with a keep-out cone, in [rad/s].

    Args:
        machine, limits: ``Machine`` and ``LimitArrays``.
        x, slope: State and its time derivative, shape (nx,).
        scratch: ``CollisionScratch``.
    """
    call_under(
        machine.frames_tangent, x.ctypes.data, machine.p.ctypes.data, slope.ctypes.data,
        scratch.poses.ctypes.data,
    )  # fmt: skip
    fastest = 0.0
    for c in range(limits.body.shape[0]):
        rates, square = scratch.poses[limits.body[c]], 0.0
        for i in range(3):
            square += carried(rates, limits.axis[c], i) ** 2
        fastest = max(fastest, math.sqrt(square))
    return fastest
