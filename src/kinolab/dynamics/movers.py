"""Obstacles that move: bodies that time alone moves, beside those of a machine.

With a clock among its coordinates a machine's state space is X times T, and an obstacle whose pose
is a function of time is one more body, which meets those of the machine and nothing else.

Source: LaValle, Planning Algorithms, 2006, section 7.1 (time-varying problems).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import sympy

from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.frames import move, rot_x, rot_y, rot_z
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.shapes import Shape
from kinolab.dynamics.language.symbols import clock
from kinolab.dynamics.machine_facts import TIME
from kinolab.numerics.arrays import Array

STILL = 60.0  # [s] that count as a metre where nothing is seen to move
SAMPLES = 1000  # of a motion, among which the fastest is taken
t = sympy.Symbol("t", real=True)  # the time in formulas


@dataclass(frozen=True)
class Mover:
    """An obstacle that moves.

    Attributes:
        name: What it is called.
        shapes: Its solids.
        pose: x, y, z in [m], roll, pitch and yaw in [rad] as functions of ``t``.
        color: Red, green and blue in [0, 1]; chosen from a palette when left out.
    """

    name: str
    shapes: tuple[Shape, ...]
    pose: tuple[sympy.Expr, ...]
    color: tuple[float, float, float] | None = None


def among(system: Mechanism, movers: Sequence[Mover], until: float) -> Mechanism:
    """Return a machine among obstacles that move.

    Args:
        system: The machine.
        movers: The obstacles.
        until: Time in [s] in which they are looked at, to tell how fast they are.
    """
    fastest = max(_fastest(mover.pose, until) for mover in movers)
    # A second counts as far as the fastest obstacle moves in it.
    time = clock(TIME, scale=1.0 / fastest if fastest > 0.0 else STILL)
    bodies = []
    for mover in movers:
        x, y, z, roll, pitch, yaw = (entry.xreplace({t: time}) for entry in mover.pose)
        frame = move(x, y, z) @ rot_z(yaw) @ rot_y(pitch) @ rot_x(roll)
        bodies.append(
            Body(mover.name, frame, shape=mover.shapes, prescribed=True, color=mover.color)
        )
    parts = [body.name for body in system.bodies if body.shapes]
    parts += [cable.name for cable in system.cables if cable.collides]
    return system.changed(
        bodies=[*system.bodies, *bodies],
        collisions=[*system.collisions, *((part, b.name) for b in bodies for part in parts)],
        coordinates=[*system.coordinates, time],
        flat=None,
    )


def polyline(corners: Array, further: Sequence[float] = ()) -> tuple[sympy.Expr, ...]:
    """Return a pose that is linear between corners, and constant before and after.

    Args:
        corners: Rows of a time in [s] and entries of a pose, (n, 4) or (n, 7).
        further: Entries that stay as they are.
    """
    times = corners[:, 0]
    made = [_linear(times, values) for values in corners[:, 1:].T]
    return (*made, *map(sympy.Float, further))


def _linear(times: Array, values: Array) -> sympy.Expr:
    slopes = np.diff(values) / np.diff(times)
    kinks = np.diff(slopes, prepend=0.0, append=0.0)
    terms = [
        sympy.Float(kink) * sympy.Max(t - sympy.Float(time), 0, evaluate=False)
        for time, kink in zip(times, kinks, strict=True)
        if kink
    ]
    return sympy.Add(sympy.Float(values[0]), *terms)


def _fastest(pose: Sequence[sympy.Expr], until: float) -> float:
    """Return the fastest that a point a metre from an obstacle's origin may be, in [m/s]."""
    times = np.linspace(0.0, until, SAMPLES)
    values = [np.broadcast_to(sympy.lambdify(t, e, "numpy")(times), times.shape) for e in pose]
    rates = np.diff(values, axis=1) / (times[1] - times[0])
    return float((np.linalg.norm(rates[:3], axis=0) + np.linalg.norm(rates[3:], axis=0)).max())


def corners_of(times: Array, poses: Array, chord: float) -> Array:
    """Return few corners of a motion, (n, 7), within a distance of it in [m] and [rad].

    Args:
        times: In [s], shape (m,).
        poses: Of a body, shape (m, 3, 4).
        chord: The distance.
    """
    rows = np.column_stack([times, poses[:, :, 3], roll_pitch_yaw(poses[:, :, :3])])
    return simplified(rows, chord)


def simplified(rows: Array, chord: float) -> Array:
    """Return fewer corners of a path that differs by at most a distance from the whole.

    Source: Douglas, Peucker, Algorithms for the reduction of the number of points required to
    represent a digitized line, Cartographica 10(2), 1973.
    """
    kept, pending = {0, len(rows) - 1}, [(0, len(rows) - 1)]
    while pending:
        a, b = pending.pop()
        share = ((rows[a : b + 1, 0] - rows[a, 0]) / (rows[b, 0] - rows[a, 0]))[:, None]
        line = rows[a, 1:] + share * (rows[b, 1:] - rows[a, 1:])
        off = np.abs(rows[a : b + 1, 1:] - line).max(axis=1)
        worst = int(off.argmax())
        if off[worst] > chord:
            kept.add(a + worst)
            pending += [(a, a + worst), (a + worst, b)]
    return rows[sorted(kept)]


def roll_pitch_yaw(turns: Array) -> Array:
    """Return continuous angles of rotations Rz(yaw) Ry(pitch) Rx(roll), shape (m, 3).

    Of the two triples that are a rotation's, each up to whole turns, that next to the one before is
    taken, so that what spins about one axis keeps the other two angles.

    Args:
        turns: Rotations, shape (m, 3, 3).
    """
    roll = np.arctan2(turns[:, 2, 1], turns[:, 2, 2])
    pitch = np.arcsin(np.clip(-turns[:, 2, 0], -1.0, 1.0))
    yaw = np.arctan2(turns[:, 1, 0], turns[:, 0, 0])
    one = np.column_stack([roll, pitch, yaw])
    other = np.column_stack([roll + math.pi, math.pi - pitch, yaw + math.pi])
    found = np.empty_like(one)
    before = np.zeros(3)
    for k, pair in enumerate(zip(one, other, strict=True)):
        near = [at - 2 * math.pi * np.round((at - before) / (2 * math.pi)) for at in pair]
        before = found[k] = min(near, key=lambda at: float(np.abs(at - before).max()))
    return found
