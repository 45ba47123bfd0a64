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
        plain = [c for c in owners if isinstance(c, Coordinate)]
        turned = [c for c in plain if c.unit == "rad"]
        run_off = sorted((c for c in plain if c.unit == "m"), key=str)  # lengths of one rope
        if len(plain) != len(owners) or len(turned) != 1 or not run_off:
            continue
        turn, *runs = (constraint.velocity.diff(RateSymbol(c)) for c in (*turned, *run_off))
        try:
            ratios = [abs(system.number(turn / run)) for run in runs]
        except TypeError:
            continue  # it depends on the coordinates
        ratio, radii = ratios[0], _turned(subject, turned[0])
        fits = any(abs(ratio - radius) <= ROUNDING * ratio for _, radius in radii)
        if fits or np.ptp(ratios) > ROUNDING * ratio:
            continue
        for name, radius in radii:
            if abs(ratio - 2 * radius) <= ROUNDING * ratio:
                what = f"By {constraint.name!r}, {run_off[0]} runs by {ratio:.4g} m where {name} "
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


def _turned(subject: Subject, coordinate: Coordinate) -> list[tuple[str, float]]:
    """Return the radii in [m] of the round shapes of bodies that a coordinate turns in place."""
    found: list[tuple[str, float]] = []
    k, round_ = subject.plain[coordinate], {ShapeKind.SPHERE, ShapeKind.CYLINDER}
    for body in subject.system.bodies:
        spin = subject.spin(body, subject.rest)[:, k]
        still = not subject.poses_by(subject.rest)[subject.place_of(body), :, 3, k].any()
        if still and np.abs(spin).max() > ROUNDING:
            kinds = [sizes(shape) for shape in subject.system.resolved_shapes(body)]
            found += [(body.name, float(half[0])) for kind, half in kinds if kind in round_]
    return found
