"""Machines as URDF files, for ROS, Drake and Pinocchio."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from kinolab.arguments import checked
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.shapes import ShapeKind
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.robots.actuation.actuators import Motor
from kinolab.robots.tree.constant_frames import elementary_turns, turned_about
from kinolab.robots.tree.kinematic_tree import Joint, KinematicTree, Link, PlacedShape, pose_of
from kinolab.robots.writing.file_numbers import FAR, limits, numbers
from kinolab.robots.writing.frame_chains import cleaned
from kinolab.robots.writing.machine_tree import WORLD_LINK, machine_tree

STRENGTH = 9.81  # [m/s^2] of gravity, which whatever reads URDF takes to point along -z
EQUAL = 1e-12  # relative
# Of what each kind of shape is made: names, and places along z in halves of its length.
PARTS: dict[ShapeKind, tuple[tuple[str, float], ...]] = {
    ShapeKind.BOX: (("box", 0.0),),
    ShapeKind.SPHERE: (("sphere", 0.0),),
    ShapeKind.CYLINDER: (("cylinder", 0.0),),
    ShapeKind.CAPSULE: (("cylinder", 0.0), ("sphere", 1.0), ("sphere", -1.0)),
    ShapeKind.HULL: (),
}
KINDS = {"fixed": "fixed", "prismatic": "prismatic", "floating": "floating"}


@checked
def urdf_text(system: Mechanism, *, partial: bool = False) -> str:
    """Return a machine as the text of a URDF file.

    Coordinates are joints of their names below the link ``world``, with their limits, speeds,
    damping and friction; bodies are links, and what is between joints are links without mass. What
    is free in space has a floating joint with the name of its attitude. Where a frame moves by a
    multiple of a coordinate, so does its joint. A joint's motor is its effort limit. Where gravity
    is not along -z, a fixed joint turns the machine upright, since files have no gravity. Friction
    is Coulomb's, smoothed at 0.01 m/s or rad/s, as ``read_urdf`` takes it. A capsule is a cylinder
    with two spheres. Requirements and cables have no place in the file.

    Args:
        partial: Whether to leave out what cannot be represented; accelerations differ then.

    Raises:
        InputError: With everything that cannot be represented: what ``mjcf_text`` cannot either,
            and gravity of another strength, attitudes without three translations before them,
            springs, rotors, motors whose limits are not alike in both directions, and forces on
            bodies that no joint has.
    """
    tree = machine_tree(system, _lacking, partial=partial).tree
    balls = [*_balls(tree)]
    if balls:
        raise InputError(balls)
    tree = _upright(tree)
    root = Element("robot", name=tree.name)
    for link in tree.links:
        _link(root, link)
    motors = {motor.joint: motor for motor in tree.motors}
    for joint in tree.joints:
        _joint(root, joint, motors.get(joint.name))
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


def _balls(tree: KinematicTree) -> Iterator[Mistake]:
    """Yield joints without which nothing would be left to write."""
    for joint in tree.joints:
        if joint.kind == "ball":
            what = "URDF has no joint that turns about every axis and nothing else."
            remedy = "Write MJCF, or put move(x, y, z) with coordinates before it, in the world."
            yield Mistake(f"rotation {joint.name!r}", what, remedy)


def _lacking(tree: KinematicTree) -> Iterator[Mistake]:
    """Yield what URDF has no words for."""
    yield from _balls(tree)
    strength = math.hypot(*tree.gravity)
    if abs(strength - STRENGTH) > EQUAL * STRENGTH:
        what = f"it is {strength:g} m/s^2, and a URDF file stands for {STRENGTH:g}."
        remedy = f'Take gravity=toward("-z", {STRENGTH:g}), or write MJCF.'
        yield Mistake("gravity", what, remedy)
    for joint in tree.joints:
        for has, word in ((joint.stiffness, "a spring"), (joint.armature, "a rotor")):
            if has:
                what = f"it has {word}, which URDF does not know."
                yield Mistake(f"joint {joint.name!r}", what, "Write MJCF.")
    for thruster in tree.thrusters:
        what = "it pushes a body, and motors of URDF act on single joints."
        yield Mistake(f"input {thruster.name!r}", what, "Write MJCF.")
    for link in tree.links:
        for solid in link.solids:
            if not PARTS[solid.shape.lowered()[0]]:
                what = f"URDF has no shape {solid.shape.called}, but in a mesh's file."
                yield Mistake(f"body {link.name!r}", what, "Write MJCF, or give it another shape.")
    driven = [motor.joint for motor in tree.motors]
    for motor in tree.motors:
        where = f"input {motor.name!r}"
        if abs(motor.lower + motor.upper) > EQUAL * motor.upper:
            what = f"its limits are {motor.lower:g} and {motor.upper:g}."
            remedy = "URDF has one for both directions: give a single number, or write MJCF."
            yield Mistake(where, what, remedy)
        if driven.count(motor.joint) > 1:
            what = f"another input acts on the joint {motor.joint}, too."
            yield Mistake(where, what, "A joint of URDF has one motor.")


def _upright(tree: KinematicTree) -> KinematicTree:
    """Return a tree that is turned as a whole, so that its gravity points along -z."""
    size = math.hypot(*tree.gravity)
    down = np.array(tree.gravity) / size if size else np.array([0.0, 0.0, -1.0])
    axis = np.cross(down, [0.0, 0.0, -1.0])
    sine = float(np.linalg.norm(axis))
    if sine == 0.0 and down[2] < 0.0:
        return tree
    axis = axis / sine if sine else np.array([1.0, 0.0, 0.0])
    turn = cleaned(turned_about(axis, math.atan2(sine, -down[2])))
    name = f"axes of {tree.name}"
    while name in [link.name for link in tree.links]:
        name += " itself"
    hung = [replace(j, parent=name if j.parent == WORLD_LINK else j.parent) for j in tree.joints]
    upright = Joint(f"{name} fixed", "fixed", WORLD_LINK, name, pose_of(np.zeros(3), turn))
    (world, *others) = tree.links
    return replace(tree, links=(world, Link(name), *others), joints=(upright, *hung))


def _link(root: Element, link: Link) -> None:
    element = SubElement(root, "link", name=link.name)
    if link.inertial is not None:
        inertial = SubElement(element, "inertial")
        SubElement(inertial, "mass", value=numbers([link.inertial.mass]))
        (xx, xy, xz), (_, yy, yz), (_, _, zz) = link.inertial.inertia.tolist()
        six = {"ixx": xx, "ixy": xy, "ixz": xz, "iyy": yy, "iyz": yz, "izz": zz}
        SubElement(inertial, "inertia", {key: numbers([entry]) for key, entry in six.items()})
    for use in ("visual", "collision"):
        for solid in link.solids:
            for pose, kind, size in _geometries(solid):
                drawn = SubElement(element, use)
                _origin(drawn, pose)
                SubElement(SubElement(drawn, "geometry"), kind, size)
                if use == "visual" and solid.color is not None:
                    material = SubElement(drawn, "material", name=f"{link.name} color")
                    SubElement(material, "color", rgba=numbers([*solid.color, 1.0]))


def _geometries(solid: PlacedShape) -> Iterator[tuple[Array, str, dict[str, str]]]:
    """Yield the shapes that URDF has: poses (4, 4), names and sizes; nothing of a hull."""
    kind, (x, y, z, *_) = solid.shape.lowered()
    sizes = {
        "box": {"size": numbers([2.0 * x, 2.0 * y, 2.0 * z])},
        "sphere": {"radius": numbers([x])},
        "cylinder": {"radius": numbers([x]), "length": numbers([2.0 * z])},
    }
    for name, offset in PARTS[kind]:
        at = pose_of(np.array([0.0, 0.0, offset * z]), np.eye(3))
        yield (solid.pose @ at if offset else solid.pose), name, sizes[name]


def _joint(root: Element, joint: Joint, motor: Motor | None) -> None:
    ends = limits(joint.lower, joint.upper)
    kind = KINDS.get(joint.kind, "continuous" if ends is None else "revolute")
    element = SubElement(root, "joint", name=joint.name, type=kind)
    SubElement(element, "parent", link=joint.parent)
    SubElement(element, "child", link=joint.child)
    _origin(element, joint.pose)
    if joint.kind in ("fixed", "floating"):
        return
    SubElement(element, "axis", xyz=numbers(joint.axis))
    if joint.mimics is not None:
        factor, offset = numbers([joint.mimics.factor]), numbers([joint.mimics.offset])
        SubElement(element, "mimic", joint=joint.mimics.joint, multiplier=factor, offset=offset)
    effort = abs(motor.gear) * max(-motor.lower, motor.upper) if motor else 0.0
    given: dict[str, Any] = {"effort": effort, "velocity": min(joint.speed, FAR)}
    if kind != "continuous":
        given["lower"], given["upper"] = ends or (-FAR, FAR)
    SubElement(element, "limit", {key: numbers([value]) for key, value in given.items()})
    if joint.damping or joint.friction:
        damping, friction = numbers([joint.damping]), numbers([joint.friction])
        SubElement(element, "dynamics", damping=damping, friction=friction)


def _origin(element: Element, pose: Array) -> None:
    if not np.array_equal(pose, np.eye(4)):
        turns = dict(elementary_turns(pose[:3, :3]))
        rpy = numbers(turns.get(axis, 0.0) for axis in ("x", "y", "z"))
        SubElement(element, "origin", xyz=numbers(pose[:3, 3]), rpy=rpy)
