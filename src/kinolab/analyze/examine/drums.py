"""Drums, sheaves and pinions: how far a constraint lets run what they wind."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.analyze.examine.shapes.rolling import NEAR, ROUNDING, round_shape
from kinolab.dynamics import Coordinate
from kinolab.dynamics.language.frames import distance, pose
from kinolab.dynamics.language.mechanism_parts import atoms_of
from kinolab.dynamics.language.shapes import ShapeKind
from kinolab.dynamics.symbols.symbols import RateSymbol
from kinolab.errors import KinolabError
from kinolab.world.shapes.geometry import frame_in_world, sizes


def drums(subject: Subject) -> Iterator[Remark]:
    """Yield the constraints by which a length runs off a round body twice as fast as its rim.

    Gears, screws and tackles have other ratios; just twice the radius is a diameter.
    """
    system = subject.system
    for constraint in system.constraints:
        rates = {a for a in atoms_of(constraint.velocity) if isinstance(a, RateSymbol)}
        owners = [rate.coordinate for rate in rates]
        by_unit = {c.unit: c for c in owners if isinstance(c, Coordinate)}
        if len(owners) != 2 or set(by_unit) != {"m", "rad"}:
            continue
        turn, run = (constraint.velocity.diff(RateSymbol(by_unit[u])) for u in ("rad", "m"))
        try:
            ratio = abs(system.number(turn / run))
        except TypeError:
            continue  # it depends on the coordinates
        radii = _turned(subject, by_unit["rad"])
        for name, radius in radii.items():
            twice = abs(ratio - 2 * radius) <= ROUNDING * ratio
            if twice and not any(abs(ratio - r) <= ROUNDING * ratio for r in radii.values()):
                what = f"By {constraint.name!r}, {by_unit['m']} runs by {ratio:.4g} m where {name} "
                what += f"turns by 1 rad, and its radius is {radius:.4g} m: its rim is half as "
                what += "fast. Is a diameter in the place of a radius?"
                yield Remark("runs by the diameter", name, what, ("zero", constraint.name))


def wound(subject: Subject) -> Iterator[Remark]:
    """Yield the cables that get longer as fast as the wheel that they run off takes them up.

    A rope that does not slip goes as the rim where it leaves a wheel: in the direction of its end.
    """
    system, x = subject.system, subject.rest
    try:
        moving, _ = subject.in_motion(x)
    except KinolabError:
        return
    values = system.substitutions
    values |= {c: float(x[k]) for c, k in subject.plain.items()}
    for cable, body in product(system.cables, system.bodies):
        shape = round_shape(subject, body)
        if shape is None or sizes(shape)[0] is not ShapeKind.CYLINDER:
            continue
        there = subject.poses(x)[subject.place_of(body)]
        axle, spin = frame_in_world(shape, there)[0][:, 2], subject.spin(body, x)
        for near, far in (cable.between, cable.between[::-1]):
            ends = [pose(frame)[1].subs(values) for frame in (near, far)]
            if any(end.free_symbols for end in ends) or not subject.moving(far):
                continue
            rim, end = (np.array(one, dtype=float)[:, 0] for one in ends)
            arm, way = rim - there[:, 3], end - rim
            arm, size = arm - (arm @ axle) * axle, float(np.linalg.norm(way))
            off = abs(float(np.linalg.norm(arm)) - float(sizes(shape)[1][0]))
            if off > NEAR * sizes(shape)[1][0] or size < ROUNDING:
                continue
            along = way / size
            paid_out = moving @ (np.cross(spin.T, arm) @ along)
            slopes = [distance(near, far).diff(c).subs(values) for c in subject.plain]
            longer = moving[:, [*subject.plain.values()]] @ np.array(slopes, dtype=float)
            if np.abs(longer + paid_out).max() <= ROUNDING * np.abs(longer).max(initial=0.0):
                what = f"{cable.name} runs off the rim of {body.name}, and gets longer where that "
                what += "takes it up: it cannot be wound on it. Is a sign in a constraint wrong? A "
                what += "rope over a wheel keeps the sum of its two lengths."
                yield Remark("winds the other way", body.name, what, ("Body", body.name))
                return


def _turned(subject: Subject, coordinate: Coordinate) -> dict[str, float]:
    """Return the radii in [m] of the round bodies that a coordinate turns in their place."""
    found, k = {}, subject.plain[coordinate]
    for body in subject.system.bodies:
        shape = round_shape(subject, body)
        spin = subject.spin(body, subject.rest)[:, k]
        still = not subject.poses_by(subject.rest)[subject.place_of(body), :, 3, k].any()
        if shape is not None and still and np.abs(spin).max() > ROUNDING:
            found[body.name] = float(sizes(shape)[1][0])
    return found
