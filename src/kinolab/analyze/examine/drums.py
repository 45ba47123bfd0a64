"""Drums, sheaves and pinions: how far a constraint lets run what they wind."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.analyze.examine.shapes.rolling import ROUNDING, round_shape
from kinolab.dynamics import Coordinate
from kinolab.dynamics.language.mechanism_parts import atoms_of
from kinolab.dynamics.language.symbols import RateSymbol
from kinolab.world.geometry import sizes


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
