"""The shortest curve between two poses of a car, as a word of arcs and straight lines.

Lengths are in radii of the tightest turn, and negative where it drives backward.

Sources: Reeds, Shepp, Optimal paths for a car that goes both forwards and backwards, Pacific J.
Mathematics 145(2), 1990, section 8; Dubins, On curves of minimal length with a constraint on
average curvature, American J. Mathematics 79, 1957.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

import numpy as np

from kinolab.numerics.arrays import Array, Integers
from kinolab.numerics.jit import kernel
from kinolab.problem.goal_kernel import wrapped_angle

LETTERS = 5  # of a word at most
CSC, CSD, CCC, CCCC, CDCD, CCSC, CCSD, CCSCC = range(8)  # D turns the other way than C ends
BACKWARD = 8  # forms above, of a car that reverses; CSC, CSD and CCC are also those of Dubins
# Sides of letters: to the left 1, to the right -1; those not used are straight.
SIDES = np.array(
    [
        [1, 0, 1, 0, 0], [1, 0, -1, 0, 0], [1, -1, 1, 0, 0], [1, -1, 1, -1, 0],
        [1, -1, 1, -1, 0], [1, -1, 0, 1, 0], [1, -1, 0, -1, 0], [1, -1, 0, 1, -1],
    ]
)  # fmt: skip
SIZES = np.array([3, 3, 3, 4, 4, 4, 4, 5])
ROUNDING = 1e-10


class ArcWord(NamedTuple):
    """A word, for compiled kernels."""

    size: Annotated[Integers, 1]
    length: Annotated[Array, LETTERS]
    side: Annotated[Array, LETTERS]
    trial: Annotated[Array, LETTERS]


@kernel
def shortest_word(word, begin, end, radius, reverses):  # type: ignore[no-untyped-def]
    """Write the shortest word between two poses (3,); return its length in [m].

    Args:
        word: ``ArcWord``; written.
        begin, end: x, y in [m] and heading in [rad], shape (3,).
        radius: Of the tightest turn in [m].
        reverses: Whether the car drives backward, too.
    """
    dx, dy = (end[0] - begin[0]) / radius, (end[1] - begin[1]) / radius
    c, s = math.cos(begin[2]), math.sin(begin[2])
    x, y, phi = c * dx + s * dy, c * dy - s * dx, wrapped_angle(end[2] - begin[2])
    least = math.inf
    for form in range(BACKWARD if reverses else CCC + 1):
        for variant in range(8 if reverses else 2):
            flip, turned = (-1.0 if variant & 2 else 1.0), (-1.0 if variant & 1 else 1.0)
            px, py, angle = flip * x, turned * y, flip * turned * phi
            if variant & 4:  # from the end to the beginning
                c, s = math.cos(angle), math.sin(angle)
                px, py = px * c + py * s, px * s - py * c
            possible = solve_form(word.trial, form, px, py, angle, not reverses)
            size, length = SIZES[form], 0.0
            for i in range(size):
                length += abs(word.trial[i])
            if possible and length < least - ROUNDING:
                least = length
                word.size[0] = size
                for i in range(size):
                    k = size - 1 - i if variant & 4 else i
                    word.length[i] = flip * word.trial[k]
                    word.side[i] = turned * SIDES[form, k]
    return least * radius


@kernel
def solve_form(lengths, form, x, y, phi, forward):  # type: ignore[no-untyped-def]
    """Write the lengths of a word that begins forward and to the left; say whether there is one.

    Args:
        lengths: Of its letters, shape (LETTERS,); written.
        form: CSC and so on.
        x, y, phi: The pose at its end, from the one at its beginning.
        forward: Whether no letter may lead backward.
    """
    sign = -1.0 if form in (CSC, CCC, CCSC) else 1.0  # which end to the left
    xi, eta = x + sign * math.sin(phi), y - 1.0 - sign * math.cos(phi)
    if form <= CCC:
        return solve_three(lengths, form, xi, eta, phi, forward)
    if form <= CDCD:
        return solve_four(lengths, form, xi, eta, phi)
    return solve_quarters(lengths, form, xi, eta, phi)


@kernel
def solve_three(lengths, form, xi, eta, phi, forward):  # type: ignore[no-untyped-def]
    """Do what ``solve_form`` does for three letters, from one circle's centre to the other's.

    Args:
        lengths, form, forward: As ``solve_form`` takes them, shape (LETTERS,).
        xi, eta: The last circle's centre, from the first one's.
        phi: The heading at the end.
    """
    rho = math.hypot(xi, eta)
    theta = math.atan2(eta, xi) if rho > ROUNDING else 0.0  # both circles are one: any way serves
    if form == CSC:
        t, u = theta, rho
        v = phi - t
    elif form == CSD:
        if rho < 2.0:
            return False
        u = math.sqrt(rho * rho - 4.0)
        t = theta + math.atan2(2.0, u)
        v = t - phi
    else:
        if rho > 4.0:
            return False
        u = -2.0 * math.asin(0.25 * rho)
        t = theta + 0.5 * u + math.pi
        v = phi - t + u
    if forward:  # the same circles, the other way round where it would reverse
        lengths[0], lengths[1], lengths[2] = ahead(t), ahead(u) if form == CCC else u, ahead(v)
        return True
    t, v = wrapped_angle(t), wrapped_angle(v)
    lengths[0], lengths[1], lengths[2] = t, u, v
    return t >= -ROUNDING and (form == CCC or v >= -ROUNDING)


@kernel
def ahead(turn):  # type: ignore[no-untyped-def]
    """Return the same turn without driving backward: none where it lacks a rounding to a circle.

    Args:
        turn: In [rad].
    """
    turned = wrapped_angle(turn)
    return max(turned, 0.0) if turned > -ROUNDING else turned + 2.0 * math.pi


@kernel
def solve_four(lengths, form, xi, eta, phi):  # type: ignore[no-untyped-def]
    """Do what ``solve_form`` does for four turns, of which the inner ones are alike.

    Args:
        lengths, form: As ``solve_form`` takes them, shape (LETTERS,).
        xi, eta: The last circle's centre, from the first one's.
        phi: The heading at the end.
    """
    rho = math.hypot(xi, eta)
    share = 0.25 * (2.0 + rho) if form == CCCC else (20.0 - rho * rho) / 16.0
    if not 0.0 <= share <= 1.0:
        return False
    u = math.acos(share) if form == CCCC else -math.acos(share)
    w = -u if form == CCCC else u
    t, v = outer_turns(u, w, xi, eta, phi)
    lengths[0], lengths[1], lengths[2], lengths[3] = t, u, w, v
    return t >= -ROUNDING and (v <= ROUNDING if form == CCCC else v >= -ROUNDING)


@kernel
def solve_quarters(lengths, form, xi, eta, phi):  # type: ignore[no-untyped-def]
    """Do what ``solve_form`` does for words with quarter turns before or after a straight line.

    Args:
        lengths, form: As ``solve_form`` takes them, shape (LETTERS,).
        xi, eta: The last circle's centre, from the first one's.
        phi: The heading at the end.
    """
    rho, quarter = math.hypot(xi, eta), 0.5 * math.pi
    if rho < 2.0:
        return False
    if form == CCSC:
        r = math.sqrt(rho * rho - 4.0)
        t, u = wrapped_angle(math.atan2(eta, xi) + math.atan2(r, -2.0)), 2.0 - r
        v = wrapped_angle(phi - quarter - t)
    elif form == CCSD:
        t, u = math.atan2(xi, -eta), 2.0 - rho
        v = wrapped_angle(t + quarter - phi)
    else:
        u = 4.0 - math.sqrt(rho * rho - 4.0)
        t = wrapped_angle(math.atan2((4.0 - u) * xi - 2.0 * eta, -2.0 * xi + (u - 4.0) * eta))
        v = wrapped_angle(t - phi)
    lengths[0], lengths[1], lengths[2], lengths[3] = t, -quarter, u, v
    if form == CCSCC:
        lengths[3], lengths[4] = -quarter, v
    ends = v >= -ROUNDING if form == CCSCC else v <= ROUNDING
    return t >= -ROUNDING and u <= ROUNDING and ends


@kernel
def outer_turns(u, v, xi, eta, phi):  # type: ignore[no-untyped-def]
    """Return the first and the last turn of four.

    Args:
        u, v: The inner ones.
        xi, eta: The last circle's centre, from the first one's.
        phi: The heading at the end.
    """
    delta = wrapped_angle(u - v)
    a, b = math.sin(u) - math.sin(delta), math.cos(u) - math.cos(delta) - 1.0
    first = math.atan2(eta * a - xi * b, xi * a + eta * b)
    if 2.0 * (math.cos(delta) - math.cos(v) - math.cos(u)) + 3.0 < 0.0:
        first += math.pi
    first = wrapped_angle(first)
    return first, wrapped_angle(first - u + v - phi)
