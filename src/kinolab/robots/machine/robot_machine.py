"""From a kinematic tree to a machine: links are bodies, and what moves together has one mass."""

from __future__ import annotations

import logging
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeAlias

import numpy as np
import sympy

from kinolab.dynamics import System
from kinolab.dynamics.language import joint_friction, lumped_mass
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.constraints import PositionConstraint, Requirement, require
from kinolab.dynamics.language.forces import (
    Buoyancy,
    Effort,
    Gravity,
    Wrench,
)
from kinolab.dynamics.language.frames import WORLD, Axis, Frame, move, orient, squared_turn
from kinolab.dynamics.language.inputs import Force, Input, Torque
from kinolab.dynamics.language.joint_friction import JointFriction
from kinolab.dynamics.language.lumped_mass import LumpedMass
from kinolab.dynamics.language.offer import Offer
from kinolab.dynamics.language.quasi_velocities import State
from kinolab.dynamics.language.shapes import Box, Shape
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import (
    Attitude,
    Coordinate,
    MachineSymbol,
    angle,
    length,
    rate,
    rotation,
    turn_rate,
)
from kinolab.errors import InputError, Mistake, printable
from kinolab.numerics.arrays import Array
from kinolab.robots.actuation.actuator_words import (
    Command,
    actuator_efforts,
    aim_limits,
    beyond_rest,
    command,
    force_limits,
    length_limits,
    spring,
)
from kinolab.robots.actuation.actuators import Actuator, Length, Tendon, Thruster
from kinolab.robots.compared.disagreements import (
    AGREED,
    Correspondence,
    agreement_on,
    disagreements,
)
from kinolab.robots.compared.second_engine import AbstractSecondEngine
from kinolab.robots.compared.urdf_engines import BASE
from kinolab.robots.machine.given_motion import GivenMotion
from kinolab.robots.machine.self_collisions import NamedShape, kept_apart, kept_from_surroundings
from kinolab.robots.machine.visible_meshes import drawn_meshes
from kinolab.robots.tree.constant_frames import (
    TURNS,
    along_an_axis,
    constant_frame,
    onto_z,
    shortest_onto_z,
)
from kinolab.robots.tree.joint_inertia import lump, reach, six, together, without_noise
from kinolab.robots.tree.kinematic_tree import (
    Closure,
    Joint,
    KinematicTree,
    Link,
    PlacedShape,
    bound_by_followers,
    coordinate_names,
    from_the_root,
    led,
    moved_to,
    pose_of,
    usable_name,
)
from kinolab.robots.tree.loop_closures import closing_constraints
from kinolab.robots.tree.tree_mistakes import (
    absent_names,
    follower_mistakes,
    inertia_doubts,
    inertia_mistake,
    locked_mistakes,
    massless_joints,
)
from kinolab.world.shapes.geometry import lowest_z, sizes

Base: TypeAlias = Literal["fixed", "floating"]
BASE_COORDINATES = "x", "y", "z", BASE  # of a root that moves freely

ALIGNED = 1e-9  # of a rotation's entries: a shape that is turned less is taken along the axes


@dataclass
class _Part:
    """Links that are fixed to each other.

    Attributes:
        name: Of the first one.
        frame: Of the first one, where it moves.
        links: All, with their poses (4, 4) in that frame.
    """

    name: str
    frame: Frame
    links: list[tuple[Link, Array]] = field(default_factory=list)
    body: Body | None = None


_Moving: TypeAlias = tuple[Joint, _Part, _Part, Frame]  # with parent, child, and frame before it


def assembled(
    tree: KinematicTree,
    *,
    base: Base = "fixed",
    locked: Mapping[str, float] | None = None,
    self_collisions: bool = True,
    where: str = "",
    file: bytes = b"",
    engines: Iterable[AbstractSecondEngine] = (),
    given: GivenMotion | None = None,
) -> System:
    """Return the machine of a robot.

    Args:
        tree: The robot, without ``tree_mistakes``.
        base: Whether its root is fixed to the world or moves freely in it.
        locked: Positions of joints that do not move, by name.
        self_collisions: Whether links that are not neighbours may not touch each other.
        where: What mistakes are reported for.
        file: All that determines how the robot moves.
        engines: Which have read the same file; the machine is compared with them, once.
        given: What gives it its motion, whatever it weighs; None where forces do.

    Raises:
        InputError: With everything that the machine cannot have, or the joint that moves otherwise
            in an engine.
    """
    mistakes = [*follower_mistakes(tree, where)]
    mistakes += [] if given is None else given.mistakes(tree, base, where)
    if mistakes:
        raise InputError(mistakes)
    tree = tree if given is None else given.bounded(tree)
    tree = bound_by_followers(tree)
    mistakes = [*locked_mistakes(tree, locked or {}, where)]
    joints = {joint.name: joint for joint in tree.joints}
    held = _held(joints, locked or {})
    tree = replace(
        tree,
        joints=tuple(_fixed_at(joint, held) for joint in tree.joints),
        actuators=tuple(replace(a, along=a.along.beside(held)) for a in tree.actuators),
        aims=tuple(replace(a, along=a.along.beside(held)) for a in tree.aims),
        tendons=tuple(replace(t, along=t.along.beside(held)) for t in tree.tendons),
    )
    mistakes += massless_joints(tree, where) if given is None else given.unlimited(tree, where)
    if mistakes:
        raise InputError(mistakes)
    further = {BASE: BASE_COORDINATES} if base == "floating" else {}
    corresponding = Correspondence.of(joints, held, further)
    doubts = inertia_doubts(tree) if given is None else ()
    notes = [f"{where}: {told}" for told in (*tree.notes, *doubts)]
    assembly = _Assembly(tree, base, where, given)
    try:
        made = assembly.system(self_collisions=self_collisions)
        absent = absent_names(corresponding.linear, held)
        made = made.changed(notes=[*(("", told) for told in notes), *absent])
    except InputError as error:  # of what the machine's own words say
        raise InputError(_in_file(mistake, where) for mistake in error.mistakes) from error
    for told in notes:
        logging.getLogger("kinolab.robots").warning("%s", printable(told))
    if engines and given is None and AGREED.find(known := agreement_on(file, base, held)) is None:
        left_out = assembly.neglected
        efforts = made.efforts[: len(made.efforts) - len(assembly.driven)]
        passive = made
        if assembly.driven:
            passive = made.changed(efforts=efforts, states=(), requirements=())
        if mistakes := [*disagreements(passive, corresponding, engines, where, left_out)]:
            raise InputError(mistakes)
        AGREED.keep(known, b"")
    return made


def _in_file(mistake: Mistake, file: str) -> Mistake:
    """Return a mistake that says in which file it is."""
    where = mistake.where if mistake.where.startswith(file) else f"{file} {mistake.where}"
    return replace(mistake, where=where.strip())


class _Assembly:
    """A robot's machine in the making.

    Attributes:
        neglected: Moments of inertia that were rounding and are left out, in [kg m^2].
        driven: Forces of actuators, in which engines have no part.
    """

    def __init__(
        self, tree: KinematicTree, base: Base, where: str, given: GivenMotion | None
    ) -> None:
        self._tree, self._where, self._given, self.neglected = tree, where, given, 0.0
        self._mistakes: list[Mistake] = []
        self._links = {link.name: link for link in tree.links}
        self._base = WORLD if base == "fixed" else _floating(BASE_COORDINATES)[0]
        self._coordinates = {
            joint.name: _coordinate(joint)
            for joint in tree.joints
            if joint.kind in ("revolute", "prismatic") and joint.mimics is None
        }
        self._attitudes = {
            joint.name: rotation(usable_name(joint.name), speed=joint.speed)
            for joint in tree.joints
            if joint.kind == "ball"
        }
        self._places: dict[str, list[Coordinate]] = {}  # of joints that move freely
        self._inputs: list[Input] = []
        self._efforts: list[Effort] = []
        self.driven: list[Effort] = []
        self._states: list[State] = []
        self._bodies: list[Body] = []
        self._taken = {name for joint in tree.joints for name in coordinate_names(joint)}
        self._taken |= {one.name for one in tree.motors} | {one.name for one in tree.actuators}
        self._taken |= {one.name for one in tree.thrusters}
        self._shapes: list[NamedShape] = []
        self._constraints: list[PositionConstraint] = []
        self._requirements: list[Requirement] = []
        self._offers: list[Offer] = []
        self._drawn = drawn_meshes(tree)

    def system(self, *, self_collisions: bool) -> System:
        """Return the machine; links that may touch each other if wanted."""
        tree = self._tree
        root = _Part(tree.root.name, self._base)
        parts, at = [root], {tree.root.name: (root, np.eye(4))}
        root.links.append((tree.root, np.eye(4)))
        moving: list[_Moving] = []
        for joint in from_the_root(tree):
            parent, pose = at[joint.parent]
            pose = pose @ joint.pose
            child = self._links[joint.child]
            if joint.kind == "fixed":
                parent.links.append((child, pose))
                at[joint.child] = parent, pose
                continue
            before = parent.frame @ constant_frame(pose)
            part = _Part(joint.child, before @ self._motion(joint))
            part.links.append((child, np.eye(4)))
            at[joint.child] = part, np.eye(4)
            parts.append(part)
            moving.append((joint, parent, part, before))
        for part in parts:
            self._add_bodies(part, still=part is root and self._base is WORLD)
        for joint, *_ in moving:
            self._add_range(joint)
        if self._given is None:
            self._add_all_forces(moving, at)
        else:
            for joint, *_ in moving:
                self._inputs += self._given.inputs(joint, self._moved(joint))
        for closure in tree.closures:
            self._add_closure(closure, at)
        if self._mistakes:
            raise InputError(self._mistakes)
        made = System(
            usable_name(tree.name) or "robot",
            offers=self._offers,
            bodies=self._bodies,
            constraints=self._constraints,
            inputs=self._inputs,
            efforts=[*self._efforts, *self.driven],
            states=self._states,
            requirements=self._requirements,
            gravity=_gravity(tree.gravity) if self._given is None else None,
        )
        around, own = kept_from_surroundings(tree, self._shapes), kept_apart(tree, self._shapes)
        kept, unwatched = [*around.kept], [*around.unwatched, *own.unwatched]
        (kept if self_collisions else unwatched).extend(own.kept)
        return made.changed(collisions=kept, unwatched=unwatched) if kept or unwatched else made

    def _add_all_forces(
        self, moving: Sequence[_Moving], at: Mapping[str, tuple[_Part, Array]]
    ) -> None:
        """Add what pushes and what resists."""
        for joint, parent, part, before in moving:
            self._add_forces(joint, parent, part, before)
        for tendon in self._tree.tendons:
            self._add_tendon(tendon)
        for actuator in self._tree.actuators:
            self._add_actuator(actuator)
        for aim in self._tree.aims:
            length, speed = self._measured(aim.along)
            if speed != 0:
                self._requirements += aim_limits(aim, length, speed)
        for thruster in self._tree.thrusters:
            part, pose = at[thruster.link]
            self._add_thruster(thruster, part.frame @ constant_frame(pose @ thruster.pose))

    def _moved(self, joint: Joint) -> Sequence[MachineSymbol]:
        """Return the coordinates of a joint that follows none, and its angular velocity."""
        if joint.name in self._attitudes:
            turn = turn_rate(self._attitudes[joint.name])
            return [*self._places.get(joint.name, []), *turn]
        if joint.name in self._coordinates:
            return [self._coordinates[joint.name]]
        return self._places.get(joint.name, [])

    def _motion(self, joint: Joint) -> Frame:
        """Return how a joint moves, as a frame."""
        if joint.kind == "ball":
            there, back = (move(*(sign * joint.anchor).tolist()) for sign in (1.0, -1.0))
            turn = orient(self._attitudes[joint.name])
            return there @ turn @ back if joint.anchor.any() else turn
        if joint.kind == "floating":
            frame, place, attitude = _floating(coordinate_names(joint))
            self._places[joint.name], self._attitudes[joint.name] = place, attitude
            return frame
        if joint.kind == "planar":
            x, y, about = coordinate_names(joint)
            tilt = shortest_onto_z(joint.axis)
            turned, back = (constant_frame(pose_of(np.zeros(3), r)) for r in (tilt, tilt.T))
            speed = math.inf if self._given is None else joint.speed
            place = [length(x, speed=speed), length(y, speed=speed), angle(about, speed=speed)]
            self._places[joint.name] = place
            return turned @ move(*place[:2]) @ TURNS["z"](place[2]) @ back
        at: Any = self._position(joint)
        at = at - joint.zero if joint.zero else at
        if joint.kind == "prismatic":
            return move(*(float(entry) * at if entry else 0 for entry in joint.axis))
        turn = _turn(joint.axis, at)
        if not joint.anchor.any():
            return turn
        return move(*joint.anchor.tolist()) @ turn @ move(*(-joint.anchor).tolist())

    def _position(self, joint: Joint) -> sympy.Expr:
        """Return a joint's position: its own coordinate, or a function of another one's."""
        own, factor, offset = self._led(joint)
        return own if (factor, offset) == (1.0, 0.0) else factor * own + offset

    def _led(self, joint: Joint) -> tuple[Coordinate, float, float]:
        """Return the coordinate that a joint's position is linear in, factor and offset."""
        name, factor, offset = led(joint, {entry.name: entry for entry in self._tree.joints})
        return self._coordinates[name], factor, offset

    def _add_bodies(self, part: _Part, *, still: bool) -> None:
        """Add the links of a part as bodies in their own frames, and one with the mass of all."""
        inherit = {joint.parent for joint in self._tree.joints}
        color = next((s.color for link, _ in part.links for s in link.solids if s.color), None)
        first = len(self._bodies)
        for k, (link, pose) in enumerate(part.links):
            if k == 0 or link.solids or link.visible or link.name not in inherit:
                self._add_link(part, link, pose, color, still=still)
        part.body = self._bodies[-1]
        if not still and self._given is None:
            self._add_mass(part)
            self._add_lifts(part, self._bodies[first])

    def _add_lifts(self, part: _Part, body: Body) -> None:
        """Add what bears a fraction of the weight of each link, at its centre of mass."""
        strength = math.hypot(*self._tree.gravity)
        for own, pose, borne in ((link.inertial, pose, link.borne) for link, pose in part.links):
            if own is not None and (lift := borne * own.mass * strength):
                x, y, z = (pose[:3] @ [*own.centre, 1.0]).tolist()
                self._efforts.append(Buoyancy(on=body, lift=lift, at=(x, y, z)))

    def _add_mass(self, part: _Part) -> None:
        """Add the mass of all links of a part as a body, if they have any."""
        length, given = reach(part.links), together(part.links)
        inertial = without_noise(given, length)
        self.neglected += float(np.abs(given.inertia - inertial.inertia).sum())
        own = [link for link, _ in part.links]
        if mistake := inertia_mistake(own, inertial, length, self._where):
            self._mistakes.append(mistake)
        if not (inertial.mass > 0.0 or inertial.inertia.any()):
            return
        part.body = Body(
            f"{part.name} mass",
            part.frame @ constant_frame(pose_of(inertial.centre, np.eye(3))),
            mass=inertial.mass,
            inertia=six(inertial.inertia),
        )
        self._bodies.append(part.body)
        lumps = (
            lump(self._stem(link.name, lumped_mass.BEGINNINGS), link, pose)
            for link, pose in part.links
        )
        self._offers.append(LumpedMass(part.body.name, part.frame, tuple(lumps)))

    def _stem(self, name: str, beginnings: Sequence[str]) -> str:
        """Return what all parameters of a link or a joint are called after, as nothing else is."""
        stem, k = usable_name(name), 2
        while self._taken & (names := {f"{one}_{stem}" for one in beginnings}):
            stem, k = f"{usable_name(name)}_{k}", k + 1
        self._taken |= names
        return stem

    def _add_link(
        self,
        part: _Part,
        link: Link,
        pose: Array,
        color: tuple[float, float, float] | None,
        *,
        still: bool,
    ) -> None:
        """Add a link as a body with its shapes, those that are turned as bodies of their own."""
        aligned: list[Shape] = []
        turned: list[PlacedShape] = []
        for solid in link.solids:
            placed = solid.pose
            if still:
                placed = np.linalg.inv(pose) @ _onto_the_ground(solid.shape, pose @ placed)
            shape, own = along_the_axes(solid.shape, placed), replace(solid, pose=placed)
            if shape is None:
                turned.append(own)
            else:
                aligned.append(shape)
                self._shapes.append(NamedShape(link.name, link.name, own))
        look: dict[str, Any] = {"touches_ground": still, "color": color}
        frame = part.frame @ constant_frame(pose)
        drawn = () if link.hidden else self._drawn.get(link.name)
        self._bodies.append(Body(link.name, frame, shape=aligned, drawn=drawn, **look))
        look |= {} if drawn is None else {"drawn": ()}
        for k, solid in enumerate(turned):
            name, frame = f"{link.name} {k + 2}", part.frame @ constant_frame(pose @ solid.pose)
            self._bodies.append(Body(name, frame, shape=solid.shape, **look))
            self._shapes.append(NamedShape(name, link.name, solid))

    def _add_range(self, joint: Joint) -> None:
        """Require that a ball joint turns no farther than it may, an angle of 2 acos(|w|)."""
        if joint.name in self._attitudes and joint.upper < math.pi:
            turn = self._attitudes[joint.name]
            inside = turn.quaternion[3] ** 2 - math.cos(joint.upper / 2.0) ** 2
            self._requirements.append(require(inside, f"{joint.name} range"))

    def _add_forces(self, joint: Joint, parent: _Part, part: _Part, before: Frame) -> None:
        """Add a joint's motor and friction."""
        if joint.name in self._attitudes:
            turn, place = self._attitudes[joint.name], self._places.get(joint.name, [])
            self._add_friction(joint, [*map(rate, place), *turn_rate(turn)])
            self._add_ball_spring(joint, turn, place)
            if joint.armature > 0.0:
                rotor = f"{joint.name} rotor"
                own = (joint.armature,) * 3
                self._bodies.append(Body(rotor, orient(turn), inertia=own, located=False))
                self._bodies += [
                    self._weightless(f"{rotor} {at.name}", at, joint.armature) for at in place
                ]
        if joint.kind not in ("revolute", "prismatic"):
            return
        leader, factor, _ = self._led(joint)
        self._add_friction(joint, [factor * rate(leader) if joint.mimics else rate(leader)])
        at = self._position(joint)
        self._efforts += spring((joint.stiffness, *joint.higher_stiffness), at - joint.rest)
        if joint.armature > 0.0:
            self._bodies.append(self._rotor(joint, at))
        assert part.body is not None
        assert parent.body is not None
        axis = _axis(before, joint.axis)
        reacts_on = None if parent.frame is WORLD else parent.body
        for motor in self._tree.motors:
            if motor.joint != joint.name:
                continue
            limit = motor.lower, motor.upper
            self._inputs.append(
                Torque(motor.name, on=part.body, about=axis, limit=limit, reacts_on=reacts_on)
                if joint.kind == "revolute"
                else Force(motor.name, on=part.body, along=axis, limit=limit, reacts_on=reacts_on)
            )

    def _add_ball_spring(self, joint: Joint, turn: Attitude, place: Sequence[Coordinate]) -> None:
        """Add the spring of a joint that turns about every axis, and of its place if it is free.

        Only even powers of its distances have energies that are smooth at rest.
        """
        stiffness = joint.stiffness, *joint.higher_stiffness
        if not any(stiffness):
            return
        *at, x, y, z, w = joint.rests
        squares = [squared_turn(turn, (x, y, z, w))]
        if place:
            squares.append(sympy.Add(*((q - rest) ** 2 for q, rest in zip(place, at, strict=True))))
        for square in squares:
            self._efforts += spring(stiffness, sympy.sqrt(square))

    def _add_friction(self, joint: Joint, rates: Sequence[sympy.Expr]) -> None:
        """Add a joint's friction along each of its rates."""
        damping = joint.damping, *joint.higher_damping
        stem, turns = self._stem(joint.name, joint_friction.BEGINNINGS), joint.kind != "prismatic"
        given = JointFriction(stem, tuple(rates), damping, joint.friction, turns)
        self._efforts += given.efforts()
        if joint.kind not in ("planar", "floating"):  # whose rates have different units
            self._offers.append(given)

    def _measured(self, along: Length) -> tuple[sympy.Expr, sympy.Expr]:
        """Return a length of joints and its rate, which is 0 if all of them are held."""
        joints = {joint.name: joint for joint in self._tree.joints}
        length, speed = exact(along.offset), sympy.Integer(0)
        for name, each in along.joints.items():
            leader, factor, _ = self._led(joints[name])
            length += exact(each) * self._position(joints[name])
            speed += exact(each * factor) * rate(leader)
        return length, speed

    def _unit(self, along: Length) -> str:
        """Return the unit of a length, none of one to which joints both turn and slide."""
        kinds = {joint.name: joint.kind for joint in self._tree.joints}
        units = {"rad" if kinds[name] == "revolute" else "m" for name in along.joints}
        return units.pop() if len(units) == 1 else ""

    def _command(self, given: Actuator | Thruster, unit: str = "") -> Command:
        """Add an input and the state that follows it, if any, and return them."""
        follower = f"{given.name}_act"
        while follower in self._taken:
            follower += "_"
        ends = given.lower, given.upper
        made = command(given.name, *ends, through=given.filter, follower=follower, unit=unit)
        self._taken |= {one.name for one in made.states}
        self._inputs.append(made.input)
        self._states += made.states
        return made

    def _add_actuator(self, actuator: Actuator) -> None:
        """Add an input that acts along a length of joints, and limits of its force."""
        length, speed = self._measured(actuator.along)
        if speed == 0:
            return
        unit, gain = self._unit(actuator.along), actuator.gain[0]
        aims = {actuator.damping: f"{unit}/s", actuator.stiffness: unit} if unit else {}
        made = self._command(actuator, aims.get(gain, "") if gain else "")
        self.driven += actuator_efforts(actuator, made.symbol, length, speed)
        self._requirements += force_limits(actuator, made.symbol, length, speed)

    def _add_tendon(self, tendon: Tendon) -> None:
        """Add what resists a length of joints."""
        length, speed = self._measured(tendon.along)
        if speed == 0:
            return
        self._efforts += spring(tendon.stiffness, beyond_rest(tendon, length))
        stem, turns = self._stem(tendon.name, joint_friction.BEGINNINGS), self._unit(tendon.along)
        given = JointFriction(stem, (speed,), tendon.damping, tendon.friction, turns == "rad")
        self._efforts += given.efforts()
        if turns:
            self._offers.append(given)
        if tendon.armature:
            self._bodies.append(
                self._weightless(f"{tendon.name} armature", length, tendon.armature)
            )
        self._requirements += length_limits(tendon, length)

    def _add_thruster(self, thruster: Thruster, place: Frame) -> None:
        """Add an input that pushes what a frame is fixed to, and a body without mass for it."""
        pushing = self._command(thruster).symbol
        site = Body(f"{thruster.name} site", place)
        fx, fy, fz, tx, ty, tz = (
            pushing * part if part else 0
            for part in (*thruster.force.tolist(), *thruster.torque.tolist())
        )
        self._bodies.append(site)
        self.driven.append(Wrench(on=site, force=(fx, fy, fz), torque=(tx, ty, tz)))

    def _add_closure(self, closure: Closure, at: Mapping[str, tuple[_Part, Array]]) -> None:
        """Add the constraints that close a loop."""
        ends = (closure.first, closure.first_pose), (closure.second, closure.second_pose)
        frames = [
            part.frame @ constant_frame(pose @ own)
            for (part, pose), own in ((at[link], own) for link, own in ends)
        ]
        turns, where = closure.kind == "pose", self._where
        try:
            self._constraints += closing_constraints(
                closure.name, *frames, turns=turns, where=where
            )
        except InputError as error:
            self._mistakes += error.mistakes

    def _rotor(self, joint: Joint, at: sympy.Expr) -> Body:
        """Return a body with the kinetic energy of a rotor, which turns with the joint alone."""
        name = f"{joint.name} rotor"
        if joint.kind == "revolute":
            return Body(name, TURNS["z"](at), inertia=joint.armature, located=False)
        return self._weightless(name, at, joint.armature)

    def _weightless(self, name: str, at: sympy.Expr, mass: float) -> Body:
        """Return a mass that moves with a length, across gravity, so that it has no weight."""
        down = np.array(self._tree.gravity)
        across = np.cross(down, np.eye(3)[int(np.abs(down).argmin())])
        size = float(np.linalg.norm(across))
        level = across / size if size else np.eye(3)[0]
        along = move(*(float(part) * at for part in level))
        return Body(name, along, mass=mass, located=False)


def _gravity(vector: tuple[float, float, float]) -> Gravity | None:
    strength = math.hypot(*vector)
    if not strength:
        return None
    x, y, z = (entry / strength for entry in vector)
    return Gravity((x, y, z), exact(strength))


def _floating(coordinates: tuple[str, ...]) -> tuple[Frame, list[Coordinate], Attitude]:
    """Return a frame that moves freely, with its place and attitude; the attitude's own entries are
    called name_x to name_w."""
    *names, last = coordinates
    place, turn = [length(name) for name in names], rotation(last)
    return move(*place) @ orient(turn), place, turn


def _coordinate(joint: Joint) -> Coordinate:
    name, declared = usable_name(joint.name), length if joint.kind == "prismatic" else angle
    return declared(name, joint.lower, joint.upper, speed=joint.speed)


def _turn(axis: Array, at: sympy.Expr) -> Frame:
    """Return the rotation about a unit vector (3,) by an angle in [rad]."""
    along = along_an_axis(axis)
    if along is not None:
        name, sign = along
        return TURNS[name](at if sign > 0 else -at)
    onto = onto_z(axis)
    there, back = (constant_frame(pose_of(np.zeros(3), turn)) for turn in (onto, onto.T))
    return there @ TURNS["z"](at) @ back


def _axis(frame: Frame, axis: Array) -> Axis:
    """Return a unit vector (3,) of a frame as an axis."""
    along = along_an_axis(axis)
    if along is None:
        return (frame @ constant_frame(pose_of(np.zeros(3), onto_z(axis)))).z
    name, sign = along
    return Axis(frame, name) if sign > 0 else -Axis(frame, name)


def _onto_the_ground(shape: Shape, pose: Array) -> Array:
    """Return the pose (4, 4) of a shape that stands still, lifted if it is a little below z = 0.

    A solid around a robot's foot reaches some millimetres farther down than the foot.
    """
    sunk = -lowest_z(shape, pose[:3])
    if not 0.0 < sunk <= 0.05:  # [m]
        return pose
    lifted = pose.copy()
    lifted[2, 3] += sunk
    return lifted


def along_the_axes(shape: Shape, pose: Array) -> Shape | None:
    """Return a shape along the axes of the frame of its pose (4, 4), None if it is oblique."""
    turn = np.where(np.abs(pose[:3, :3]) < ALIGNED, 0.0, pose[:3, :3])
    at = tuple(pose[:3, 3].tolist())
    if shape.symmetric == "xyz":
        return replace(shape, at=at)
    if shape.symmetric == "z":
        along = along_an_axis(turn[:, 2])
        return None if along is None else replace(shape, axis=along[0], at=at)
    if not np.allclose(np.abs(turn).max(axis=0), 1.0, rtol=0.0, atol=ALIGNED):
        return None
    x, y, z = (np.abs(turn) @ (2.0 * sizes(shape)[1])).tolist()
    return Box(x, y, z, at=at)


def _held(joints: Mapping[str, Joint], locked: Mapping[str, float]) -> dict[str, float]:
    """Return where joints are that are locked, or have no room between their limits."""
    movable = (one for one in joints.values() if one.kind in ("revolute", "prismatic"))
    at = {joint.name: _locked_at(joint, joints, locked) for joint in movable}
    return {name: where for name, where in at.items() if where is not None}


def _fixed_at(joint: Joint, held: Mapping[str, float]) -> Joint:
    """Return a joint as a fixed one, if it is held at a position."""
    if joint.name not in held:
        return joint
    pose = joint.pose @ moved_to(joint, held[joint.name])
    return replace(joint, kind="fixed", pose=pose, mimics=None, held=True)


def _locked_at(
    joint: Joint, joints: Mapping[str, Joint], locked: Mapping[str, float]
) -> float | None:
    """Return where a joint is locked, itself or with the one that it follows; None if it moves."""
    if joint.name in locked:
        return locked[joint.name]
    if joint.mimics is not None:
        if joint.mimics.factor == 0.0:
            return joint.mimics.offset
        at = _locked_at(joints[joint.mimics.joint], joints, locked)
        return None if at is None else joint.mimics.factor * at + joint.mimics.offset
    return joint.lower if joint.lower == joint.upper else None
