"""A robot as a tree of links and joints with numbers for parameters, as files describe it."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np

from kinolab.dynamics.language.shapes import Shape
from kinolab.numerics.arrays import Array
from kinolab.robots.actuation.actuators import Actuator, Aim, Motor, Tendon, Thruster
from kinolab.robots.tree.constant_frames import turned_about
from kinolab.world.shapes.shape_surfaces import Faces

SIZES = ("x", "y", "z", "radius", "length")  # that shapes of robots may have, in [m]

FREE = ("ball", "planar", "floating")  # kinds of joints with several coordinates
JointKind: TypeAlias = Literal["fixed", "revolute", "prismatic", "ball", "planar", "floating"]


@dataclass(frozen=True)
class Inertial:
    """Mass properties of a link, in its axes.

    Attributes:
        mass: In [kg].
        centre: Centre of mass, shape (3,), in [m].
        inertia: About the centre of mass, shape (3, 3), in [kg m^2].
    """

    mass: float
    centre: Array
    inertia: Array


@dataclass(frozen=True)
class PlacedShape:
    """A shape that is fixed to a link.

    Attributes:
        shape: Centred at the origin of its own frame and symmetric about z, if about any axis.
        pose: Of that frame in the link's, shape (4, 4).
        color: Red, green and blue in [0, 1], if the file says them.
        enclosed: Of a mesh, its points (n, 3) in the shape's frame.
    """

    shape: Shape
    pose: Array
    color: tuple[float, float, float] | None = None
    enclosed: Array | None = None


@dataclass(frozen=True)
class VisibleMesh:
    """A mesh that is drawn.

    Attributes:
        name: Of its file.
        vertices: In the link's frame in [m], shape (n, 3).
        faces: Shape (m, 3).
        colors: Red, green and blue in [0, 1] of each face, shape (m, 3), if the file says them.
    """

    name: str
    vertices: Array
    faces: Faces
    colors: Array | None = None


@dataclass(frozen=True)
class Link:
    """A rigid part of a robot; one without mass is only a frame or a shape.

    What is visible is drawn instead of its solids, which collide.

    Attributes:
        name: Its name.
        inertial: Its mass properties.
        solids: What collides.
        visible: What is drawn, if that is not its solids.
        stands: Whether it is part of the surroundings, fixed to the world: nothing that moves may
            touch it, but what rests on it or turns about it.
        hidden: Whether its solids are not drawn.
        borne: Which fraction of its weight is borne at its centre of mass, whatever it does.
    """

    name: str
    inertial: Inertial | None = None
    solids: tuple[PlacedShape, ...] = ()
    visible: tuple[VisibleMesh, ...] = ()
    stands: bool = False
    hidden: bool = False
    borne: float = 0.0


@dataclass(frozen=True)
class Mimicked:
    """A joint whose position is ``factor`` times that of another one, plus ``offset``."""

    joint: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Joint:
    """What connects a link to its parent; angles are in [rad], lengths in [m].

    Attributes:
        name: Its name.
        kind: How it moves; a planar one in the plane across its axis.
        parent, child: Names of the links.
        pose: Of the child's frame in the parent's, where the joint is at zero, shape (4, 4).
        axis: Unit vector in the child's frame, shape (3,).
        lower, upper: Limits of its position; of a ball joint, ``upper`` is its largest angle from
            the axes of its parent.
        speed: Largest magnitude of its rate.
        damping: Viscous friction in [N m s/rad] or [N s/m].
        friction: Coulomb friction in [N m] or [N].
        mimics: Which joint it follows, if any.
        anchor: Point of the child's frame that an axis passes through, shape (3,), in [m].
        zero: Position in which the child's frame is at ``pose``.
        armature: Inertia of its motor's rotor, as the joint feels it, in [kg m^2] or [kg].
        stiffness, rest: Of a spring, in [N m/rad] or [N/m], and where that is at rest.
        rests: Where the spring of a ball joint is at rest, a quaternion x, y, z, w; that of one
            that moves freely, a place and a quaternion.
        higher_damping: Coefficients of v |v|, v^3, …, in SI units.
        higher_stiffness: Coefficients of x^2, x^3, …, where x = 0 is at rest, in SI units.
        held: Whether it is fixed only because it is locked, or has no room between its limits.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    pose: Array = field(default_factory=lambda: np.eye(4))
    axis: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    lower: float = -math.inf
    upper: float = math.inf
    speed: float = math.inf
    damping: float = 0.0
    friction: float = 0.0
    mimics: Mimicked | None = None
    anchor: Array = field(default_factory=lambda: np.zeros(3))
    zero: float = 0.0
    armature: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    rests: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)
    higher_damping: tuple[float, ...] = ()
    higher_stiffness: tuple[float, ...] = ()
    held: bool = False


@dataclass(frozen=True)
class Closure:
    """What closes a loop of links: frames on two of them coincide, or only their origins do.

    Attributes:
        name: Its name.
        kind: ``"point"`` where the origins coincide, ``"pose"`` where the axes do, too.
        first, second: Names of the links.
        first_pose, second_pose: Of the frames in those of the links, shape (4, 4).
    """

    name: str
    kind: Literal["point", "pose"]
    first: str
    second: str
    first_pose: Array
    second_pose: Array


@dataclass(frozen=True)
class KinematicTree:
    """Links and the joints between them; exactly one link, the root, has no parent.

    Closures make loops of branches of the tree. Gravity is a vector of the world, in [m/s^2].
    ``allowed`` are the pairs of links, by name, that a file lets touch each other; ``notes`` say
    what of it is not read, or is something else in the machine.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    motors: tuple[Motor, ...] = ()
    gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)
    thrusters: tuple[Thruster, ...] = ()
    closures: tuple[Closure, ...] = ()
    actuators: tuple[Actuator, ...] = ()
    aims: tuple[Aim, ...] = ()
    tendons: tuple[Tendon, ...] = ()
    allowed: frozenset[frozenset[str]] = frozenset()
    notes: tuple[str, ...] = ()

    @property
    def root(self) -> Link:
        """The link that has no parent."""
        children = {joint.child for joint in self.joints}
        return next(link for link in self.links if link.name not in children)


def pose_of(xyz: Array, turn: Array) -> Array:
    """Return the pose (4, 4) with a position (3,) and a rotation matrix (3, 3)."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = turn, xyz
    return pose


def led(joint: Joint, joints: Mapping[str, Joint]) -> tuple[str, float, float]:
    """Return the joint that another one follows in the end, itself if none, factor and offset."""
    factor, offset = 1.0, 0.0
    while joint.mimics is not None:
        follows = joint.mimics
        factor, offset = factor * follows.factor, offset + factor * follows.offset
        joint = joints[follows.joint]
    return joint.name, factor, offset


def bound_by_followers(tree: KinematicTree) -> KinematicTree:
    """Return a tree whose leaders have the limits of their followers, too.

    A follower at f q + o within [a, b] keeps q between (a - o) / f and (b - o) / f, and its speed
    that of q. The lower limit of a leader is above the upper one if it has no position left.
    """
    joints = {joint.name: joint for joint in tree.joints}
    bound = dict(joints)
    for joint in tree.joints:
        name, factor, offset = led(joint, joints)
        leader = bound[name]
        if joint.mimics is None:
            continue
        if factor == 0.0:  # it stays where it is, which its limits allow or not
            ends = (-math.inf, math.inf) if joint.lower <= offset <= joint.upper else (1.0, -1.0)
        else:
            ends = ((joint.lower - offset) / factor, (joint.upper - offset) / factor)
            ends = min(ends), max(ends)
        bound[name] = replace(
            leader,
            lower=max(leader.lower, ends[0]),
            upper=min(leader.upper, ends[1]),
            speed=min(leader.speed, joint.speed / abs(factor) if factor else math.inf),
        )
    return replace(tree, joints=tuple(bound.values()))


def moved_to(joint: Joint, at: float) -> Array:
    """Return how a revolute or prismatic joint moves its child at a position, shape (4, 4)."""
    moved, by = np.eye(4), at - joint.zero
    if joint.kind == "prismatic":
        moved[:3, 3] = by * joint.axis
    else:
        moved[:3, :3] = turned_about(joint.axis, by)
        moved[:3, 3] = joint.anchor - moved[:3, :3] @ joint.anchor
    return moved


def from_the_root(tree: KinematicTree) -> Iterator[Joint]:
    """Yield the joints, each after the one that its parent hangs from."""
    below: dict[str, list[Joint]] = {}
    for joint in tree.joints:
        below.setdefault(joint.parent, []).append(joint)
    waiting = [tree.root.name]
    while waiting:
        for joint in below.get(waiting.pop(0), []):
            yield joint
            waiting.append(joint.child)


def link_poses(tree: KinematicTree, at: Mapping[str, float]) -> dict[str, Array]:
    """Return the poses (4, 4) of all links at positions of the joints with one of their own.

    Joints that are neither revolute nor prismatic are where the file has them.
    """
    joints = {joint.name: joint for joint in tree.joints}
    poses = {tree.root.name: np.eye(4)}
    for joint in from_the_root(tree):
        moves = joint.kind in ("revolute", "prismatic")
        leader, factor, offset = led(joint, joints)
        moved = moved_to(joint, factor * at[leader] + offset) if moves else np.eye(4)
        poses[joint.child] = poses[joint.parent] @ joint.pose @ moved
    return poses


def coordinate_names(joint: Joint) -> tuple[str, ...]:
    """Return the names of a joint's own coordinates; an attitude is the last one."""
    name = usable_name(joint.name)
    if joint.kind == "floating":
        return f"{name}_at_x", f"{name}_at_y", f"{name}_at_z", name
    if joint.kind == "planar":
        return f"{name}_x", f"{name}_y", f"{name}_angle"
    return (name,)


def usable_name(text: str) -> str:
    """Return a name for scenarios and equations: other characters become underscores."""
    name = re.sub(r"\W", "_", text.strip())
    return f"_{name}" if name[:1].isdigit() else name
