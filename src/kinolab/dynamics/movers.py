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

from kinolab.dynamics.codegen.state_space import whole_turns
from kinolab.dynamics.facts.machine_facts import TIME
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.frames import move, rot_x, rot_y, rot_z
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import clocks
from kinolab.dynamics.language.shapes import Shape
from kinolab.dynamics.symbols.symbols import Parameter, clock
from kinolab.numerics.arrays import Array

ENTRIES = ("x", "y", "z", "roll", "pitch", "yaw")
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


def among(
    system: Mechanism, movers: Sequence[Mover], fastest: float, until: float = math.inf
) -> Mechanism:
    """Return a machine among obstacles that move.

    Args:
        fastest: How fast a point of them is at most, in [m/s]; a second counts in the metric as far
            as that goes in it.
        until: Time in [s] up to which their motion is known.
    """
    own = clocks(system)
    time = (
        # [s] that count as a metre where nothing is seen to move
        own[0] if own else clock(TIME, 0.0, until, scale=1.0 / fastest if fastest > 0.0 else 60.0)
    )
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
        coordinates=list(dict.fromkeys([*system.coordinates, time])),
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
    kinks = _kinks(times, values)
    terms = [
        sympy.Float(kink) * sympy.Max(t - sympy.Float(time), 0, evaluate=False)
        for time, kink in zip(times, kinks, strict=True)
        if kink
    ]
    return sympy.Add(sympy.Float(values[0]), *terms)


def _kinks(times: Array, values: Array) -> Array:
    """Return by how much the slope changes at each corner."""
    return np.diff(np.diff(values) / np.diff(times), prepend=0.0, append=0.0)


def parametric_polyline(name: str, count: int) -> tuple[sympy.Expr, ...]:
    """Return a pose as ``polyline`` does, of which all numbers are parameters.

    Args:
        name: What their names begin with.
        count: Of corners at most.
    """
    times = (Parameter(f"{name}_t{k}", 0.0, "s") for k in range(count))
    after = [sympy.Max(t - time, 0, evaluate=False) for time in times]
    return tuple(
        sympy.Add(
            Parameter(f"{name}_{entry}", 0.0),
            *(Parameter(f"{name}_{entry}{k}", 0.0) * one for k, one in enumerate(after)),
        )
        for entry in ENTRIES
    )


def polyline_values(name: str, count: int, corners: Array) -> dict[str, float]:
    """Return the parameters of ``parametric_polyline``, by name.

    Args:
        name, count: As it takes them.
        corners: As ``polyline`` takes them, (n, 7), ``count`` rows at most.
    """
    times = np.append(corners[:, 0], np.full(count - len(corners), corners[-1, 0]))
    found = {f"{name}_t{k}": float(time) for k, time in enumerate(times)}
    for entry, values in zip(ENTRIES, corners[:, 1:].T, strict=True):
        kinks = np.zeros(count)
        kinks[: len(corners)] = _kinks(corners[:, 0], values)
        found[f"{name}_{entry}"] = float(values[0])
        found |= {f"{name}_{entry}{k}": float(kink) for k, kink in enumerate(kinks)}
    return found


def fastest_of(pose: Sequence[sympy.Expr], until: float) -> float:
    """Return the fastest that a point a metre from an obstacle's origin is up to a time, in [m/s].

    Args:
        pose: As that of a ``Mover``.
        until: In [s].
    """
    times = np.linspace(0.0, until, SAMPLES)
    values = [np.broadcast_to(sympy.lambdify(t, e, "numpy")(times), times.shape) for e in pose]
    return fastest_between(times, np.array(values).T)


def fastest_between(times: Array, poses: Array) -> float:
    """Return the same between rows of x, y, z, roll, pitch and yaw (n, 6) at times (n,)."""
    rates = np.diff(poses, axis=0) / np.diff(times)[:, None]
    sizes = np.linalg.norm(rates[:, :3], axis=1) + np.linalg.norm(rates[:, 3:], axis=1)
    return float(sizes.max(initial=0.0))


def corners_of(shapes: Sequence[Shape], times: Array, poses: Array, chord: float) -> Array:
    """Return few corners of a body's motion, (n, 7), near which all its points stay.

    Args:
        shapes: Its solids; what turns about an axis of symmetry of them all does not count.
        times: In [s], shape (m,).
        poses: Of the body, shape (m, 3, 4).
        chord: How far points may be from where they are on the straight lines, in [m].
    """
    reach = max(float(np.linalg.norm(s.at) + np.linalg.norm(s.lowered()[1][:3])) for s in shapes)
    angles = _angles_that_count(shapes, poses[:, :, :3])
    rows = np.column_stack([times, poses[:, :, 3], angles])
    sizes = np.array([1.0, 1.0, 1.0, reach, reach, reach])
    return simplified(rows, chord, sizes)


def _angles_that_count(shapes: Sequence[Shape], turns: Array) -> Array:
    """Return roll, pitch and yaw (m, 3) that turn solids as rotations (m, 3, 3) do, to the eye."""
    axes = {"xyz".index(s.axis) for s in shapes if s.symmetric != "xyz"}
    about = next(iter(axes), 2)
    off = [entry for s in shapes for k, entry in enumerate(s.at) if k != about]
    if len(axes) > 1 or not all(s.symmetric for s in shapes) or np.any(off):
        return roll_pitch_yaw(turns)
    if not axes and not np.any([s.at for s in shapes]):  # balls about the origin
        return np.zeros((len(turns), 3))
    # Yaw and pitch, or roll, lead the axis where it points.
    x, y, z = turns[:, :, about].T
    none = np.zeros_like(x)
    level = np.hypot(x, y)
    if about == 0:
        return _continuous(np.column_stack([none, -np.arctan2(z, level), np.arctan2(y, x)]))
    if about == 1:
        return _continuous(np.column_stack([np.arctan2(z, level), none, np.arctan2(-x, y)]))
    return _continuous(np.column_stack([none, np.arctan2(level, z), np.arctan2(y, x)]))


def simplified(rows: Array, chord: float, sizes: Array | float = 1.0) -> Array:
    """Return fewer corners of a path that differs by at most a distance from the whole.

    Args:
        rows: A time and the entries of a pose each, shape (m, n).
        sizes: How far a unit of each entry is, shape (n-1,).

    Source: Douglas, Peucker, Algorithms for the reduction of the number of points required to
    represent a digitized line, Cartographica 10(2), 1973.
    """
    kept, pending = {0, len(rows) - 1}, [(0, len(rows) - 1)]
    while pending:
        a, b = pending.pop()
        share = ((rows[a : b + 1, 0] - rows[a, 0]) / (rows[b, 0] - rows[a, 0]))[:, None]
        line = rows[a, 1:] + share * (rows[b, 1:] - rows[a, 1:])
        off = (np.abs(rows[a : b + 1, 1:] - line) * sizes).sum(axis=1)
        worst = int(off.argmax())
        if off[worst] > chord:
            kept.add(a + worst)
            pending += [(a, a + worst), (a + worst, b)]
    return rows[sorted(kept)]


def roll_pitch_yaw(turns: Array) -> Array:
    """Return continuous angles of rotations Rz(yaw) Ry(pitch) Rx(roll), shape (m, 3).

    Args:
        turns: Rotations, shape (m, 3, 3).
    """
    roll = np.arctan2(turns[:, 2, 1], turns[:, 2, 2])
    pitch = np.arcsin(np.clip(-turns[:, 2, 0], -1.0, 1.0))
    yaw = np.arctan2(turns[:, 1, 0], turns[:, 0, 0])
    return _continuous(np.column_stack([roll, pitch, yaw]))


def _continuous(angles: Array) -> Array:
    """Return roll, pitch and yaw (m, 3) of the same rotations, without jumps.

    Of the two triples that are a rotation's, each up to whole turns, that next to the one before is
    taken, so that what spins about one axis keeps the other two angles.
    """
    others = angles * (1.0, -1.0, 1.0) + math.pi
    found = np.empty_like(angles)
    before = np.zeros(3)
    for k, pair in enumerate(zip(angles, others, strict=True)):
        near = [at - whole_turns(at - before) for at in pair]
        before = found[k] = min(near, key=lambda at: float(np.abs(at - before).max()))
    return found
