"""Inputs, step by step, under which a machine follows pieces of a motion; every step is checked.

Inputs are those under which velocities are right at the end of each step (computed torque); what
positions are off, they take back as quickly as it goes without overshoot.

Source: Spong, Hutchinson, Vidyasagar, Robot Modeling and Control, 2006, section 8.3; of machines
that drive along curves: Kanayama, Kimura, Miyazaki, Noguchi, A stable tracking control method for
an autonomous mobile robot, ICRA 1990.
"""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.problem.goal import SEARCHED_FRACTION
from kinolab.problem.goal_kernel import wrapped_angle
from kinolab.search.flat.car_drives import SPEED
from kinolab.search.flat.flat_machine import CAR, FULL
from kinolab.search.flat.flat_pieces import locate_time, total
from kinolab.search.flat.flat_states import bend_at, inputs_for, state_at
from kinolab.search.tree.problem_arrays import goal_violation
from kinolab.simulation.propagator import FREE, check_step

# What is off after a step, of velocities for one of positions, is a double root: no overshoot.
GAIN = 6.0 - math.sqrt(32.0)
ASIDE = 10.0  # steps in which a machine that does not slip comes back to its curve
AFTER = 10  # steps at rest, in which it may come to the very end
EARLY, AWAY = -1, -2  # it was refused on its way; it did not end in the goal


@kernel
def follow_pieces(search, pieces, wanted):  # type: ignore[no-untyped-def]
    """Follow pieces from the start; return the number of steps, and how it ended.

    Args:
        search: ``FlatSearch``; ``u`` has the inputs and ``states`` the states, both are written.
        pieces: What is followed.
        wanted: Whether it must end in the goal.

    Returns:
        The steps made, and 0, EARLY or AWAY.
    """
    h, whole, most = search.step, total(pieces), search.u.shape[0]
    states, work = search.states, search.work
    if pieces.size[0] == 0 or not whole / h < most - AFTER:
        return 0, EARLY
    count = max(math.ceil(whole / h - 1e-9), 1)
    pace = whole / (count * h)
    for i in range(states.shape[1]):
        states[0, i] = search.begin[i]
    for k in range(count + AFTER):
        x, u = states[k], search.u[k]
        here, t = locate_time(pieces, min(k, count) * h * pace)
        state_at(search, pieces, here, t, work.x, work.slopes)
        there, t = locate_time(pieces, min(k + 1, count) * h * pace)
        state_at(search, pieces, there, t, work.ahead, work.slopes)
        if k >= count:
            for i in range(work.slopes.shape[0]):
                work.ahead[search.flat.speeds[i]] = 0.0
        correct(search, x, pace)
        command(search, x, u)
        cause, _ = check_step(search, x, u, states[k + 1], h, True)
        if cause != FREE:
            return k, EARLY
        if k + 1 >= count and wanted:
            if goal_violation(search, states[k + 1], 1.0) <= SEARCHED_FRACTION:
                return k + 1, 0
        elif k + 1 >= count:
            return count, 0
    return count + AFTER, AWAY


@kernel
def correct(search, x, pace):  # type: ignore[no-untyped-def]
    """Write to ``slopes`` how independent velocities must change to be right after a step.

    Args:
        search: ``FlatSearch``; ``work.x`` is where the machine ought to be, ``work.ahead`` where it
            ought to come to.
        x: Where it is, shape (nx,).
        pace: What speeds of pieces are multiplied by.
    """
    flat, work, h = search.flat, search.work, search.step
    n = work.slopes.shape[0]
    for i in range(n):
        work.slopes[i] = pace * (work.slopes[i] if flat.first else work.ahead[flat.speeds[i]])
    if flat.kind == FULL:
        for i in range(n):
            off = work.x[flat.entry[i]] - x[flat.entry[i]]
            if flat.period[i] < math.inf:
                off = wrapped_angle(off)
            work.slopes[i] = (work.slopes[i] + GAIN * off / h - x[flat.speeds[i]]) / h
        return
    heading = x[flat.entry[2]]
    dx, dy = work.x[flat.entry[0]] - x[flat.entry[0]], work.x[flat.entry[1]] - x[flat.entry[1]]
    along = math.cos(heading) * dx + math.sin(heading) * dy
    aside = math.cos(heading) * dy - math.sin(heading) * dx
    speed = flat.unmix[0, 0] * work.slopes[0] + flat.unmix[0, 1] * work.slopes[1]
    turn = flat.unmix[1, 0] * work.slopes[0] + flat.unmix[1, 1] * work.slopes[1]
    away = wrapped_angle(work.x[flat.entry[2]] - heading)
    if flat.kind == CAR:
        reach = ASIDE * h * search.car.pace[SPEED]
        bend = bend_at(flat, work.x[flat.entry[3]]) + aside / (reach * reach)
        bend += math.copysign(2.0 * away / reach, away * speed)
        away = steering_for(flat, bend) - x[flat.entry[3]]
    elif abs(speed) * h > abs(aside) * 1e-3:  # else it cannot come back
        aim = math.atan2(aside, ASIDE * h * abs(speed))
        # [rad] by which it then points to it
        away += math.copysign(min(abs(aim), 0.5), aim * speed)
    speed += GAIN * along / h
    turn += GAIN * away / h
    for i in range(n):
        right = flat.mix[i, 0] * speed + flat.mix[i, 1] * turn
        work.slopes[i] = right if flat.first else (right - x[flat.speeds[i]]) / h


@kernel
def steering_for(flat, bend):  # type: ignore[no-untyped-def]
    """Return by what angle a car steers along a curvature in [1/m], or as near as it can."""
    low, high = 0, flat.curvature.shape[0] - 1
    while high - low > 1:
        k = (low + high) // 2
        if flat.curvature[k] <= bend:
            low = k
        else:
            high = k
    a, b = flat.curvature[low], flat.curvature[high]
    share = min(max((bend - a) / (b - a), 0.0), 1.0)
    return flat.bottom + (low + share) * (flat.top - flat.bottom) / (flat.curvature.shape[0] - 1)


@kernel
def command(search, x, u):  # type: ignore[no-untyped-def]
    """Write the inputs (nu,) of a step from x (nx,) by the velocities' wanted rates in ``slopes``.

    They are right in its middle, at its beginning where a law holds forces from then on, and
    within their limits.
    """
    flat, work, h = search.flat, search.work, 0.0 if search.flat.held else 0.5 * search.step
    for i in range(x.shape[0]):
        work.ahead[i] = x[i]
    if flat.kind == FULL:
        for i in range(flat.speeds.shape[0]):
            v = x[flat.speeds[i]]
            work.ahead[flat.entry[i]] += h * (v + 0.5 * h * work.slopes[i])
    for i in range(flat.speeds.shape[0]):
        work.ahead[flat.speeds[i]] += h * work.slopes[i]
    inputs_for(search, work.ahead, work.slopes, u)
    for i in range(u.shape[0]):
        low, high = flat.middle[i] - flat.half[i], flat.middle[i] + flat.half[i]
        u[i] = min(max(u[i], low), high)
