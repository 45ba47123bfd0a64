"""Robots whose speeds or accelerations are given, whatever forces that takes: without masses.

Source: LaValle, Planning Algorithms, 2006, sections 13.1 (speeds as inputs) and 13.2 (double
integrators); names and meaning of the limits as in MoveIt's joint_limits.yaml.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias, final

from kinolab.arguments import require_fit
from kinolab.dynamics.language.inputs import Drive, Input, Rate
from kinolab.dynamics.symbols.symbols import Coordinate, MachineSymbol
from kinolab.errors import InputError, Mistake, listed, unknown_name
from kinolab.robots.tree.kinematic_tree import Joint, KinematicTree

PerJoint: TypeAlias = float | Mapping[str, float]


@final
@dataclass(frozen=True)
class GivenMotion:
    """What gives a robot its motion.

    Attributes:
        velocity: Largest speed of joints, of all or by name, in [rad/s] or [m/s]. Those of the file
            hold as well.
        acceleration: Their largest accelerations, in [rad/s^2] or [m/s^2]. Where there are any,
            they are the inputs; otherwise the speeds are.
    """

    velocity: PerJoint | None = None
    acceleration: PerJoint | None = None

    def mistakes(self, tree: KinematicTree, base: str, where: str) -> Iterator[Mistake]:
        """Yield limits that are none, of joints that there are not, and what has no such motion."""
        names = sorted(joint.name for joint in tree.joints if joint.kind != "fixed")
        for key, limits in (("velocity", self.velocity), ("acceleration", self.acceleration)):
            place = f"{where} max_{key}".strip()
            given = dict(limits) if isinstance(limits, Mapping) else {}
            for name in given:
                if name not in names:
                    yield unknown_name("joint", name, known=names, where=place)
            if limits is not None and not isinstance(limits, Mapping):
                given = {"": limits}
            for value in given.values():
                if not 0.0 < value < math.inf:
                    yield Mistake(place, f"{value:g} is no limit.", "Give a positive number.")
        if base == "floating":
            what = "a base that floats has no limits of its speed."
            yield Mistake(f"{where} base", what, 'Leave base = "floating" out.')
        if loops := listed(loop.name for loop in tree.closures):
            what = f"{loops} close loops, in which not every joint has a speed of its own."
            yield Mistake(where, what, "Leave kinematic = true out.")

    def bounded(self, tree: KinematicTree) -> KinematicTree:
        """Return a tree whose joints have the limits of speed."""
        return replace(
            tree,
            joints=tuple(
                replace(joint, speed=min(joint.speed, _of(self.velocity, joint)))
                for joint in tree.joints
            ),
        )

    def unlimited(self, tree: KinematicTree, where: str) -> Iterator[Mistake]:
        """Yield which limits there must be and are not."""
        moving = [joint for joint in tree.joints if joint.kind != "fixed" and joint.mimics is None]
        free = [joint.name for joint in moving if math.isinf(joint.speed)]
        if free:
            what = f"nothing limits the speed of {listed(free)}."
            remedy = (
                "Write max_velocity = 1.0, or { NAME = 1.0 }, below [system]: [rad/s] or [m/s]."
            )
            yield Mistake(where, what, remedy)
        if self.acceleration is None:
            return
        if free := [one.name for one in moving if math.isinf(_of(self.acceleration, one))]:
            what = f"nothing limits the acceleration of {listed(free)}."
            yield Mistake(f"{where} max_acceleration".strip(), what, "Give a number for all.")
        if turning := listed(one.name for one in moving if one.kind in ("ball", "floating")):
            what = f"{turning} turn about every axis; accelerations are of angles and lengths."
            remedy = "Leave max_acceleration out: speeds are inputs then."
            yield Mistake(f"{where} max_acceleration".strip(), what, remedy)

    def inputs(self, joint: Joint, moved: Sequence[MachineSymbol]) -> Iterator[Input]:
        """Yield what moves a joint, with coordinates and components of its angular velocity."""
        for one in moved:
            if self.acceleration is not None and isinstance(one, Coordinate):
                most = _of(self.acceleration, joint)
                yield Drive(f"{one.name}_acceleration", on=one, limit=most)
            else:
                yield Rate(f"{one.name}_velocity", on=one, limit=joint.speed)


def given_motion(
    where: str,
    velocity: PerJoint | None,
    acceleration: PerJoint | None,
    *,
    kinematic: bool,
) -> GivenMotion | None:
    """Return what gives a robot its motion, None where forces do.

    Raises:
        InputError: If there are limits, and it is not kinematic.
    """
    for key, given in (("velocity", velocity), ("acceleration", acceleration)):
        require_fit(f"max_{key}", float | Mapping[str, float] | None, given)
        if given is not None and not kinematic:
            what, remedy = "forces move the robot.", "Write kinematic = true, or leave it out."
            raise InputError([Mistake(f"{where} max_{key}", what, remedy)])
    return GivenMotion(velocity, acceleration) if kinematic else None


def _of(limits: PerJoint | None, joint: Joint) -> float:
    """Return a joint's limit, infinite where there is none."""
    if isinstance(limits, Mapping):
        return float(limits.get(joint.name, math.inf))
    return math.inf if limits is None else float(limits)
