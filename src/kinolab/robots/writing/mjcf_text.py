"""Machines as MJCF files, which MuJoCo opens."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.shapes import ShapeKind
from kinolab.errors import Mistake
from kinolab.numerics.arrays import Array
from kinolab.numerics.manifolds.rotations import of_matrices
from kinolab.robots.tree.kinematic_tree import (
    Inertial,
    Joint,
    KinematicTree,
    Link,
    PlacedShape,
    moved_to,
    pose_of,
)
from kinolab.robots.writing.file_numbers import limits, numbers
from kinolab.robots.writing.machine_tree import WORLD_LINK, MachineTree, machine_tree

LEAST = 1e-14  # [kg] and [kg m^2]: what MuJoCo demands of all that moves is 1e-15
KINDS = {"revolute": "hinge", "prismatic": "slide", "ball": "ball"}
GEOMS = {
    ShapeKind.BOX: ("box", (0, 1, 2)),
    ShapeKind.SPHERE: ("sphere", (0,)),
    ShapeKind.CYLINDER: ("cylinder", (0, 2)),
    ShapeKind.CAPSULE: ("capsule", (0, 2)),
}


@checked
def mjcf_text(system: Mechanism, *, partial: bool = False) -> str:
    """Return a machine as the text of an MJCF file: its accelerations in MuJoCo are those of ``f``.

    Coordinates are hinges, slides and balls of their names, and a body that is free in space has a
    free joint with the name of its attitude. Where a frame moves by a multiple of a coordinate, so
    does its joint. Inputs are motors of joints, or of sites on the bodies that they push.
    Parameters have their values. Contacts are switched off, since nothing pushes that touches;
    limits of rates, requirements and cables have no place in the file. Joints that move with the
    same coordinate are coupled, which MuJoCo does softly; and of all that moves it demands a mass
    and an inertia, which are 1e-14 where there are none.

    Args:
        partial: Whether to leave out what cannot be represented; accelerations differ then.

    Raises:
        InputError: With everything that cannot be represented: frames that are not linear in
            coordinates, constraints, modes, feedback, forces that no joint and no site has, and
            Coulomb friction, unless it is zero.
    """
    root = _Writer(machine_tree(system, _lacking, partial=partial)).root()
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _lacking(tree: KinematicTree) -> Iterator[Mistake]:
    """Yield what MJCF has no words for."""
    for joint in tree.joints:
        if joint.friction:
            what = "MuJoCo's frictionloss is another law: it is not smoothed."
            yield Mistake(f"Coulomb friction of {joint.name}", what, "Set its strength to 0.")


class _Writer:
    def __init__(self, made: MachineTree) -> None:
        self._tree, self._frames = made.tree, made.frames
        self._links, self._assets = {link.name: link for link in made.tree.links}, Element("asset")
        self._below: dict[str, list[Joint]] = {name: [] for name in self._links}
        for joint in made.tree.joints:
            self._below[joint.parent].append(joint)

    def root(self) -> Element:
        """Return the whole file."""
        tree = self._tree
        root = Element("mujoco", model=tree.name)
        SubElement(root, "compiler", angle="radian", inertiafromgeom="false")
        option = SubElement(root, "option", gravity=numbers(tree.gravity), integrator="RK4")
        SubElement(option, "flag", contact="disable")
        root.append(self._assets)
        world = SubElement(root, "worldbody")
        self._hang(world, WORLD_LINK, np.eye(4))
        if not len(self._assets):
            root.remove(self._assets)
        self._couple(root, [joint for joint in tree.joints if joint.mimics])
        self._actuate(root, tree)
        return root

    def _hang(self, element: Element, link: str, pose: Array, done: Joint | None = None) -> None:
        """Write what hangs from a link, which is at a pose (4, 4) in an element's frame."""
        for joint in self._below[link]:
            if joint is done:
                continue
            if joint.kind != "fixed":
                self._moving(element, joint, pose @ joint.pose)
                continue
            child = self._body(element, joint.child, pose @ joint.pose)
            self._fill(child, joint.child, moves=False)
            self._hang(child, joint.child, np.eye(4))

    def _moving(self, element: Element, first: Joint, pose: Array) -> None:
        """Write a body with a joint, and with those that follow without a body between them.

        Frames between joints need no bodies of their own, which would need mass: axes may be
        anywhere in the last one.
        """
        joints: list[tuple[Joint, Array]] = [(first, np.eye(4))]
        link, done = first.child, None
        pose = pose @ _motion(first)
        while link in self._frames and done is None:
            following = self._following(link)
            balls = any(joint.kind in ("ball", "floating") for joint, _ in joints)
            onward = following.pose @ _motion(following) if following else np.eye(4)
            turned = not np.array_equal(onward[:3, :3], np.eye(3))
            if following is None or (balls and turned) or first.kind == "floating":
                break
            pose = pose @ onward
            joints = [(joint, before @ onward) for joint, before in joints]
            if following.kind == "fixed":
                done = following
            else:
                joints.append((following, np.eye(4)))
                link = following.child
        name = done.child if done else link
        body = self._body(element, name, pose)
        for joint, before in joints:
            self._joint(body, joint, _inverse(before))
        self._fill(body, name, moves=True)
        if done:
            self._hang(body, done.child, np.eye(4))
            self._hang(body, link, _inverse(done.pose), done)
        else:
            self._hang(body, link, np.eye(4))

    def _following(self, link: str) -> Joint | None:
        """Return the body that a frame is written with, or the only joint that hangs from it."""
        fixed = [joint for joint in self._below[link] if joint.kind == "fixed"]
        massive = [joint for joint in fixed if self._links[joint.child].inertial]
        if fixed:
            return (massive or fixed)[0]
        return self._below[link][0] if len(self._below[link]) == 1 else None

    def _body(self, element: Element, name: str, pose: Array) -> Element:
        return SubElement(element, "body", {"name": name, **_placed(pose)})

    def _joint(self, body: Element, joint: Joint, back: Array) -> None:
        """Write a joint, whose frame is at a pose (4, 4) in that of its body."""
        if joint.kind == "floating":
            SubElement(body, "freejoint", name=joint.name)
            return
        element = SubElement(body, "joint", name=joint.name, type=KINDS[joint.kind])
        if joint.kind != "prismatic" and back[:3, 3].any():
            element.set("pos", numbers(back[:3, 3]))
        if joint.kind == "ball":
            return
        element.set("axis", numbers(back[:3, :3] @ joint.axis))
        ends = limits(joint.lower, joint.upper)
        if ends is not None:
            element.set("range", numbers(ends))
        given = {
            "ref": _rest(joint),
            "damping": joint.damping,
            "armature": joint.armature,
            "stiffness": joint.stiffness,
            "springref": joint.rest,
        }
        for key, value in given.items():
            if value:
                element.set(key, numbers([value]))

    def _fill(self, body: Element, name: str, *, moves: bool) -> None:
        """Write the mass and the shapes of a link."""
        link = self._links[name]
        inertial = link.inertial
        if moves and not any(map(_has_mass, self._fixed_to(name))):
            inertial = _least_mass(inertial)
        if inertial is not None:
            self._inertial(body, inertial)
        for solid in link.solids:
            _geom(body, solid, self._assets)

    def _fixed_to(self, name: str) -> Iterable[Link]:
        """Yield a link and those that are fixed to it."""
        yield self._links[name]
        for joint in self._below[name]:
            if joint.kind == "fixed":
                yield from self._fixed_to(joint.child)

    def _inertial(self, body: Element, inertial: Inertial) -> None:
        inertia = self._balanced(inertial.inertia)
        element = SubElement(
            body, "inertial", pos=numbers(inertial.centre), mass=numbers([inertial.mass])
        )
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = inertia.tolist()
        if xy or xz or yz:
            element.set("fullinertia", numbers([xx, yy, zz, xy, xz, yz]))
        else:
            element.set("diaginertia", numbers([xx, yy, zz]))

    @staticmethod
    def _balanced(inertia: Array) -> Array:
        """Return an inertia (3, 3) whose moments MuJoCo takes: none exceeds the sum of the others.

        It adds a rounding error where they are equal, as of a disk.
        """
        a, b, c = sorted(np.diag(inertia).tolist())
        if np.array_equal(inertia, np.diag(np.diag(inertia))) and a + b >= c:
            return inertia
        least, middle, largest = np.linalg.eigvalsh(inertia).tolist()
        # 1e-14, relative, of MuJoCo's principal moments
        lacking = largest - least - middle + 1e-14 * largest
        balanced: Array = inertia + max(lacking, 0.0) * np.eye(3)
        return balanced

    def _couple(self, root: Element, followers: list[Joint]) -> None:
        """Write which joints follow others."""
        if not followers:
            return
        joints = {joint.name: joint for joint in self._tree.joints}
        element = SubElement(root, "equality")
        for joint in followers:
            assert joint.mimics is not None
            follows = joint.mimics
            zeros = _rest(joint), _rest(joints[follows.joint])
            offset = follows.offset + follows.factor * zeros[1] - zeros[0]
            line = numbers([offset, follows.factor, 0, 0, 0])
            SubElement(element, "joint", joint1=joint.name, joint2=follows.joint, polycoef=line)

    def _actuate(self, root: Element, tree: KinematicTree) -> None:
        """Write the motors, and the sites of those that push bodies."""
        if not (tree.motors or tree.thrusters):
            return
        element = SubElement(root, "actuator")
        for motor in tree.motors:
            ends = numbers([motor.lower, motor.upper])
            made = SubElement(element, "motor", name=motor.name, joint=motor.joint, ctrlrange=ends)
            if motor.gear != 1.0:
                made.set("gear", numbers([motor.gear]))
        bodies = {body.get("name"): body for body in root.iter("body")}
        for thruster in tree.thrusters:
            site = SubElement(bodies[thruster.link], "site", name=thruster.name)
            site.attrib.update(_placed(thruster.pose))
            SubElement(
                element,
                "motor",
                name=thruster.name,
                site=thruster.name,
                gear=numbers([*thruster.force, *thruster.torque]),
                ctrlrange=numbers([thruster.lower, thruster.upper]),
            )


def _inverse(pose: Array) -> Array:
    """Return the inverse of a pose, shape (4, 4)."""
    turn = pose[:3, :3].T
    return pose_of(-turn @ pose[:3, 3], turn)


def _rest(joint: Joint) -> float:
    """Return the position in which a joint is written: zero, or the limit next to it."""
    return 0.0 if joint.kind == "fixed" else min(max(0.0, joint.lower), joint.upper)


def _motion(joint: Joint) -> Array:
    """Return how a joint moves what hangs from it to where it is written, shape (4, 4)."""
    rest = _rest(joint)
    return moved_to(joint, rest) if rest else np.eye(4)


def _geom(body: Element, solid: PlacedShape, assets: Element) -> None:
    kind, half = solid.shape.lowered()
    geom = SubElement(body, "geom")
    if kind in GEOMS:
        name, which = GEOMS[kind]
        geom.attrib.update(type=name, size=numbers(half[k] for k in which))
    else:  # MuJoCo makes a hull around points
        geom.attrib.update(type="mesh", mesh=f"hull {len(assets) + 1}")
        SubElement(assets, "mesh", name=geom.attrib["mesh"], vertex=numbers(half[3:]))
    geom.attrib.update(_placed(solid.pose))
    if solid.color is not None:
        geom.set("rgba", numbers([*solid.color, 1]))


def _has_mass(link: Link) -> bool:
    """Whether a link alone lets MuJoCo move it."""
    own = link.inertial
    return own is not None and min(own.mass, float(np.linalg.eigvalsh(own.inertia).min())) >= LEAST


def _least_mass(inertial: Inertial | None) -> Inertial:
    """Return mass properties that MuJoCo takes of what moves."""
    own = inertial or Inertial(0.0, np.zeros(3), np.zeros((3, 3)))
    small = np.linalg.eigvalsh(own.inertia).min() < LEAST
    inertia = own.inertia + LEAST * np.eye(3) if small else own.inertia
    return Inertial(max(own.mass, LEAST), own.centre, inertia)


def _placed(pose: Array) -> dict[str, str]:
    """Return a pose (4, 4) as attributes, what is left out being zero."""
    found = {}
    if pose[:3, 3].any():
        found["pos"] = numbers(pose[:3, 3])
    if not np.array_equal(pose[:3, :3], np.eye(3)):
        x, y, z, w = of_matrices(pose[:3, :3])
        x, y, z, w = (-part if w < 0.0 else part for part in (x, y, z, w))
        found["quat"] = numbers([w, x, y, z])
    return found
