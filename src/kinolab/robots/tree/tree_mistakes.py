"""What is wrong with a robot's description."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from kinolab.errors import Mistake, listed, printable, unknown_name
from kinolab.numerics.arrays import MULTIPLIABLE
from kinolab.robots.tree.constant_frames import ROUNDING
from kinolab.robots.tree.joint_inertia import NOISE, reach, without_resistance
from kinolab.robots.tree.kinematic_tree import (
    FREE,
    SIZES,
    Inertial,
    Joint,
    KinematicTree,
    Link,
    bound_by_followers,
    from_the_root,
    led,
    link_poses,
    usable_name,
)
from kinolab.robots.tree.urdf_inertials import breaks_triangle, moments
from kinolab.scenario.angles import WrittenAngle

WAYS_ON = (
    "To plan with speeds as inputs, write kinematic = true below [system]; to plan with forces, "
    "give links an <inertial>, or write density = 2700 [kg/m^3] for that of their geometry."
)


def tree_mistakes(
    tree: KinematicTree, locked: Mapping[str, float], where: str
) -> Iterator[Mistake]:
    """Yield what is no tree, names that nothing has or two things have, and wrong limits."""
    links = [link.name for link in tree.links]
    joints = [joint.name for joint in tree.joints]
    movable = [joint.name for joint in tree.joints if joint.kind in ("revolute", "prismatic")]
    yield from _twice("link", links, where)
    yield from _twice("joint", joints, where)
    for joint in tree.joints:
        place = f"{where} joint {joint.name!r}".strip()
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                yield unknown_name("link", name, known=sorted(links), where=f"{place} {end}")
        if joint.parent == joint.child:
            yield Mistake(place, f"it joins {joint.child} to itself.", "Give another parent.")
        if joint.mimics is not None and joint.mimics.joint in set(joints) - set(movable):
            what = f"{joint.mimics.joint}, which it follows, does not turn or slide."
            at = joint.mimics.offset
            yield Mistake(f"{place} mimic", what, f"Make it a fixed joint, which stays at {at:g}.")
        elif joint.mimics is not None and joint.mimics.joint not in movable:
            known = sorted(movable)
            yield unknown_name("joint", joint.mimics.joint, known=known, where=f"{place} mimic")
        magnitudes = {"friction": joint.friction, "armature": joint.armature}
        if not any(joint.higher_damping):
            magnitudes["damping"] = joint.damping
        for word, value in magnitudes.items():
            if value < 0.0:
                what = f"its {word} is {value:g}, and no magnitude is negative."
                yield Mistake(place, what, "Give a positive one, or 0 for none.")
        if not joint.lower <= joint.upper:
            what = f"its limits are {joint.lower:g} to {joint.upper:g}."
            yield Mistake(place, what, "The lower one must be below the upper one.")
    yield from _going_round(tree, where)
    for name in sorted({usable_name(joint) for joint in movable}):
        same = sorted({joint for joint in movable if usable_name(joint) == name})
        if len(same) > 1:
            yield Mistake(where, f"the joints {' and '.join(same)} would both be called {name}.")
    yield from _shape_mistakes(tree, where)
    yield from _mass_mistakes(tree, where)
    yield from _no_tree(tree, where)
    yield from _wrongly_locked(tree, locked, where)


def _wrongly_locked(
    tree: KinematicTree, locked: Mapping[str, float], where: str
) -> Iterator[Mistake]:
    """Yield what is locked and does not move, or moves with another joint, or has no position."""
    kinds = {joint.name: joint.kind for joint in tree.joints}
    leaders = {joint.name: joint.mimics.joint for joint in tree.joints if joint.mimics}
    for name, at in locked.items():
        movable = sorted(one for one, kind in kinds.items() if kind in ("revolute", "prismatic"))
        if name not in movable:
            yield unknown_name("joint", name, known=movable, where=f"{where} locked")
        elif isinstance(at, WrittenAngle) and (kinds[name] == "prismatic" or at.unit == "rad/s"):
            wanted = "a length in m" if kinds[name] == "prismatic" else "an angle"
            what = f"{at.text!r} is no position of {name}."
            yield Mistake(f"{where} locked {name}".strip(), what, f"Give {wanted}.")
        elif not math.isfinite(at):
            yield Mistake(f"{where} locked {name}".strip(), f"{at} is no position.")
        elif name in leaders:
            what = f"it follows {leaders[name]}, which would move without it."
            yield Mistake(f"{where} locked {name}".strip(), what, f"Lock {leaders[name]}.")


def locked_mistakes(
    tree: KinematicTree, locked: Mapping[str, float], where: str
) -> Iterator[Mistake]:
    """Yield positions beyond the limits of their joints, in a tree ``bound_by_followers``."""
    for joint in tree.joints:
        at = locked.get(joint.name, joint.lower)
        if not joint.lower <= at <= joint.upper:
            following = _following(tree, joint.name)
            included = f", those of {', '.join(following)} included" if following else ""
            what = f"{at} is beyond its limits, {joint.lower} to {joint.upper}{included}."
            yield Mistake(f"{where} locked {joint.name}".strip(), what, "Lock it within them.")


def follower_mistakes(tree: KinematicTree, where: str) -> Iterator[Mistake]:
    """Yield the joints whose followers leave them no position, in a tree without mistakes."""
    for joint in bound_by_followers(tree).joints:
        if joint.lower > joint.upper:
            shown = ", ".join(_following(tree, joint.name))
            what = f"its limits and those of {shown}, which it leads, exclude each other."
            remedy = "Some position must be within all of them, by factors and offsets."
            yield Mistake(f"{where} joint {joint.name!r}".strip(), what, remedy)


def _following(tree: KinematicTree, name: str) -> list[str]:
    """Return the joints that follow another one."""
    joints = {joint.name: joint for joint in tree.joints}
    return [one.name for one in tree.joints if one.mimics and led(one, joints)[0] == name]


def massless_joints(tree: KinematicTree, where: str) -> Iterator[Mistake]:
    """Yield the joints that move nothing with inertia: their acceleration would be infinite."""
    idle = {joint.name for joint in without_resistance(tree)}
    links = {link.name: link for link in tree.links}
    below: dict[str, float] = {}
    bare: list[Joint] = []
    for joint in reversed([*from_the_root(tree)]):
        own = links[joint.child].inertial
        moved = 0.0 if own is None else own.mass + float(np.abs(own.inertia).max())
        moved += sum(below[one.child] for one in tree.joints if one.parent == joint.child)
        below[joint.child] = moved
        place = f"{where} joint {joint.name!r}".strip()
        if joint.name in idle and moved > ROUNDING:
            what = f"it turns {joint.child} about its axis, about which that has no inertia."
            remedy = f"Give {joint.child} one beside rounding, or lock the joint."
            yield Mistake(place, what, remedy)
        elif joint.name in idle or (joint.kind in FREE and moved <= ROUNDING):
            bare.insert(0, joint)
    if len(bare) == 1:
        place, child = f"{where} joint {bare[0].name!r}".strip(), bare[0].child
        what = f"it moves {child}, which has no inertia, and nothing else."
        yield Mistake(place, what, f"Give {child} an inertia, or lock the joint. {WAYS_ON}")
    elif bare:
        children = listed(joint.child for joint in bare)
        what = f"the links {children} have no inertia, so that nothing resists the joints "
        yield Mistake(where, f"{what}{listed(joint.name for joint in bare)}.", WAYS_ON)


def inertia_mistake(
    links: Sequence[Link], inertial: Inertial, length: float, where: str
) -> Mistake | None:
    """Return what is wrong with the mass properties of links that move together, if anything.

    Args:
        links: All of them.
        inertial: Their mass properties, ``without_noise``.
        length: How far they reach, in [m].
        where: What mistakes are reported for.
    """
    least = float(np.linalg.eigvalsh(inertial.inertia).min())
    # 1e-9 of the largest entry of an inertia matrix, which may be rounded
    rounded = 1e-9 * float(np.abs(inertial.inertia).max())
    if least < -max(rounded, NOISE * inertial.mass * length**2):
        what = f"its inertia has a negative principal moment, {least:.3g} kg m^2."
        remedy = "No body has; look at ixx, iyy, izz and the signs of the others."
        return Mistake(f"{where} link {links[0].name!r}".strip(), what, remedy)
    own = ((link.name, link.inertial.inertia) for link in links if link.inertial is not None)
    name, inertia = next((pair for pair in own if breaks_triangle(pair[1])), ("", np.eye(3)))
    if not name or not breaks_triangle(inertial.inertia):
        return None
    what = f"of its moments of inertia, {moments(inertia)}, one exceeds the sum of the others."
    remedy = "No body has such. Mend them, or let balance_inertia = true take their mean."
    return Mistake(f"{where} link {name!r}".strip(), what, remedy)


def inertia_doubts(tree: KinematicTree) -> Iterator[str]:
    """Yield the links whose inertia no mass has that is within the robot.

    A mass m within a radius R of the root is nowhere farther than 2 R from its own centre, so that
    no moment of inertia is larger than m (2 R)^2.
    """
    names = [joint.name for joint in tree.joints if joint.mimics is None]
    places = link_poses(tree, dict.fromkeys(names, 0.0))
    radius = reach((link, places[link.name]) for link in tree.links)
    for link in tree.links:
        if link.inertial is not None:
            largest = float(np.linalg.eigvalsh(link.inertial.inertia).max())
            if largest > (most := link.inertial.mass * (2.0 * radius) ** 2):
                told = f"the inertia of {printable(link.name)} is {largest:.3g}; its mass and the"
                yield f"{told} robot's size allow at most {most:.3g}. Is it in kg m^2?"


def absent_names(
    linear: Mapping[str, tuple[str, float, float]], held: Mapping[str, float]
) -> Iterator[tuple[str, str]]:
    """Yield the names of joints that are no coordinates, and of their rates, with what they are.

    Args:
        linear: Coordinate, factor and offset of joints that follow others.
        held: Where those are that do not move.
    """
    told = {name: f"it is not a coordinate, but held at {at:g}." for name, at in held.items()}
    for name, (leader, factor, offset) in linear.items():
        told[name] = f"it follows {leader}: it is {factor:g} * {leader} + {offset:g}."
        told[name] += (
            f" Write {leader}, at (value - {offset:g}) / {factor:g}; rates have no offset."
        )
    for name, sentence in told.items():
        yield from ((usable_name(name), sentence), (f"{usable_name(name)}_dot", sentence))


def _twice(kind: str, names: Sequence[str], where: str) -> Iterator[Mistake]:
    for name in sorted({name for name in names if names.count(name) > 1}):
        yield Mistake(f"{where} {kind} {name!r}".strip(), f"two {kind}s have this name.")


def _going_round(tree: KinematicTree, where: str) -> Iterator[Mistake]:
    """Yield the joints that follow each other in a circle."""
    follows = {joint.name: joint.mimics.joint for joint in tree.joints if joint.mimics}
    for name, first in follows.items():
        leader, seen = first, {name}
        while leader in follows and leader not in seen:
            seen.add(leader)
            leader = follows[leader]
        if leader == name:
            what = "it mimics a joint that mimics it."
            yield Mistake(f"{where} joint {name!r}".strip(), what)


def _shape_mistakes(tree: KinematicTree, where: str) -> Iterator[Mistake]:
    """Yield shapes without size."""
    for link in tree.links:
        for solid in link.solids:
            sizes = [
                float(getattr(solid.shape, name)) for name in SIZES if hasattr(solid.shape, name)
            ]
            if not all(math.isfinite(size) and size > 0.0 for size in sizes):
                kind = solid.shape.called.lower()
                what = f"its {kind} has the sizes {', '.join(f'{size:g}' for size in sizes)}."
                yield Mistake(f"{where} link {link.name!r}".strip(), what, "Give positive ones.")


def _mass_mistakes(tree: KinematicTree, where: str) -> Iterator[Mistake]:
    """Yield masses and inertias whose products are no numbers of a computer."""
    _, largest = MULTIPLIABLE  # in [kg] and [kg m^2]
    for link in tree.links:
        given = [] if link.inertial is None else [link.inertial.mass, *link.inertial.inertia.flat]
        for value in sorted({value for value in given if abs(value) > largest}):
            what = f"{value:g} is a mass or an inertia beyond {largest:g}."
            yield Mistake(f"{where} link {link.name!r}".strip(), what, "Give it in kg and metres.")


def _no_tree(tree: KinematicTree, where: str) -> Iterator[Mistake]:
    """Yield what keeps the links from hanging from one root."""
    children = [joint.child for joint in tree.joints]
    for name in sorted({name for name in children if children.count(name) > 1}):
        what = "it is the child of two joints; a loop cannot be written that way."
        yield Mistake(f"{where} link {name!r}".strip(), what)
    if len({*children}) < len(children):  # what hangs below them may go round
        return
    roots = [link.name for link in tree.links if link.name not in children]
    if len(roots) != 1:
        shown = f"{', '.join(roots[:5])} have none" if roots else "every link has one"
        yield Mistake(where, f"exactly one link must have no parent; {shown}.")
        return
    reached = {roots[0], *(joint.child for joint in from_the_root(tree))}
    for link in tree.links:
        if link.name not in reached:
            what = f"no chain of joints leads from {roots[0]} to it."
            yield Mistake(f"{where} link {link.name!r}".strip(), what)
