"""Compiled DOP853: the Runge-Kutta method of order 8 with error control, and its dense output.

Steps are those of SciPy's ``solve_ivp``: the same coefficients, first step, error norm and control.
Calls of the equations of motion go to machine code by address, so that an interval between two
knots takes microseconds.

Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., sections II.4 to II.6 and II.10.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import kernel
from kinolab.numerics.struct import Record
from kinolab.simulation.dop853_coefficients import (
    A_EXTRA,
    E3,
    E5,
    EXTRA_STAGES,
    STAGES,
    A,
    B,
    D,
)
from kinolab.simulation.machine import call_at, call_under

POWER = 7  # number of coefficients of the dense output
SAFETY, MIN_FACTOR, MAX_FACTOR = 0.9, 0.2, 10.0  # of the step size control
EXPONENT = -1.0 / 8.0
# How ``follow`` ended
WORKED, FULL, TOO_SMALL, SINGULAR, LAW_FAILED, NOT_FINITE, CHATTERS, TOO_MANY = range(8)
MAX_STEPS = 200_000  # in one interval: thousands of oscillations, in less than a second
MAX_TOTAL = 2_000_000  # in all intervals
MAX_SWITCHES = 1000  # in one interval; more are called chattering


class Ode(NamedTuple):
    """x_dot = f(x, u) of a machine, for compiled code: addresses, parameters and tolerances."""

    f: int
    law: int  # of the feedback that gives u at the beginning of each interval; 0 for none
    project: int  # onto position constraints at the end of each interval; 0 where there are none
    guards: int  # of transitions at a state, and whether one takes place; 0 without modes
    reset: int  # the state after a transition
    p: Array
    inputs: int  # of f
    atol: Array  # absolute tolerance of each state entry, (nx,)
    rtol: float
    # scratch
    k: Array  # slopes of the stages, (16, nx)
    y: Array  # state, (nx,)
    after: Array  # state after a step, (nx,)
    at: Array  # state of a stage, (nx,)
    seen: Array  # what ``guards`` wrote at y, after a step and on the way, (3, 1 + 3 guards)
    u: Array  # inputs held, (inputs,)
    progress: Array  # time reached in [s], steps made


class StepTable(NamedTuple):
    """Accepted steps with the coefficients of their dense output, in order."""

    knot: Annotated[NDArray[np.int64], "capacity"]  # interval of each step
    begin: Annotated[Array, "capacity"]  # in [s]
    end: Annotated[Array, "capacity"]  # in [s]
    x: Annotated[Array, "capacity", "nx"]  # state at the beginning
    coefficients: Annotated[Array, "capacity", POWER, "nx"]


def make_ode(
    addresses: dict[str, int], p: Array, inputs: int, atol: Array, rtol: float, guards: int = 0
) -> Record:
    """Return the record of an ODE.

    Args:
        addresses: Of f, of the feedback law, of the projection, and of the functions of machines
            with modes; 0 for none.
        p: Parameters, shape (np,).
        inputs: Number of the inputs of f.
        atol: Absolute tolerance of each state entry, shape (nx,).
        rtol: Relative tolerance.
        guards: Most transitions by which a mode may end.
    """
    nx = len(atol)
    return Record(
        Ode(
            **addresses, p=np.append(p, 0.0), inputs=inputs, atol=np.array(atol), rtol=rtol,
            k=np.empty((STAGES + 1 + EXTRA_STAGES, nx)), y=np.empty(nx), after=np.empty(nx),
            at=np.empty(nx), seen=np.zeros((3, 1 + 3 * guards)), u=np.zeros(inputs + 1),
            progress=np.zeros(2),
        )
    )  # fmt: skip


@kernel
def slope(ode, x, out):  # type: ignore[no-untyped-def]
    """Set ``out`` (nx,) to f(x, u); 0 if it worked."""
    return call_under(ode.f, x.ctypes.data, ode.u.ctypes.data, ode.p.ctypes.data, out.ctypes.data)


@kernel
def first_step(ode, span):  # type: ignore[no-untyped-def]
    """Return the length of the first step in [s]; negative where f has no value.

    Source: Hairer, Norsett, Wanner, section II.4, starting step size.

    Args:
        ode: ``Ode``; y is the state, k[0] its slope.
        span: Length of the interval in [s].
    """
    nx = ode.y.shape[0]
    d0, d1 = 0.0, 0.0
    for i in range(nx):
        scale = ode.atol[i] + abs(ode.y[i]) * ode.rtol
        d0 += (ode.y[i] / scale) ** 2
        d1 += (ode.k[0, i] / scale) ** 2
    d0, d1 = math.sqrt(d0 / nx), math.sqrt(d1 / nx)
    h0 = 1e-6 if d0 < 1e-5 or d1 < 1e-5 else 0.01 * d0 / d1
    h0 = min(h0, span)
    for i in range(nx):
        ode.at[i] = ode.y[i] + h0 * ode.k[0, i]
    if slope(ode, ode.at, ode.k[1]) != 0:
        return -1.0
    d2 = 0.0
    for i in range(nx):
        scale = ode.atol[i] + abs(ode.y[i]) * ode.rtol
        d2 += ((ode.k[1, i] - ode.k[0, i]) / scale) ** 2
    d2 = math.sqrt(d2 / nx) / h0
    h1 = max(1e-6, h0 * 1e-3)
    if d1 > 1e-15 or d2 > 1e-15:
        h1 = (0.01 / max(d1, d2)) ** (1.0 / 8.0)
    return min(100.0 * h0, h1, span)


@kernel
def stage(ode, row, s, h):  # type: ignore[no-untyped-def]
    """Set k[s] to the slope at y + h sum_j row[j] k[j], j < s; 0 if it worked.

    Args:
        ode: ``Ode``.
        row: Coefficients, shape (s,) or longer.
        s: Which stage.
        h: Of the step in [s].
    """
    for i in range(ode.y.shape[0]):
        ode.at[i] = 0.0
    for j in range(s):
        if row[j] != 0.0:
            for i in range(ode.y.shape[0]):
                ode.at[i] += row[j] * ode.k[j, i]
    for i in range(ode.y.shape[0]):
        ode.at[i] = ode.y[i] + h * ode.at[i]
    return slope(ode, ode.at, ode.k[s])


@kernel
def trial(ode, h):  # type: ignore[no-untyped-def]
    """Make a step of h in [s] from y to ``after``; 0 if f has a value in all stages."""
    for s in range(1, STAGES):
        if stage(ode, A[s], s, h) != 0:
            return 1
    failed = stage(ode, B, STAGES, h)
    for i in range(ode.y.shape[0]):
        ode.after[i] = ode.at[i]
    return failed


@kernel
def error_norm(ode, h):  # type: ignore[no-untyped-def]
    """Return the error of a step of h in [s] in its tolerances; a step is accepted below 1."""
    nx = ode.y.shape[0]
    fifth, third = 0.0, 0.0
    for i in range(nx):
        e5, e3 = 0.0, 0.0
        for s in range(STAGES + 1):
            e5 += ode.k[s, i] * E5[s]
            e3 += ode.k[s, i] * E3[s]
        scale = ode.atol[i] + max(abs(ode.y[i]), abs(ode.after[i])) * ode.rtol
        fifth += (e5 / scale) ** 2
        third += (e3 / scale) ** 2
    if fifth == 0.0 and third == 0.0:
        return 0.0
    return abs(h) * fifth / math.sqrt((fifth + 0.01 * third) * nx)


@kernel
def keep(ode, table, row, knot, begin, end):  # type: ignore[no-untyped-def]
    """Write a step with its dense output into a row of the table; 0 if it worked.

    Args:
        ode: ``Ode``; y and ``after`` are its states, k its slopes.
        table: ``StepTable``; written.
        row: Of the table.
        knot: Interval of the step.
        begin, end: In [s].
    """
    h, nx = end - begin, ode.y.shape[0]
    table.knot[row], table.begin[row], table.end[row] = knot, begin, end
    failed = 0
    for s in range(EXTRA_STAGES):
        failed |= stage(ode, A_EXTRA[s], STAGES + 1 + s, h)
    for i in range(nx):
        change = ode.after[i] - ode.y[i]
        table.x[row, i] = ode.y[i]
        table.coefficients[row, 0, i] = change
        table.coefficients[row, 1, i] = h * ode.k[0, i] - change
        table.coefficients[row, 2, i] = 2.0 * change - h * (ode.k[STAGES, i] + ode.k[0, i])
        for m in range(D.shape[0]):
            total = 0.0
            for s in range(STAGES + 1 + EXTRA_STAGES):
                total += D[m, s] * ode.k[s, i]
            table.coefficients[row, 3 + m, i] = h * total
    return failed


BEGIN, END, BETWEEN = range(3)  # rows of ``Ode.seen``


@kernel
def leaves(ode, x, row):  # type: ignore[no-untyped-def]
    """Say whether a transition takes place at a state x (nx,), and write a row of ``seen``."""
    u, p = ode.u.ctypes.data, ode.p.ctypes.data
    ode.seen[row, 0] = 0.0
    call_under(ode.guards, x.ctypes.data, u, p, ode.seen[row].ctypes.data)
    return ode.seen[row, 0] > 0.0


@kernel
def returns(ode, j, h):  # type: ignore[no-untyped-def]
    """Say whether guard j may have been negative for a while within a step of h seconds.

    It is positive and falls at the beginning, rises at the end, and is not positive there or where
    the tangents meet, below which a convex guard never is.
    """
    g, falling = ode.seen[BEGIN, 3 * j + 1], ode.seen[BEGIN, 3 * j + 2]
    last, rising = ode.seen[END, 3 * j + 1], ode.seen[END, 3 * j + 2]
    if not (g > 0.0 and falling < 0.0 and rising > 0.0):
        return False
    meet = (last - g - rising * h) / (falling - rising)
    return last <= 0.0 or g + falling * meet <= 0.0


@kernel
def near_minimum(ode, j, h):  # type: ignore[no-untyped-def]
    """Return the length of a step to a transition near guard j's minimum; 0 if there is none."""
    low, high = 0.0, h
    for _ in range(30):  # halvings of a step, to find where a guard is least
        middle = 0.5 * (low + high)
        if trial(ode, middle) != 0:
            return 0.0
        if leaves(ode, ode.after, BETWEEN):
            return middle
        if ode.seen[BETWEEN, 3 * j + 2] < 0.0:
            low = middle
        else:
            high = middle
    return 0.0


@kernel
def until_transition(ode, h):  # type: ignore[no-untyped-def]
    """Shorten a step of h seconds to its first transition, if there is one, and make it.

    Returns:
        Its length in [s]; 0 if it failed.
    """
    if leaves(ode, ode.after, END):
        h = located(ode, h)
        if trial(ode, h) != 0:
            return 0.0
        leaves(ode, ode.after, END)
    for j in range(ode.seen.shape[1] // 3):
        if returns(ode, j, h):
            found = near_minimum(ode, j, h)
            if found > 0.0:
                h = located(ode, found)
            if trial(ode, h) != 0:
                return 0.0
            leaves(ode, ode.after, END)
    return h


@kernel
def located(ode, h):  # type: ignore[no-untyped-def]
    """Return the length in [s] of the shortest step from y that ends in a transition, at most h."""
    low, high = 0.0, h
    for _ in range(60):  # halvings of a step, to locate a transition between modes
        middle = 0.5 * (low + high)
        if trial(ode, middle) == 0 and leaves(ode, ode.after, BETWEEN):
            high = middle
        else:
            low = middle
    return high


@kernel
def switched(ode):  # type: ignore[no-untyped-def]
    """Make all transitions that take place at y; return how many, negative for how it failed."""
    count, u, p = 0, ode.u.ctypes.data, ode.p.ctypes.data
    while ode.guards != 0 and leaves(ode, ode.y, BEGIN):
        count += 1
        if count > MAX_SWITCHES:
            return -CHATTERS
        failed = call_under(ode.reset, ode.y.ctypes.data, u, p, ode.after.ctypes.data)
        for i in range(ode.y.shape[0]):
            ode.y[i] = ode.after[i]
        if failed != 0:
            return -SINGULAR
    return count


@kernel
def accepted(ode, t, h, end):  # type: ignore[no-untyped-def]
    """Make one step from y to ``after``, as long as its error and transitions allow.

    Args:
        ode: ``Ode``.
        t: Time at y in [s].
        h: Length to try in [s].
        end: Of the longest step in [s].

    Returns:
        How it went, the step's length and end in [s], and the factor on the length of the next.
    """
    smallest = 10.0 * (np.nextafter(t, np.inf) - t)
    h, most = max(h, smallest), MAX_FACTOR
    while True:
        if not h >= smallest:
            return TOO_SMALL, h, t, 1.0
        now = min(t + h, end)
        h = now - t
        if trial(ode, h) != 0:
            return SINGULAR, h, t, 1.0
        error = error_norm(ode, h)
        if error < 1.0:
            break
        shrunk = SAFETY * error**EXPONENT
        h *= shrunk if shrunk > MIN_FACTOR else MIN_FACTOR  # MIN_FACTOR where it is NaN
        most = 1.0
    if ode.guards != 0:
        length = until_transition(ode, h)
        if length == 0.0:
            return SINGULAR, h, t, 1.0
        if length != h:
            h, now = length, t + length
    factor = MAX_FACTOR if error == 0.0 else SAFETY * error**EXPONENT
    return WORKED, h, now, min(most, factor)


@kernel
def integrate(ode, begin, end, longest, knot, dense, table, row):  # type: ignore[no-untyped-def]
    """Integrate y from one time to another; return how it ended.

    Args:
        ode: ``Ode``; y is changed, progress[0] is the time reached.
        begin, end: In [s].
        longest: Step that may be made, in [s].
        knot: Of the interval, for the table.
        dense: Whether steps are kept in the table.
        table: ``StepTable``; written.
        row: Shape (1,), first row of the table that is free; written.
    """
    t, h, switches, fresh, steps = begin, 0.0, 0, True, 0
    # looks in an interval at least, for a guard
    longest = min(longest, (end - begin) / (4 if ode.guards != 0 else 1))
    ode.progress[0] = t
    while True:
        made = switched(ode)
        switches += made
        if made < 0:
            return -made
        steps, ode.progress[1] = steps + 1, ode.progress[1] + 1
        if switches > MAX_SWITCHES or steps > MAX_STEPS or ode.progress[1] > MAX_TOTAL:
            return CHATTERS if switches > MAX_SWITCHES else TOO_MANY
        if t >= end:
            return WORKED
        if fresh or made:
            if slope(ode, ode.y, ode.k[0]) != 0:
                return SINGULAR
            h, fresh = first_step(ode, end - t), False
            if h < 0.0:
                return SINGULAR
        how, h, now, factor = accepted(ode, t, h, min(t + longest, end))
        if how != WORKED:
            return how
        if dense:
            if row[0] == table.begin.shape[0]:
                return FULL
            if keep(ode, table, row[0], knot, t, now) != 0:
                return SINGULAR
            row[0] += 1
        h *= factor
        t = now
        ode.progress[0] = t
        for i in range(ode.y.shape[0]):
            ode.y[i], ode.k[0, i] = ode.after[i], ode.k[STAGES, i]


@kernel
def follow(ode, t, u, starts, longest, chained, first, last, dense, table, row, ends):  # type: ignore[no-untyped-def]
    """Integrate interval by interval under zero-order hold; return how it ended, and where.

    Args:
        ode: ``Ode``.
        t: Times of the knots in [s], (N+1,).
        u: Inputs per interval, of the feedback law where there is one, (N, nu).
        starts: States at the beginnings of intervals, (N+1, nx); of a chain only the first counts.
        longest: Step that may be made in each interval, in [s], (N,).
        chained: Whether each interval begins where the one before ended.
        first, last: The first interval, and one past the last.
        dense: Whether steps are kept in the table.
        table: ``StepTable``; written.
        row: Shape (1,), first row of the table that is free; written.
        ends: States at the ends of intervals, (N, nx); written.

    Returns:
        How it ended, and the interval that it ended in.
    """
    nx, p = ode.y.shape[0], ode.p.ctypes.data
    for k in range(first, last):
        for i in range(nx):
            ode.y[i] = ends[k - 1, i] if chained and k > 0 else starts[k, i]
        if ode.law != 0:
            ode.progress[0] = t[k]
            status = call_under(ode.law, ode.y.ctypes.data, u[k].ctypes.data, p, ode.u.ctypes.data)
            if status != 0:
                return LAW_FAILED, k
        else:
            for j in range(ode.inputs):
                ode.u[j] = u[k, j]
        before = row[0]
        how = integrate(ode, t[k], t[k + 1], longest[k], k, dense, table, row)
        if how != WORKED:
            row[0] = before
            return how, k
        for i in range(nx):
            if not math.isfinite(ode.y[i]):
                return NOT_FINITE, k
        if ode.project != 0:  # in two Newton steps
            call_at(ode.project, ode.y.ctypes.data, p, ode.after.ctypes.data)
            call_at(ode.project, ode.after.ctypes.data, p, ode.y.ctypes.data)
        for i in range(nx):
            ends[k, i] = ode.y[i]
    return WORKED, last
