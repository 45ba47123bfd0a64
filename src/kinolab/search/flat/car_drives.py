"""Drives of a car: it steers while it drives, stops where it changes gear, and ends where it must.

How far it steers and how fast it drives are functions of time, from which its way follows. Along a
word of arcs each side is steered to, held and left; how long it is held is found by Newton's
method, so that the drive ends at a given pose.

Source: Scheuer, Fraichard, Continuous-curvature path planning for car-like vehicles, IROS 1997 (of
ways); times instead of ways are found here.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.numerics.lu import factor, substitute
from kinolab.problem.goal_kernel import wrapped_angle
from kinolab.search.flat.flat_pieces import MOVE, begin_later
from kinolab.search.flat.flat_states import pose_at
from kinolab.steering.arc_words import LETTERS, ArcWord

NUDGE = 1e-6  # of a second: by which holds are changed for derivatives
TURNS, PHASES = 2 * LETTERS + 1, 3 * LETTERS  # of steering and of speed at most
DRIVE_PIECES = TURNS + PHASES
SPEED, SLOPE, STEER, STEER_SLOPE, REVERSES = range(5)  # in ``pace``


class CarWork(NamedTuple):
    """What a car can do, and scratch memory for its drives."""

    pace: Annotated[Array, 5]  # speeds and accelerations along its way and of its steering
    word: ArcWord
    gear: Annotated[Array, LETTERS]
    hold: Annotated[Array, LETTERS]
    least: Annotated[Array, LETTERS]
    before: Annotated[Array, LETTERS]
    change: Annotated[Array, LETTERS]
    until: Annotated[Array, TURNS]  # times in [s] at which phases of steering end
    angle: Annotated[Array, TURNS, 2]  # of steering at their begins and ends
    ends: Annotated[Array, PHASES]  # times at which phases of speed end
    speed: Annotated[Array, PHASES, 2]  # at their begins, and how it changes
    off: Annotated[Array, 3]
    moved: Annotated[Array, 3, LETTERS]
    normal: Annotated[Array, 3, 3]
    pivots: Annotated[Integers, 3]
    pose: Annotated[Array, 3]
    begin: Annotated[Array, 3]
    end: Annotated[Array, 3]


@kernel
def ramp_seconds(search, change):  # type: ignore[no-untyped-def]
    """Return how long steering by a change takes, evenly begun and ended, in [s]."""
    pace, change = search.car.pace, abs(change)
    return math.hypot(1.5 * change / pace[STEER], math.sqrt(6.0 * change / pace[STEER_SLOPE]))


@kernel
def fit_drive(search, begin, end, knots):  # type: ignore[no-untyped-def]
    """Write the drive along ``word`` to ``trial``; return its duration, infinite if there is none.

    Args:
        search: ``FlatSearch``; ``car.word`` leads from the one pose to the other.
        begin, end: Poses, shape (3,).
        knots: Speed and steering at the beginning, and at the end, shape (2, 2).
    """
    if not guess_holds(search, knots):
        return math.inf
    T = lay_drive(search, begin, end, knots)
    for _ in range(15):  # steps of Newton's method
        off = distance_off(search.car)
        # radii that a drive may miss its end by, which whoever follows it corrects
        if not off < math.inf or off <= 1e-5 * search.flat.radius:
            return T if off < math.inf else math.inf
        if not find_change(search, begin, end, knots):
            return math.inf
        T, share = math.inf, 1.0
        for _ in range(6):  # halvings of a step of Newton's, until it leads nearer
            T = step_holds(search, begin, end, knots, share)
            if distance_off(search.car) < off:
                break
            share *= 0.5
        if not distance_off(search.car) < off:
            return math.inf
    return math.inf


@kernel
def distance_off(car):  # type: ignore[no-untyped-def]
    """Return by how much the last drive that was laid is off its end, in [m]."""
    return math.sqrt(car.off[0] ** 2 + car.off[1] ** 2 + car.off[2] ** 2)


@kernel
def step_holds(search, begin, end, knots, share):  # type: ignore[no-untyped-def]
    """Lay the drive after a share of the change of holds; return its duration in [s].

    Args:
        search, begin, end, knots: As ``fit_drive`` takes them.
        share: Of the change.
    """
    car = search.car
    for i in range(car.word.size[0]):
        car.hold[i] = max(car.before[i] + share * car.change[i], car.least[i])
    return lay_drive(search, begin, end, knots)


@kernel
def find_change(search, begin, end, knots):  # type: ignore[no-untyped-def]
    """Write the least change of holds that ends a drive where it must, were all linear.

    Return whether there is one; ``before`` has the holds as they are.
    """
    car, n = search.car, search.car.word.size[0]
    first = car.off[0], car.off[1], car.off[2]
    for i in range(n):
        car.before[i], car.change[i] = car.hold[i], 0.0
        car.hold[i] += NUDGE
        lay_drive(search, begin, end, knots)
        car.hold[i] = car.before[i]
        if not car.off[0] < math.inf:
            return False
        for r in range(3):
            car.moved[r, i] = (car.off[r] - first[r]) / NUDGE
    for r in range(3):
        car.off[r] = first[r]
        for c in range(3):
            car.normal[r, c] = 0.0
            for i in range(n):
                car.normal[r, c] += car.moved[r, i] * car.moved[c, i]
    # of the normal equations' trace, as damping
    size = 1e-9 * (car.normal[0, 0] + car.normal[1, 1] + car.normal[2, 2])
    for r in range(3):
        car.normal[r, r] += size
    if factor(car.normal, car.pivots) != 0:
        return False
    substitute(car.normal, car.pivots, car.off)
    for i in range(n):
        for r in range(3):
            car.change[i] -= car.moved[r, i] * car.off[r]
    return True


@kernel
def guess_holds(search, knots):  # type: ignore[no-untyped-def]
    """Write how long sides are held if steering takes no way; say whether gears fit speeds."""
    car, flat = search.car, search.flat
    word, n, pace = car.word, car.word.size[0], car.pace
    gear = 0.0
    for i in range(n):  # that of a letter without length is its neighbour's
        if abs(word.length[i]) > 1e-9:
            gear = math.copysign(1.0, word.length[i])
        car.gear[i] = gear
    for i in range(n - 1, -1, -1):
        if car.gear[i] == 0.0:
            car.gear[i] = car.gear[i + 1] if i + 1 < n else 1.0
    if knots[0, 0] * car.gear[0] < 0.0 or knots[1, 0] * car.gear[n - 1] < 0.0:
        return False
    steer = knots[0, 1]
    for i in range(n):
        side = flat.steering[int(word.side[i]) + 1]
        after = flat.steering[int(word.side[i + 1]) + 1] if i + 1 < n else knots[1, 1]
        ramps = ramp_seconds(search, side - steer) + ramp_seconds(search, after - side)
        car.hold[i] = abs(word.length[i]) * flat.radius / pace[SPEED] - 0.5 * ramps
        car.least[i] = 0.0
        if side != 0.0:  # a turn grows with the square of how far one steers for it
            full = ramp_seconds(search, side)
            # a side is steered by a hundredth of its full steering at least
            car.least[i] = -0.99 * full
            if car.hold[i] < 0.0:
                share = math.sqrt(max(1.0 + car.hold[i] / full, 0.0))
                car.hold[i] = (share - 1.0) * full
        car.hold[i] = max(car.hold[i], car.least[i])
        steer = side
    first = 0
    for i in range(n):  # what accelerating and braking take more
        if i + 1 == n or car.gear[i + 1] != car.gear[i]:
            longest = first
            for k in range(first, i + 1):
                if car.hold[k] > car.hold[longest]:
                    longest = k
            begins = first > 0 or knots[0, 0] == 0.0
            stops = i + 1 < n or knots[1, 0] == 0.0
            more = (0.5 if begins else 0.0) + (0.5 if stops else 0.0)
            car.hold[longest] += more * pace[SPEED] / pace[SLOPE]
            first = i + 1
    return True


@kernel
def lay_drive(search, begin, end, knots):  # type: ignore[no-untyped-def]
    """Write the drive with given holds to ``trial``, and how far it is off its end to ``off``.

    Return its duration in [s], infinite where it would have to brake too hard.

    Args:
        search, begin, end, knots: As ``fit_drive`` takes them.
    """
    car, trial = search.car, search.trial
    turns = lay_steering(search, knots)
    whole = car.until[turns - 1]
    phases = lay_speeds(search, knots, whole) if whole < 1e6 else 0  # [s] of a drive: it is none
    if phases == 0:
        car.off[0] = math.inf
        return math.inf
    for i in range(3):
        car.pose[i] = begin[i]
    trial.size[0] = 0
    t, i, k = 0.0, 0, 0
    while i < turns and k < phases:
        later = min(car.until[i], car.ends[k])
        if later > t:
            put_phase(search, t, later, i, k)
            pose_at(search.flat, trial, trial.size[0] - 1, later - t, car.pose)
        t = max(t, later)
        i, k = (i + 1 if car.until[i] <= t else i), (k + 1 if car.ends[k] <= t else k)
    car.off[0], car.off[1] = car.pose[0] - end[0], car.pose[1] - end[1]
    car.off[2] = wrapped_angle(car.pose[2] - end[2]) * search.flat.radius
    return whole


@kernel
def lay_steering(search, knots):  # type: ignore[no-untyped-def]
    """Write when and how far it steers along ``word``; return the number of phases.

    A side that is held for less than no time is steered to by less.
    """
    car, flat, n = search.car, search.flat, search.car.word.size[0]
    t, steer = 0.0, knots[0, 1]
    for i in range(n + 1):
        after, held = knots[1, 1], 0.0
        if i < n:
            after, held = flat.steering[int(car.word.side[i]) + 1], max(car.hold[i], 0.0)
            if car.hold[i] < 0.0 and after != 0.0:
                after *= 1.0 + car.hold[i] / ramp_seconds(search, after)
        t += ramp_seconds(search, after - steer)
        car.until[2 * i], car.angle[2 * i, 0], car.angle[2 * i, 1] = t, steer, after
        if i < n:
            t += held
            k = 2 * i + 1
            car.until[k], car.angle[k, 0], car.angle[k, 1] = t, after, after
        steer = after
    return 2 * n + 1


@kernel
def lay_speeds(search, knots, whole):  # type: ignore[no-untyped-def]
    """Write how fast it drives; return the number of phases, 0 where it cannot brake so hard.

    It changes gear in the middle of steering from one letter to the next.
    """
    car, n, slope = search.car, search.car.word.size[0], search.car.pace[SLOPE]
    t, speed, count = 0.0, abs(knots[0, 0]), 0
    for i in range(n):
        last = i + 1 == n
        if not last and car.gear[i + 1] == car.gear[i]:
            continue
        end = whole if last else 0.5 * (car.until[2 * i + 1] + car.until[2 * i + 2])
        then, T = (abs(knots[1, 0]) if last else 0.0), end - t
        peak = min(car.pace[SPEED], 0.5 * (slope * T + speed + then))
        if peak < max(speed, then) * (1.0 - 1e-9):
            return 0
        up, down, gear = max(peak - speed, 0.0) / slope, max(peak - then, 0.0) / slope, car.gear[i]
        car.ends[count], car.ends[count + 1], car.ends[count + 2] = t + up, end - down, end
        car.speed[count, 0], car.speed[count, 1] = gear * speed, gear * slope
        car.speed[count + 1, 0], car.speed[count + 1, 1] = gear * peak, 0.0
        car.speed[count + 2, 0], car.speed[count + 2, 1] = gear * peak, -gear * slope
        t, speed, count = end, then, count + 3
    return count


@kernel
def put_phase(search, begin, end, i, k):  # type: ignore[no-untyped-def]
    """Append a piece to ``trial``, in one phase of steering and one of speed.

    Args:
        search: ``FlatSearch``; ``car.pose`` is where the piece begins.
        begin, end: Times in [s].
        i, k: Of the phase of steering, and of that of speed.
    """
    car, trial = search.car, search.trial
    m = trial.size[0]
    trial.size[0] = m + 1
    trial.kind[m], trial.duration[m], trial.heading[m] = MOVE, end - begin, 0.0
    for r in range(3):
        trial.pose[m, r] = car.pose[r]
    way, steer = trial.c[m, 0], trial.c[m, 1]
    since = car.ends[k - 1] if k > 0 else 0.0
    way[0], way[1] = 0.0, car.speed[k, 0] + car.speed[k, 1] * (begin - since)
    way[2], way[3], way[4], way[5] = 0.5 * car.speed[k, 1], 0.0, 0.0, 0.0
    since = car.until[i - 1] if i > 0 else 0.0
    T, change = car.until[i] - since, car.angle[i, 1] - car.angle[i, 0]
    steer[0], steer[1], steer[4], steer[5] = car.angle[i, 0], 0.0, 0.0, 0.0
    steer[2], steer[3] = 3.0 * change / T**2, -2.0 * change / T**3
    if change != 0.0:
        begin_later(steer, begin - since)
