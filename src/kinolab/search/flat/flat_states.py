"""States and inputs along pieces of a motion, and whether they keep their limits."""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.numerics.lu import factor, substitute
from kinolab.search.flat.flat_machine import CAR, FULL
from kinolab.search.flat.flat_pieces import BACK, TURN, jet
from kinolab.search.tree.flat_arrays import copy
from kinolab.simulation.limits import KEPT, passed_at
from kinolab.simulation.machine import call_under
from kinolab.steering.path_motion import LIMIT_FRACTION, ROUNDING_FACTOR

POSE_STEPS = 4  # of fourth order, along a piece in which a car steers
SLOW = 1e-6  # [m/s] below which a curve of the plane has no direction of its own


@kernel
def state_at(search, pieces, k, t, x, slopes):  # type: ignore[no-untyped-def]
    """Write the state of the machine at a time of a piece, and what accelerates it.

    Args:
        search: ``FlatSearch``.
        pieces, k, t: The piece, and the time since its begin in [s].
        x: The state, shape (nx,); written.
        slopes: Rates of the independent velocities, shape (nv,); written.
    """
    flat = search.flat
    for i in range(x.shape[0]):
        x[i] = flat.base[i]
    if flat.kind == FULL:
        for i in range(flat.entry.shape[0]):
            value, speed, slope, _ = jet(pieces.c[k, i], t)
            x[flat.entry[i]], x[flat.speeds[i]], slopes[i] = value, speed, slope
        return
    if flat.kind == CAR:
        _, speed, speed_slope, _ = jet(pieces.c[k, 0], t)
        x[flat.entry[3]], turn, turn_slope, _ = jet(pieces.c[k, 1], t)
        pose_at(flat, pieces, k, t, search.work.pose)
        for i in range(3):
            x[flat.entry[i]] = search.work.pose[i]
        command_speeds(flat, speed, turn, speed_slope, turn_slope, x, slopes)
        return
    px, vx, ax, jx = jet(pieces.c[k, 0], t)
    py, vy, ay, jy = jet(pieces.c[k, 1], t)
    if pieces.kind[k] == TURN:
        heading, turn, turn_slope, _ = jet(pieces.c[k, 2], t)
        speed, speed_slope = 0.0, 0.0
    else:
        speed = math.hypot(vx, vy)
        if speed > SLOW:
            heading = math.atan2(vy, vx)
            speed_slope = (vx * ax + vy * ay) / speed
            turn = (vx * ay - vy * ax) / (speed * speed)
            turn_slope = (vx * jy - vy * jx) / (speed * speed) - 2.0 * turn * speed_slope / speed
        else:
            heading, turn, turn_slope = pieces.heading[k], 0.0, 0.0
            speed_slope = ax * math.cos(heading) + ay * math.sin(heading)
        if pieces.kind[k] == BACK:
            heading += math.pi
            speed, speed_slope = -speed, -speed_slope
    x[flat.entry[0]], x[flat.entry[1]], x[flat.entry[2]] = px, py, heading
    command_speeds(flat, speed, turn, speed_slope, turn_slope, x, slopes)


@kernel
def command_speeds(flat, speed, turn, speed_slope, turn_slope, x, slopes):  # type: ignore[no-untyped-def]
    """Write velocities, and their rates, by commands and their rates.

    Args:
        flat: ``FlatMachine``.
        speed, turn: Commands.
        speed_slope, turn_slope: Their rates.
        x: The state, shape (nx,); written.
        slopes: What ``state_at`` writes, shape (nv,); written.
    """
    if flat.first:
        slopes[0], slopes[1] = speed, turn
        return
    for i in range(2):
        x[flat.speeds[i]] = flat.mix[i, 0] * speed + flat.mix[i, 1] * turn
        slopes[i] = flat.mix[i, 0] * speed_slope + flat.mix[i, 1] * turn_slope


@kernel
def bend_at(flat, angle):  # type: ignore[no-untyped-def]
    """Return the curvature in [1/m] of a car's way where it steers by an angle."""
    low, last = flat.bottom, flat.curvature.shape[0] - 1
    at = min(max((angle - low) / (flat.top - low) * last, 0.0), float(last))
    k = min(int(at), last - 1)
    return flat.curvature[k] + (at - k) * (flat.curvature[k + 1] - flat.curvature[k])


@kernel
def pose_at(flat, pieces, k, t, pose):  # type: ignore[no-untyped-def]
    """Write the pose of a car at a time of a piece: in closed form where it does not steer.

    Args:
        flat: ``FlatMachine``.
        pieces, k, t: The piece, and the time since its begin in [s].
        pose: The pose, shape (3,); written.
    """
    way, steer = pieces.c[k, 0], pieces.c[k, 1]
    for i in range(3):
        pose[i] = pieces.pose[k, i]
    gone = ((way[3] * t + way[2]) * t + way[1]) * t
    if steer[1] == 0.0 and steer[2] == 0.0 and steer[3] == 0.0:
        half = 0.5 * bend_at(flat, steer[0]) * gone
        chord = gone * (math.sin(half) / half if abs(half) > 1e-6 else 1.0)  # else by rounding
        pose[0] += chord * math.cos(pose[2] + half)
        pose[1] += chord * math.sin(pose[2] + half)
        pose[2] += 2.0 * half
        return
    h = t / POSE_STEPS
    speed, turn = speeds_at(flat, way, steer, 0.0)
    for m in range(POSE_STEPS if t > 0.0 else 0):
        between, turning = speeds_at(flat, way, steer, (m + 0.5) * h)
        then, last = speeds_at(flat, way, steer, (m + 1.0) * h)
        begin = pose[2]
        middle = begin + h * (5.0 * turn + 8.0 * turning - last) / 24.0
        pose[2] += h * (turn + 4.0 * turning + last) / 6.0
        end = pose[2]
        for i in range(2):
            a = speed * (math.cos(begin) if i == 0 else math.sin(begin))
            b = between * (math.cos(middle) if i == 0 else math.sin(middle))
            c = then * (math.cos(end) if i == 0 else math.sin(end))
            pose[i] += h * (a + 4.0 * b + c) / 6.0
        speed, turn = then, last


@kernel
def speeds_at(flat, way, steer, t):  # type: ignore[no-untyped-def]
    """Return a car's speed, and how fast it turns in [rad/s], by polynomials (TERMS,)."""
    _, speed, _, _ = jet(way, t)
    angle, _, _, _ = jet(steer, t)
    return speed, bend_at(flat, angle) * speed


@kernel
def inputs_for(search, x, slopes, u):  # type: ignore[no-untyped-def]
    """Write the inputs (nu,) under which independent velocities change so; 0 if there are any.

    Args:
        search: ``FlatSearch``.
        x, slopes: State (nx,), and wanted rates of the independent velocities, shape (nv,).
        u: The inputs; written, also beyond their limits.
    """
    flat = search.flat
    for i in range(u.shape[0]):
        u[i] = flat.middle[i]
    heading = x[flat.entry[2]] if flat.first else 0.0
    if flat.first:
        x[flat.entry[2]] = 0.0  # so that its speed is the rate of its place along the first axis
    failed = solve_inputs(search, x, slopes, u)
    if flat.first:
        x[flat.entry[2]] = heading
    return failed


@kernel
def solve_inputs(search, x, slopes, u):  # type: ignore[no-untyped-def]
    """Do what ``inputs_for`` does, from inputs (nu,) in the middle."""
    flat, work = search.flat, search.work
    if not flat.constant:
        gain_at(search, x)
        failed = factor(work.gain, work.pivots)
        for i in range(u.shape[0]):
            work.change[i] = slopes[i] - work.rates[0, flat.driven[i]]
        substitute(work.gain, work.pivots, work.change)
        for i in range(u.shape[0]):
            u[i] += flat.half[i] * work.change[i]
        return failed
    # inputs that a law may cut off: from their middle, from there, and to be sure
    for _ in range(3):
        off = improve_inputs(search, x, slopes, u)
        if not flat.held:
            return 0
        if off <= 1e-9:  # of half their ranges, by which they are then corrected at most
            return 0
        for i in range(u.shape[0]):
            # times half their ranges: no law that is cut off asks for so much less
            if abs(u[i] - flat.middle[i]) > 2.0 * flat.half[i]:
                return 1
    return 1


@kernel
def improve_inputs(search, x, slopes, u):  # type: ignore[no-untyped-def]
    """Correct inputs (nu,) by how far rates are off; return by how much, in half ranges.

    Where a law of feedback is cut off by the limits of forces, it stays off.
    """
    flat, work, p = search.flat, search.work, search.machine.p.ctypes.data
    rates, size = work.rates[0], 0.0
    call_under(search.machine.f, x.ctypes.data, u.ctypes.data, p, rates.ctypes.data)
    for i in range(u.shape[0]):
        work.change[i] = slopes[i] - rates[flat.driven[i]]
    for i in range(u.shape[0]):
        step = 0.0
        for j in range(u.shape[0]):
            step += flat.inverse[i, j] * work.change[j]
        u[i] += flat.half[i] * step
        size = max(size, abs(step))
    return size


@kernel
def gain_at(search, x):  # type: ignore[no-untyped-def]
    """Write how half ranges of inputs accelerate the machine at a state (nx,) to ``work.gain``.

    The rates in the middle of these ranges are left in ``work.rates[0]``.
    """
    flat, machine, work = search.flat, search.machine, search.work
    n, rates, p = flat.middle.shape[0], work.rates, search.machine.p.ctypes.data
    copy(flat.middle, work.held)
    call_under(machine.f, x.ctypes.data, work.held.ctypes.data, p, rates[0].ctypes.data)
    for j in range(n):
        work.held[j] += flat.half[j]
        call_under(machine.f, x.ctypes.data, work.held.ctypes.data, p, rates[1].ctypes.data)
        work.held[j] = flat.middle[j]
        for i in range(n):
            work.gain[i, j] = rates[1, flat.driven[i]] - rates[0, flat.driven[i]]


@kernel
def is_possible(search, pieces, k, samples):  # type: ignore[no-untyped-def]
    """Say whether limits and inputs allow a piece, at samples: its middle and its ends first.

    Args:
        search: ``FlatSearch``.
        pieces, k: The piece.
        samples: Intervals of equal length between them, a power of two.
    """
    T, work = pieces.duration[k], search.work
    if not T > 0.0:
        return False
    spacing, first = samples, 0
    while spacing >= 1:
        for m in range(first, samples + 1, spacing if first == 0 else 2 * spacing):
            state_at(search, pieces, k, T * m / samples, work.x, work.slopes)
            if not is_sample_possible(search):
                return False
        spacing //= 2
        first = spacing
    return True


@kernel
def is_sample_possible(search):  # type: ignore[no-untyped-def]
    """Say whether limits, inputs and requirements allow ``work.x`` with rates ``work.slopes``.

    Forces that a law holds, and what the machine requires, must suffice for a motion that is
    quicker by what LIMIT_FRACTION leaves.
    """
    work, flat, machine, limits = search.work, search.flat, search.machine, search.limits
    if passed_at(machine, search.tight, work.x) != KEPT:
        return False
    if flat.held:
        for i in range(work.slopes.shape[0]):
            work.slopes[i] /= LIMIT_FRACTION
    if inputs_for(search, work.x, work.slopes, work.u) != 0:
        return False
    for i in range(work.u.shape[0]):
        middle = LIMIT_FRACTION * flat.middle[i] if flat.first else flat.middle[i]
        if not abs(work.u[i] - middle) <= ROUNDING_FACTOR * LIMIT_FRACTION * flat.half[i]:
            return False
    if limits.requirements == 0:
        return True
    for i in range(flat.speeds.shape[0]):
        work.x[flat.speeds[i]] /= LIMIT_FRACTION
    call_under(
        machine.requirements, work.x.ctypes.data, work.u.ctypes.data, machine.p.ctypes.data,
        limits.margins.ctypes.data,
    )  # fmt: skip
    kept = True
    for i in range(limits.requirements):
        kept = kept and limits.margins[i] >= 0.0
    return kept


@kernel
def fastest_along(search, pieces, k):  # type: ignore[no-untyped-def]
    """Return how many times as fast limits of speeds allow a piece to be at its beginning."""
    work, tight, flat, most = search.work, search.tight, search.flat, math.inf
    state_at(search, pieces, k, 0.0, work.x, work.slopes)
    if flat.first:
        inputs_for(search, work.x, work.slopes, work.u)
        for i in range(work.u.shape[0]):
            low, high = flat.middle[i] - flat.half[i], flat.middle[i] + flat.half[i]
            most = min(most, LIMIT_FRACTION * factor_within(work.u[i], low, high))
    for i in range(flat.speeds.shape[0]):
        row = flat.speeds[i]
        most = min(most, factor_within(work.x[row], tight.lower[row], tight.upper[row]))
    if tight.rate_lower.shape[0] > 0:
        call_under(
            search.machine.velocity, work.x.ctypes.data, tight.still.ctypes.data,
            search.machine.p.ctypes.data, tight.rates.ctypes.data,
        )  # fmt: skip
        for i in range(tight.rate_lower.shape[0]):
            rate = tight.rates[i]
            most = min(most, factor_within(rate, tight.rate_lower[i], tight.rate_upper[i]))
    return most


@kernel
def factor_within(rate, lower, upper):  # type: ignore[no-untyped-def]
    """Return by which factor at most a rate keeps its limits, infinite where it vanishes."""
    if rate > 0.0:
        return max(upper, 0.0) / rate
    return min(lower, 0.0) / rate if rate < 0.0 else math.inf
