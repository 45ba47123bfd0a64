"""Wheels that an input steers: about which axis, and to which sides."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.analyze.examine.shapes.carried import axis_of, depth_of, reach_of
from kinolab.analyze.examine.shapes.rolling import round_shape
from kinolab.dynamics import Body, Coordinate


def steering(subject: Subject) -> Iterator[Remark]:
    """Yield the wheels that are steered about an axis away from them, or to one side only."""
    for body in subject.system.bodies:
        if not body.touches_ground or round_shape(subject, body) is None:
            continue
        for coordinate in _steered(subject, body):
            axis = axis_of(subject, body, coordinate)
            # 0.3: sine of the angle up to which an axis counts as upright: forks are raked
            if axis is None or np.linalg.norm(axis[1][:2]) > 0.3:
                continue
            away = -depth_of(subject, body, axis)
            if away > 2 * reach_of(subject, body):
                what = f"{coordinate} turns it about an upright axis that passes {away:.3g} m away "
                what += "from it: it swings round instead of being steered. A frame turns after it "
                what += f"has moved to the wheel: base @ move(…) @ rot_z({coordinate})."
                yield Remark("steered about another point", body.name, what, ("Body", body.name))
            elif coordinate.lower == 0 or coordinate.upper == 0:
                what = f"It steers {body.name}, and its limits are {coordinate.lower:g} and "
                what += f"{coordinate.upper:g} rad: straight ahead is at the end, and it turns to "
                what += "one side only."
                yield Remark(
                    "steers to one side only", coordinate.name, what, ("angle", coordinate.name)
                )


def _steered(subject: Subject, body: Body) -> list[Coordinate]:
    """Return the angles that an input drives and that turn a body against what carries it."""
    bases = [one for one in subject.carriers(body) if subject.moving(one.frame)]
    shared = subject.moving(bases[0].frame) if bases else frozenset[str]()
    own = subject.moving(body.frame) - shared
    return [
        c for c in subject.plain if bases and c.unit == "rad" and c.name in own & subject.pushed
    ]
