"""Cables that are drawn where no force acts along them, and those that would push."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics import Cable, Coordinate, Frame
from kinolab.dynamics.derivation.derivation import is_kinematic
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.frames import pose
from kinolab.dynamics.language.inputs import Input
from kinolab.numerics.arrays import Array

STEP = 1e-3  # of a coordinate's scale, of differences
SEEN = 1e-6  # relative, of differences: changes of a length and of an energy


def ropes(subject: Subject) -> Iterator[Remark]:
    """Yield the cables that nothing joins to what pulls, and those that carry nothing."""
    system = subject.system
    words: tuple[Input | Effort, ...] = (*system.inputs, *system.efforts)
    both = [getattr(word, "between", None) for word in words]
    pulled = [ends for ends in both if isinstance(ends, tuple)]
    drawn = [cable for cable in system.cables if not any(_same(cable, ends) for ends in pulled)]
    for k, cable in enumerate(system.cables):
        if cable not in drawn or is_kinematic(system):
            continue
        changed = [c for c in subject.plain if _changes(subject, k, c)]
        yield from _beside(subject, cable, changed)
        for c in changed:
            if c.name not in subject.driven and _weighs(subject, c):
                what = f"Nothing holds {c.name}: no input, constraint or spring acts along it, and "
                what += (
                    f"the weight does. The cable {cable.name!r} is drawn and has no force: what "
                )
                what += "it does is a constraint, a Pull or a Rope."
                yield Remark("cable that holds nothing", cable.name, what, ("Cable", cable.name))
                break


def pushing_ropes(subject: Subject) -> Iterator[Remark]:
    """Yield the tensions along a cable that may be negative: a rope cannot push."""
    inputs = zip(subject.system.inputs, subject.model.control_bounds, strict=True)
    for entry, (lowest, _) in inputs:
        ends = getattr(entry, "between", None)
        if not isinstance(ends, tuple) or lowest >= 0:
            continue
        for cable in subject.system.cables:
            if _same(cable, ends):
                what = f"Its tension may be {lowest:g} {entry.unit}, and the cable {cable.name!r} "
                what += "along it cannot push. A single number as its limit means from 0 to it."
                part = (type(entry).__name__, entry.name)
                yield Remark("rope that pushes", entry.name, what, part)


def _beside(subject: Subject, cable: Cable, changed: list[Coordinate]) -> Iterator[Remark]:
    """Yield the tensions that act on one end of a cable and not toward its other end.

    Of a rope, which pulls by itself, the end that they share may be the fixed one.
    """
    pulling = [effort for effort in subject.system.efforts if hasattr(effort, "tension")]
    words: tuple[Input | Effort, ...] = (*subject.system.inputs, *pulling)
    for entry in words if changed else ():
        ends = getattr(entry, "between", None)
        if not isinstance(ends, tuple) or any(_same(c, ends) for c in subject.system.cables):
            continue
        fixed_too = entry in pulling
        alike = [end for end in ends if (end.moves or fixed_too) and end in cable.between]
        if len(alike) == 1:
            pulls, leads = (
                next(e for e in pair if e != alike[0]) for pair in (ends, cable.between)
            )
            what = f"It pulls {_named(subject, alike[0])} toward {_named(subject, pulls)}, and the "
            what += f"cable {cable.name!r} leads to {_named(subject, leads)}: between= names other "
            what += "frames than those of its cable."
            name = getattr(entry, "name", "")
            about, part = name or cable.name, (type(entry).__name__, name)
            yield Remark("pulls elsewhere than its cable", about, what, part)


def _same(cable: Cable, ends: tuple[Frame, ...]) -> bool:
    return all(end in cable.between for end in ends)


def _named(subject: Subject, frame: Frame) -> str:
    """Name a frame by the body that has it, or by where it is."""
    body = next((b for b in subject.system.bodies if b.frame == frame), None)
    if body is not None:
        return str(body.name)
    if not frame.motions:
        return "the origin of the world"
    for body in subject.system.bodies:
        count = len(body.frame.motions)
        rest = Frame(frame.motions[count:])
        if frame.motions[:count] == body.frame.motions and not rest.moves:
            at = pose(rest)[1].subs(subject.system.substitutions)
            return f"({', '.join(f'{float(entry):.4g}' for entry in at)}) of {body.name}"
    names = sorted(subject.moving(frame))
    return f"a point that moves with {' and '.join(names)}" if names else "a fixed point"


def _changes(subject: Subject, k: int, coordinate: Coordinate) -> bool:
    """Whether the length of a cable changes with a coordinate."""
    lengths = [
        float(np.linalg.norm(np.diff(subject.model.cables(x)[k], axis=0)))
        for x in _pair(subject, coordinate)
    ]
    return abs(lengths[1] - lengths[0]) > SEEN * coordinate.scale * STEP


def _weighs(subject: Subject, coordinate: Coordinate) -> bool:
    """Whether the potential energy changes with a coordinate."""
    below, above = (subject.model.energy(x)[1] for x in _pair(subject, coordinate))
    return bool(abs(above - below) > SEEN * STEP * max(1.0, abs(above)))


def _pair(subject: Subject, coordinate: Coordinate) -> tuple[Array, Array]:
    """Return two states beside each other along a coordinate, away from rest."""
    one = subject.moved(dict.fromkeys(subject.plain, 0.2))
    other = one.copy()
    other[subject.plain[coordinate]] += STEP * coordinate.scale
    return one, other
