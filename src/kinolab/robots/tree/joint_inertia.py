"""What resists the joints of a robot, beside what is only the rounding of a file's numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from kinolab.dynamics.language.lumped_mass import Lump
from kinolab.numerics.arrays import Array
from kinolab.robots.tree.kinematic_tree import (
    FREE,
    SIZES,
    Inertial,
    Joint,
    KinematicTree,
    Link,
    from_the_root,
    led,
    link_poses,
)

# Of a mass times the square of its length: a radius of gyration of a hundred-thousandth of the
# length, which a wire of 0.02 mm has beside a metre. Angles that a file rounds to five digits
# leave less.
NOISE = 1e-10


def reach(links: Iterable[tuple[Link, Array]]) -> float:
    """Return how far masses and shapes of links, with their poses (4, 4), are from the origin."""
    found = 0.0
    for link, pose in links:
        if link.inertial is not None:
            found = max(found, float(np.linalg.norm(pose[:3] @ [*link.inertial.centre, 1.0])))
        for solid in link.solids:
            arm = float(np.linalg.norm((pose @ solid.pose)[:3, 3]))
            size = max(float(getattr(solid.shape, name, 0.0)) for name in SIZES)
            found = max(found, arm + size)
    return found or 1.0  # [m] of what has neither shapes nor an arm


def together(links: Sequence[tuple[Link, Array]]) -> Inertial:
    """Return the mass properties of links in the frame in which their poses (4, 4) are given."""
    parts = [
        (link.inertial.mass, pose[:3, :3] @ link.inertial.centre + pose[:3, 3],
         pose[:3, :3] @ link.inertial.inertia @ pose[:3, :3].T)
        for link, pose in links
        if link.inertial is not None
    ]  # fmt: skip
    mass = sum(m for m, _, _ in parts)
    if len(parts) == 1 or mass <= 0.0:
        inertia = sum((own for _, _, own in parts), np.zeros((3, 3)))
        return Inertial(mass, parts[0][1] if parts else np.zeros(3), inertia)
    centre = sum((m * c for m, c, _ in parts), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for m, c, own in parts:  # parallel axes
        arm = c - centre
        inertia = inertia + own + m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Inertial(mass, centre, inertia)


def lump(stem: str, link: Link, pose: Array) -> Lump:
    """Return the mass properties of a link at a pose (4, 4); one without any weighs nothing."""
    own = link.inertial or Inertial(0.0, np.zeros(3), np.zeros((3, 3)))
    rows = (tuple(map(float, part.flat)) for part in (pose[:3, 3], pose[:3, :3], own.centre))
    at, turn, centre = rows
    return Lump(stem, at, turn, own.mass, centre, six(own.inertia))


def six(inertia: Array) -> tuple[float, ...]:
    """Return the entries xx, yy, zz, xy, xz, yz of an inertia (3, 3)."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia.tolist()
    return xx, yy, zz, xy, xz, yz


def without_noise(inertial: Inertial, length: float) -> Inertial:
    """Return a mass whose inertia is 0 where it is rounding, beside the length in [m] it has."""
    if np.abs(inertial.inertia).max() > NOISE * inertial.mass * length**2:
        return inertial
    return replace(inertial, inertia=np.zeros((3, 3)))


def without_resistance(tree: KinematicTree) -> Iterator[Joint]:
    """Yield the joints whose acceleration nothing resists but rounding.

    What a joint moves, with all that follows it, is compared with its mass times the square of its
    length, in random positions of all joints: a mass on the axis may be beside it in others.
    Joints below which a loop closes, or something turns freely, are resisted by these as well.
    """
    joints = {joint.name: joint for joint in tree.joints}
    below, together = _links_below(tree), _moving_together(joints)
    free = {end for loop in tree.closures for end in (loop.first, loop.second)}
    free |= {one.child for one in tree.joints if one.kind in FREE}
    suspects = {
        name: [(one, factor, below[one.child]) for one, factor in led]
        for name, led in together.items()
        if not any(link.name in free for one, _ in led for link in below[one.child])
    }
    generator = np.random.default_rng(0)
    for _ in range(3):  # random ones, in which a joint must resist at least once
        at = {name: float(generator.uniform(-1.0, 1.0)) for name in together}
        poses = link_poses(tree, at)
        suspects = {name: led for name, led in suspects.items() if _is_noise(led, poses)}
    yield from (joints[name] for name in suspects)


_Led: TypeAlias = list[tuple[Joint, float, list[Link]]]  # joint, rate per leader's, what it moves


def _is_noise(led: _Led, poses: Mapping[str, Array]) -> bool:
    """Whether the inertia that joints feel which move together is 0 but for rounding."""
    inertia = scale = 0.0
    moving: dict[str, tuple[Link, Array]] = {}
    for joint, factor, links in led:
        pose = poses[joint.child]
        axis, anchor = pose[:3, :3] @ joint.axis, pose[:3] @ [*joint.anchor, 1.0]
        turns = joint.kind == "revolute"
        rate = np.concatenate([axis, np.cross(anchor, axis)] if turns else [np.zeros(3), axis])
        for link in links:
            _, before = moving.get(link.name, (link, np.zeros(6)))
            moving[link.name] = link, before + factor * rate
        inertia += factor**2 * joint.armature
        about = np.eye(4)
        about[:3, 3] = -anchor
        length = reach((link, about @ poses[link.name]) for link in links) if turns else 1.0
        mass = sum(link.inertial.mass for link in links if link.inertial is not None)
        scale += mass * (factor * length) ** 2
    for link, rate in moving.values():
        if link.inertial is not None:
            pose, (turn, slide) = poses[link.name], np.split(rate, 2)
            centre, own = pose[:3] @ [*link.inertial.centre, 1.0], pose[:3, :3].T @ turn
            speed = slide + np.cross(turn, centre)
            inertia += link.inertial.mass * float(speed @ speed)
            inertia += float(own @ link.inertial.inertia @ own)
    return bool(inertia <= NOISE * scale)


def _links_below(tree: KinematicTree) -> dict[str, list[Link]]:
    """Return what each link carries, itself included."""
    below = {link.name: [link] for link in tree.links}
    for joint in reversed([*from_the_root(tree)]):
        below[joint.parent] += below[joint.child]
    return below


def _moving_together(joints: Mapping[str, Joint]) -> dict[str, list[tuple[Joint, float]]]:
    """Return, by the name of each joint with a position of its own, all that move with it."""
    found: dict[str, list[tuple[Joint, float]]] = {}
    for joint in joints.values():
        if joint.kind in ("revolute", "prismatic"):
            leader, factor, _ = led(joint, joints)
            found.setdefault(leader, []).append((joint, factor))
    return found
