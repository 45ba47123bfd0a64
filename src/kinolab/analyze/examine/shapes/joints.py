"""Bodies that touch at rest and part as the machine moves, or as a parameter changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations, product

import numpy as np

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.shapes.touching_bodies import APART, TOUCHING, TouchingBodies
from kinolab.dynamics import Body, Coordinate, Parameter
from kinolab.dynamics.language.constraints import PositionConstraint
from kinolab.dynamics.language.mechanism_parts import atoms_of

SMALL, HALF, LARGE = 0.15, 0.5, 1.0  # shares of how far a coordinate may move
CHANGED = 1.05  # a parameter's value, relative to its own


def parted(contact: TouchingBodies) -> Iterator[Remark]:
    """Yield that two bodies part by a coordinate that moves both, or by two that should not."""
    subject = contact.subject
    if contact.other is not None and not subject.rests_within_limits:
        return  # nothing has to touch where it may not be
    plain = [c for c in subject.plain if c.name in contact.moved_by]
    near = HALF if contact.other is None else SMALL  # the ground has no end
    kept = [c for c in plain if all(_together(contact, {c: way}) for way in (near, -near))]
    shared = contact.moved_together
    if contact.other is not None and not shared and contact.held:
        for coordinate, way in product(plain, (SMALL, -SMALL, LARGE, -LARGE)):
            if _apart(contact, {coordinate: way}):
                yield parting(contact, f"{coordinate} moves", (coordinate,), way)
                return
    for one, other in combinations(kept, 2):
        if contact.other is not None and not {one.name, other.name} & shared:
            continue  # joints of two parts of a chain, which may part
        shares = [{one: a, other: b} for a, b in product((near, -near), repeat=2)]
        if not all(_together(contact, share) for share in shares):
            yield parting(contact, f"{one} and {other} move together", (one, other))
            return
    for coordinate in (c for c in plain if c.name in shared and not _opens(contact, c)):
        along = [{}, *({c: way} for c in kept if c != coordinate for way in (SMALL, -SMALL))]
        for share, way in product(along, (SMALL, -SMALL, LARGE, -LARGE)):
            if _apart(contact, {**share, coordinate: way}):
                at = "".join(f" where {c} has moved" for c in share)
                yield parting(contact, f"{coordinate} moves{at}", (coordinate,))
                return


def _opens(contact: TouchingBodies, coordinate: Coordinate) -> bool:
    """Whether a coordinate moves two bodies in opposite ways, as it opens a hand.

    In frames whose factors are in the wrong order both turn, or move, the same way.
    """
    subject, x = contact.subject, contact.subject.rest
    k = subject.plain[coordinate]
    turns = [subject.spin(body, x)[:, k] for body in contact.pair]
    if np.abs(turns).max() > 1e-9:  # of velocities by coordinates: compiled derivatives are exact
        return bool(np.allclose(turns[0], -turns[1], atol=1e-9))
    one, other = (subject.poses_by(x)[subject.place_of(b), :, 3, k] for b in contact.pair)
    alone = len({subject.moving(body.frame) for body in contact.pair}) == 1  # neither carries
    return bool(alone and one @ other < 0)


def _together(contact: TouchingBodies, shares: dict[Coordinate, float]) -> bool:
    gap = contact.gap(contact.subject.moved(shares))
    return abs(gap) <= APART * contact.reach


def _apart(contact: TouchingBodies, shares: dict[Coordinate, float]) -> bool:
    return contact.gap(contact.subject.moved(shares)) > APART * contact.reach


def parting(
    contact: TouchingBodies, when: str, by: tuple[Coordinate, ...], way: float = SMALL
) -> Remark:
    """Say that two bodies part when coordinates move by a share of their spans."""
    share = dict.fromkeys(by, way)
    gap = contact.gap(contact.subject.moved(share))
    if contact.entangled and not contact.moved_together:
        what = f"At rest they stand in each other, and no longer where {when}: is the place of one "
        what += "of them wrong? Bodies pass through each other unless collisions= names them."
        return Remark("touches at rest only", contact.names, what, ("Body", contact.one.name))
    what = f"They touch at rest, and no longer where {when}"
    what += f" (a gap of {gap:.3g} m)" if gap > APART * contact.reach else ""
    if contact.other is not None and not contact.moved_together and contact.held:
        what += ". What joins them holds along another direction, and not along that: is a "
        what += "constraint missing, closed(…, …)?"
    else:
        what += ". Are the factors of a frame in the wrong order? a @ b moves by b along the axes "
        what += "that a has turned: what is carried begins with the frame of what carries it."
    return Remark("touches at rest only", contact.names, what, ("Body", contact.one.name))


def sized_otherwise(contact: TouchingBodies) -> Iterator[Remark]:
    """Yield the parameters by which frames move apart what shapes of fixed sizes keep touching."""
    system, rest = contact.subject.system, contact.subject.rest
    if abs(contact.gap(rest)) > TOUCHING * contact.reach:
        return
    pair = contact.pair
    held = [c for c in system.constraints if isinstance(c, PositionConstraint)]
    for parameter in _lengths(pair, held):
        value = system.parameter_values[parameter.name]
        gaps = [_gap(contact, {parameter.name: value * s}) for s in (CHANGED, 1 / CHANGED)]
        if not (value and max(map(abs, gaps)) > APART * contact.reach):
            continue
        stated = {a for part in held for a in atoms_of(part.position)}
        free = [b for b in pair if parameter not in _sizes(b)
                and parameter in {*atoms_of(b.frame), *stated}]  # fmt: skip
        fixed = min(free, key=lambda b: value not in _numbers(contact, b), default=None)
        chance = contact.other or (fixed and parameter not in atoms_of(fixed.frame))
        if fixed is None or (chance and value not in _numbers(contact, fixed)):
            continue  # of two bodies it may be by chance that they touch
        what = f"They touch, but with {parameter} = {value * CHANGED:.4g} m, 5 % more, "
        gap = gaps[0]
        what += (
            f"they are {gap:.3g} m apart"
            if gap > 0
            else (f"it is {-gap:.3g} m in the ground" if gap < 0 else "they are in each other")
        )
        word = "a frame" if parameter in atoms_of(fixed.frame) else "a constraint"
        what += f": {parameter} is in {word}, and the shape of {fixed.name} has a number in its "
        what += f"place. Shapes take parameters, too, such as Sphere({parameter})."
        yield Remark("size without its parameter", fixed.name, what, ("Body", fixed.name))
        return


def _gap(contact: TouchingBodies, values: dict[str, float]) -> float:
    subject = contact.subject
    return contact.gap(subject.on_constraints(subject.rest, **values), values)


def _lengths(bodies: tuple[Body, ...], held: Sequence[PositionConstraint]) -> list[Parameter]:
    """Return the lengths among the parameters in the frames of bodies, and in constraints."""
    parts = [*(body.frame for body in bodies), *(one.position for one in held)]
    found = {a for part in parts for a in atoms_of(part) if isinstance(a, Parameter)}
    return sorted((p for p in found if p.unit == "m"), key=str)


def _numbers(contact: TouchingBodies, body: Body) -> set[float]:
    """Return the sizes of a body's shapes."""
    shapes = contact.subject.system.resolved_shapes(body)
    return {float(getattr(shape, name)) for shape in shapes for name in shape.lengths()}


def _sizes(body: Body) -> set[Parameter]:
    return {a for a in atoms_of(body.shapes) if isinstance(a, Parameter)}
