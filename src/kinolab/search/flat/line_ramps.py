"""Straight lines from rest to rest: as quick as limits of speeds and inputs allow."""

from __future__ import annotations

import math

from kinolab.numerics.jit import kernel
from kinolab.search.flat.flat_pieces import put_stretch
from kinolab.search.flat.flat_states import fastest_along, is_possible

RAMPS, CRUISE = (0, 2), 1
HALVINGS, BISECTIONS = 40, 3  # of the acceleration, until it is possible; then to a fifteenth
PACES = 8  # speeds along a line that are compared, evenly up to the fastest
SAMPLES = 2  # intervals of a ramp, at whose ends limits are looked at


@kernel
def put_line(search, pieces, kind, begin, end):  # type: ignore[no-untyped-def]
    """Append the motion along a straight line; say whether there is one.

    It accelerates evenly, goes on evenly, and brakes evenly.

    Args:
        search: ``FlatSearch``.
        pieces: To which three are appended, or two; written.
        kind: MOVE or TURN.
        begin, end: Of the line, shape (axes,).
    """
    first, direction = pieces.size[0], search.work.direction
    length = 0.0
    for i in range(begin.shape[0]):
        length += (end[i] - begin[i]) ** 2
    length = math.sqrt(length)
    if length <= 1e-12:  # rounding
        return True
    if first + 3 > pieces.kind.shape[0]:
        return False
    for i in range(begin.shape[0]):
        direction[i] = (end[i] - begin[i]) / length
    put_stretch(pieces, first, kind, begin, direction, 0.0, 1.0, 0.0, 1.0)
    fastest = fastest_along(search, pieces, first)
    slope = min(fastest / search.step, length / search.step**2)
    least, pace, best = math.inf, 0.0, 0.0
    for k in range(PACES):  # friction may leave little to accelerate with at full speed
        speed = fastest * (PACES - k) / PACES
        found = steepest(search, pieces, first, kind, begin, length, speed, slope)
        if found > 0.0:
            # times the acceleration at one of them, from which that of the next is looked for
            slope = 8.0 * found
            T = line_seconds(length, speed, found)
            if least <= T:
                break
            least, pace, best = T, speed, found
    if best == 0.0:
        return False
    ramp(search, pieces, first, kind, begin, length, pace, best)
    pieces.size[0] = first + 3
    return True


@kernel
def steepest(search, pieces, first, kind, begin, length, fastest, slope):  # type: ignore[no-untyped-def]
    """Return the largest possible acceleration along a line, 0 if there is none.

    Args:
        search, pieces, first, kind, begin, length, fastest: As ``ramp`` takes them.
        slope: The acceleration from which smaller ones are looked for.
    """
    for _ in range(HALVINGS):
        if ramp(search, pieces, first, kind, begin, length, fastest, slope):
            break
        slope *= 0.5
    else:
        return 0.0
    low, high = slope, 2.0 * slope
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if ramp(search, pieces, first, kind, begin, length, fastest, middle):
            low = middle
        else:
            high = middle
    return low


@kernel
def line_seconds(length, fastest, slope):  # type: ignore[no-untyped-def]
    """Return how long a line takes from rest to rest, in [s]."""
    speed = min(fastest, math.sqrt(slope * length))
    return length / speed + speed / slope


@kernel
def ramp(search, pieces, first, kind, begin, length, fastest, slope):  # type: ignore[no-untyped-def]
    """Write the three pieces of a line, and say whether limits allow them.

    Args:
        search, pieces, first, kind, begin: As ``put_line`` has them; ``work.direction`` is set.
        length: Of the line.
        fastest, slope: Largest speed along it, and acceleration.
    """
    direction = search.work.direction
    speed = min(fastest, math.sqrt(slope * length))
    T = speed / slope
    way = 0.5 * speed * T
    rest = max(length - 2.0 * way, 0.0)
    put_stretch(pieces, first, kind, begin, direction, 0.0, 0.0, slope, T)
    put_stretch(pieces, first + 1, kind, begin, direction, way, speed, 0.0, rest / speed)
    put_stretch(pieces, first + 2, kind, begin, direction, length - way, speed, -slope, T)
    for k in RAMPS:
        if not is_possible(search, pieces, first + k, SAMPLES):
            return False
    return rest <= 0.0 or is_possible(search, pieces, first + CRUISE, SAMPLES)
