"""From a machine to a kinematic tree: each coordinate is a joint, each body is a link.

Bodies whose frames begin alike hang from the same joints.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import AnyCoordinate
from kinolab.dynamics.symbols.symbols import Attitude
from kinolab.errors import InputError, Mistake
from kinolab.numerics.arrays import Array
from kinolab.robots.tree.constant_frames import ROUNDING
from kinolab.robots.tree.kinematic_tree import (
    Inertial,
    Joint,
    KinematicTree,
    Link,
    Mimicked,
    PlacedShape,
)
from kinolab.robots.tree.tree_mistakes import massless_joints
from kinolab.robots.writing.frame_chains import ChainStep, FrameChains, Move
from kinolab.robots.writing.fresh_names import fresh_name
from kinolab.robots.writing.joint_loads import Loads, loads_of
from kinolab.world.shapes.geometry import placement

WORLD_LINK = "world"
EQUATIONS = "Equations of motion have it: see to_c() and to_casadi()."


class MachineTree(NamedTuple):
    """A machine as a tree, whose root is the world; ``frames`` are the links that are no bodies."""

    tree: KinematicTree
    frames: frozenset[str]


@dataclass(eq=False)
class _Node:
    """What moves together behind a joint; the world has none.

    Attributes:
        move: The joint.
        pose: Of the joint's frame in that of its parent, shape (4, 4).
        bodies: With their poses (4, 4).
    """

    move: Move | None = None
    pose: Array = field(default_factory=lambda: np.eye(4))
    bodies: list[tuple[Body, Array]] = field(default_factory=list)
    children: list[_Node] = field(default_factory=list)

    @property
    def joint(self) -> Move:
        """The joint of a node that is not the world."""
        assert self.move is not None
        return self.move

    @property
    def coordinate(self) -> AnyCoordinate:
        """What moves it."""
        return self.joint.coordinate

    @property
    def factor(self) -> float:
        """Of the coordinate."""
        return self.joint.factor


def machine_tree(
    system: Mechanism,
    lacking: Callable[[KinematicTree], Iterable[Mistake]],
    *,
    partial: bool,
) -> MachineTree:
    """Return a machine as a tree.

    Args:
        lacking: Yields what of a tree cannot be written.
        partial: Whether to leave out what does not keep it from being a tree.

    Raises:
        InputError: If it is no tree; unless ``partial`` with all that cannot be written.
    """
    chains = FrameChains(system)
    made = _Maker(system, chains)
    loads = loads_of(system, chains, made.factors)
    cannot = [*_other_laws(system), *loads.cannot]
    if made.mistakes or chains.mistakes:  # those of frames that only inputs have, too
        further = [entry for entry in chains.mistakes if entry not in made.mistakes]
        raise InputError([*made.mistakes, *further, *cannot])
    scaled = {c.name for c, factor in made.factors.items() if factor != 1.0}
    tree = _with_floating(made.tree(loads), made.frames, scaled)
    cannot += lacking(tree)
    mistakes = [*massless_joints(tree, ""), *([] if partial else cannot)]
    if mistakes:
        raise InputError(mistakes)
    return MachineTree(tree, frozenset(made.frames))


def _other_laws(system: Mechanism) -> Iterator[Mistake]:
    """Yield what makes a machine more than a tree that is pushed."""
    where = f"system {system.name!r}"
    if system.feedback is not None:
        yield Mistake(where, "it has feedback.", "Take its plant: with_feedback(None).")
    if system.modes:
        what = f"it has modes: {', '.join(mode.name for mode in system.modes)}."
        yield Mistake(where, what, f'Take one of them: in_mode(system, "{system.modes[0].name}").')
    for constraint in system.all_constraints:
        what = "no joint of a tree has it."
        yield Mistake(f"constraint {constraint.name!r}", what, EQUATIONS)
    for state in system.states:
        if not (system.modes and state is system.states[-1]):
            what = "it has a differential equation of its own."
            yield Mistake(f"state {state.name!r}", what, EQUATIONS)
    for body in system.bodies:
        if any(entry != 0 for row in body.added_mass for entry in row):
            yield Mistake(f"body {body.name!r}", "it has added mass, of a fluid.", EQUATIONS)


class _Maker:
    """Builds the tree of a machine's bodies."""

    def __init__(self, system: Mechanism, chains: FrameChains) -> None:
        self._system = system
        self._root = _Node()
        found = [(body, chains.of(body.frame, f"body {body.name!r}")) for body in system.bodies]
        known = [(body, chain) for body, chain in found if chain is not None]
        for body, chain in sorted(known, key=lambda entry: sum(len(s.moves) for s in entry[1])):
            self._hang(body, chain)
        self._world = _at_the_joint(self._root, WORLD_LINK)
        self._rotors = self._take_rotors()
        self.mistakes = [*chains.mistakes, *self._twice(), *self._worlds()]
        self._links: list[Link] = []
        self._joints: list[Joint] = []
        self.frames: set[str] = set()
        self._leaders = self._leading()
        self.factors = {c: node.factor for c, node in self._leaders.items()}
        if not chains.mistakes:
            self.mistakes += [
                Mistake(f"coordinate {c.name!r}", "it moves no body.", "Use it in a frame.")
                for c in system.coordinates
                if c not in self.factors
            ]

    def _hang(self, body: Body, chain: tuple[ChainStep, ...]) -> None:
        node, pose = self._root, np.eye(4)
        for step in chain:
            waiting = list(step.moves)
            while waiting:
                node, move = _down(node, pose, waiting)
                waiting.remove(move)
                pose = np.eye(4)
            pose = pose @ step.then
        node.bodies.append((body, pose))

    def _take_rotors(self) -> dict[AnyCoordinate, float]:
        """Take out what turns alone with a coordinate that moves something else, too.

        It stands for the rotor of a motor: an inertia that only this joint feels.
        """
        found: dict[AnyCoordinate, float] = {}
        for node in [*self._root.children]:
            c = node.coordinate
            moved = [n for n in _below(self._root) if n.coordinate == c]
            inertia = None if node.children else self._rotor_inertia(node)
            if inertia is not None and len(moved) > 1:
                self._root.children.remove(node)
                found[c] = found.get(c, 0.0) + inertia
        return found

    def _rotor_inertia(self, node: _Node) -> float | None:
        """Return what a coordinate feels of a node's bodies; None if that is not all they do."""
        total, move = 0.0, node.joint
        down = self._system.down or (0.0, 0.0, 0.0)
        for body, pose in node.bodies:
            mass, inertia = self._mass(body)
            axis = move.axis
            if body.shapes or move.kind == "ball":
                return None
            if move.kind == "revolute":
                if mass:
                    return None
                own = pose[:3, :3].T @ axis
                total += move.factor**2 * float(own @ inertia @ own)
            else:
                if abs(float(np.dot(down, node.pose[:3, :3] @ axis))) > ROUNDING:
                    return None
                total += move.factor**2 * mass
        return total

    def _twice(self) -> Iterator[Mistake]:
        """Yield attitudes that turn several things, which no joint can follow."""
        turned = [node.coordinate for node in _below(self._root)]
        for attitude in sorted(c for c in set(turned) if isinstance(c, Attitude)):
            if turned.count(attitude) > 1:
                what = "it turns frames that do not hang from each other."
                yield Mistake(f"rotation {attitude.name!r}", what, "Let one frame have it.")

    def _worlds(self) -> Iterator[Mistake]:
        """Yield a body that is called the world and is not fixed to it."""
        for body in self._system.bodies:
            if body.name == WORLD_LINK and body is not self._world:
                what = "files give this name to the world."
                yield Mistake(f"body {body.name!r}", what, "Call it otherwise.")

    def _mass(self, body: Body) -> tuple[float, Array]:
        """Return a body's mass in [kg] and its inertia matrix (3, 3) in [kg m^2]."""
        number = self._system.number
        inertia = np.array(body.inertia_matrix.applyfunc(number).tolist(), dtype=float)
        return number(body.mass), inertia

    def _leading(self) -> dict[AnyCoordinate, _Node]:
        """Return which of the nodes that a coordinate moves has its joint; others follow."""
        found: dict[AnyCoordinate, _Node] = {}
        for node in _below(self._root):
            first = found.setdefault(node.coordinate, node)
            if node.factor == 1.0 and first.factor != 1.0:
                found[node.coordinate] = node
        return found

    def tree(self, loads: Loads) -> KinematicTree:
        """Return the tree with the loads of its joints."""
        taken = {WORLD_LINK, *(body.name for body in self._system.bodies)}
        world = Link(WORLD_LINK) if self._world is None else self._link(self._world)
        self._links.append(replace(world, inertial=None))
        self._fix(self._root, WORLD_LINK, skip=self._world)
        self._add(self._root, WORLD_LINK, loads, taken)
        gravity = self._system.gravity
        strength = self._system.number(gravity.strength) if gravity else 0.0
        x, y, z = (strength * part + 0.0 for part in self._system.down or (0.0,) * 3)
        return KinematicTree(
            self._system.name,
            tuple(self._links),
            tuple(self._joints),
            loads.motors,
            (x, y, z),
            thrusters=loads.thrusters,
        )

    def _add(self, node: _Node, parent: str, loads: Loads, taken: set[str]) -> None:
        """Add what hangs from a node, whose link is named."""
        for child in node.children:
            joint = self._joint(child, parent, loads)
            own = _at_the_joint(child)
            name = own.name if own else fresh_name(f"{joint.name} frame", taken)
            if own is None:
                self.frames.add(name)
            self._links.append(self._link(own) if own else Link(name))
            self._joints.append(replace(joint, child=name))
            self._fix(child, name, skip=own)
            self._add(child, name, loads, taken)

    def _fix(self, node: _Node, parent: str, *, skip: Body | None) -> None:
        """Add the bodies of a node as links that are fixed to its own."""
        for body, pose in node.bodies:
            if body is not skip:
                self._links.append(self._link(body))
                name = f"{body.name} fixed"
                self._joints.append(Joint(name, "fixed", parent, body.name, pose))

    def _joint(self, node: _Node, parent: str, loads: Loads) -> Joint:
        """Return a node's joint, its child unnamed as yet."""
        move = node.joint
        c, leader = move.coordinate, self._leaders[move.coordinate]
        base = Joint(c.name, move.kind, parent, "", node.pose, move.axis)
        if isinstance(c, Attitude):
            return replace(base, axis=np.array([1.0, 0.0, 0.0]), speed=c.speed)
        factor = move.factor
        base = replace(
            base,
            lower=c.lower * factor,
            upper=c.upper * factor,
            speed=c.speed * factor,
        )
        if node is not leader:
            name = fresh_name(f"{c.name} follower", {joint.name for joint in self._joints})
            return replace(base, name=name, mimics=Mimicked(c.name, factor / leader.factor))
        rotor = self._rotors.get(c, 0.0) / factor**2
        return replace(base, armature=rotor, **vars(loads.joints[c]))

    def _link(self, body: Body) -> Link:
        mass, inertia = self._mass(body)
        massive = mass > 0.0 or inertia.any()
        solids = []
        for shape in self._system.resolved_shapes(body):
            own = np.vstack([placement(shape), [0.0, 0.0, 0.0, 1.0]])
            solids.append(PlacedShape(shape, own, body.color))
        inertial = Inertial(mass, np.zeros(3), inertia) if massive else None
        return Link(body.name, inertial, tuple(solids))


def _with_floating(tree: KinematicTree, frames: set[str], scaled: set[str]) -> KinematicTree:
    """Return a tree in which what is free in space has one joint: it moves along x, y, z and turns.

    Args:
        frames: Links that are no bodies.
        scaled: Joints whose positions are not those of their coordinates.
    """
    above = {joint.child: joint for joint in tree.joints}
    hung = [joint.parent for joint in tree.joints]
    driven = {motor.joint for motor in tree.motors}
    joints = list(tree.joints)
    for ball in tree.joints:
        slides: list[Joint] = []
        link = ball.parent
        while link in frames and hung.count(link) == 1 and len(slides) < 3:
            slides.append(above[link])
            link = above[link].parent
        ways = sorted(tuple(slide.axis.tolist()) for slide in slides)
        if (
            ball.kind == "ball"
            and link == WORLD_LINK
            and ways == sorted(map(tuple, np.eye(3).tolist()))
            and all(_is_plain(slide) and slide.name not in driven | scaled for slide in slides)
            and all(np.array_equal(one.pose, np.eye(4)) for one in (*slides, ball))
        ):
            joints = [one for one in joints if one not in slides]
            joints[joints.index(ball)] = replace(ball, kind="floating", parent=WORLD_LINK)
    used = {WORLD_LINK, *(joint.child for joint in joints)}
    links = tuple(link for link in tree.links if link.name in used)
    return replace(tree, links=links, joints=tuple(joints))


def _is_plain(joint: Joint) -> bool:
    """Whether a joint slides freely, without end and without friction."""
    loads = joint.damping, joint.friction, joint.stiffness, joint.armature
    free = joint.lower == -math.inf and joint.upper == math.inf
    return joint.kind == "prismatic" and joint.mimics is None and free and not any(loads)


def _down(node: _Node, pose: Array, waiting: list[Move]) -> tuple[_Node, Move]:
    """Return the next node of a chain and the joint that leads to it, new ones if need be."""
    for child in node.children:
        if np.allclose(child.pose, pose, rtol=0.0, atol=ROUNDING):
            for move in waiting:
                if child.joint.is_like(move):
                    return child, move
    made = _Node(waiting[0], pose)
    node.children.append(made)
    return made, waiting[0]


def _below(node: _Node) -> Iterator[_Node]:
    """Yield what hangs from a node, each after what it hangs from."""
    for child in node.children:
        yield child
        yield from _below(child)


def _at_the_joint(node: _Node, name: str = "") -> Body | None:
    """Return the first body, or that of a name, whose frame is that of its node."""
    for body, pose in node.bodies:
        if np.allclose(pose, np.eye(4), rtol=0.0, atol=ROUNDING) and name in ("", body.name):
            return body
    return None
