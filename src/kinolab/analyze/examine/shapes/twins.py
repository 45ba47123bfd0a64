"""Bodies of a left and a right side: whether each moves with the coordinates of its own."""

from __future__ import annotations

import re
from collections.abc import Iterator

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject

SIDES = {"left": "right", "l": "r"}
OTHER = {**SIDES, **{right: left for left, right in SIDES.items()}}


def twins(subject: Subject) -> Iterator[Remark]:
    """Yield the bodies of one side that move with a coordinate of the other as their twins do not.

    Sides are words of names, as in ``left forearm`` and ``f_l``.
    """
    bodies = {body.name: body for body in subject.system.bodies}
    known = {c.name for c in subject.system.coordinates}
    for name, body in bodies.items():
        twin = bodies.get(mirrored(name))
        if twin is None or twin is body:
            continue
        own, wanted = subject.moving(body.frame), set(map(mirrored, subject.moving(twin.frame)))
        strange = sorted(c for c in own - wanted if mirrored(c) in wanted - own)
        if strange and wanted <= known and _side(strange[0]) != _side(name):
            what = f"It moves with {strange[0]}, and {twin.name} moves with "
            what += f"{' and '.join(sorted(subject.moving(twin.frame)))}: of the other side, it "
            what += f"would be {mirrored(strange[0])}. So it does not follow what that moves."
            yield Remark("moves with the other side", name, what, ("Body", name))


def required(subject: Subject) -> Iterator[Remark]:
    """Yield what is required of one side and broken at rest, where its twin holds."""
    model, wanted = subject.model, subject.system.requirements
    margins = model.requirements(subject.rest, model.null_control()) if wanted else ()
    held = {one.name: bool(m >= 0) for one, m in zip(wanted, margins, strict=True)}
    for name in (name for name, holds in held.items() if not holds):
        if mirrored(name) != name and held.get(mirrored(name), False):
            what = (
                f"It is broken where the machine is at rest, and {mirrored(name)!r} holds there: "
            )
            what += "a margin is positive where it holds, so its sign may be wrong."
            yield Remark("required of one side only", name, what, ("require", name))


def mirrored(name: str) -> str:
    """Return a name with the words of its side exchanged: ``right arm`` for ``left arm``."""
    return "".join(OTHER.get(word, word) for word in re.split(r"([^A-Za-z]+)", name))


def _side(name: str) -> str:
    words = re.split(r"[^A-Za-z]+", name)
    return next(("left" if w in SIDES else "right" for w in words if w in OTHER), "")
