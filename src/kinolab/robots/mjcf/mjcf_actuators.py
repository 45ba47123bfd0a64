"""Actuators of MJCF files: motors, servos and filters of joints and of fixed tendons, thrusters.

Source: MuJoCo's documentation, chapter Computation, section Actuation model.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.robots.actuation.actuators import Actuator, Aim, Length, Motor, Thruster
from kinolab.robots.mjcf.compiled_model import WORLD_BODY, CompiledModel
from kinolab.robots.mjcf.mjcf_fields import disabled
from kinolab.robots.mjcf.mjcf_laws import UNLIMITED, ActuatorLaw
from kinolab.robots.mjcf.mjcf_tendons import length_of
from kinolab.robots.tree.kinematic_tree import pose_of, usable_name


class ActuatorReader:
    """Converts the actuators of MuJoCo's model.

    Args:
        commands: Whether inputs of servos whose forces have limits are their commands, too.

    Attributes:
        aims: What servos can do whose inputs are their forces.
        off: Names of actuators that a flag or their group disables.
        driving: Inputs of servos that drive what they act on away.
        unaimed: Inputs of servos that are motors, since their control has no limits.
        early: Inputs whose filters act a step early.
    """

    def __init__(self, compiled: CompiledModel, *, commands: bool) -> None:
        self._compiled, self._cannot, self._commands = compiled, compiled.cannot, commands
        self._mujoco, self._model = mujoco, model = compiled.mujoco, compiled.model
        self._joints, self._bodies = compiled.joints, compiled.bodies
        count = int(getattr(model, "nactuator", model.nu))  # nu before MuJoCo 4
        self._motors = compiled.names("ACTUATOR", count, "motor")
        off = "ACTUATION" in disabled(mujoco, model)
        self._acting = [] if off else [k for k in range(count) if self._acts(k)]
        self._laws = [ActuatorLaw.of(compiled, k) for k in range(count)]
        self.off = [name for k, name in enumerate(self._motors) if k not in self._acting]
        self.driving, self.unaimed, self.early = list[str](), list[str](), list[str]()
        self.aims: list[Aim] = []

    def motors(self) -> Iterator[Motor]:
        """Yield the motors of joints, whose inputs are their forces."""
        for k in self._acting:
            if self._turns(k) and not self._commanded(k) and self._single(k):
                yield from self._motor(k)

    def actuators(self) -> Iterator[Actuator]:
        """Yield what acts on fixed tendons, and on joints by commands."""
        for k in self._acting:
            if self._on_fixed_tendon(k):
                yield from self._pull(k)
            elif self._turns(k):
                if self._commanded(k) and self._single(k):
                    yield from self._servo(k)
            elif not self._pushes(k):
                kind = self._mujoco.mjtTrn(int(self._model.actuator_trntype[k])).name
                name, word = self._motors[k], kind.rsplit("_", 1)[-1].lower()
                what = f"actuator {name} does not act on a joint, but by the transmission {word}."
                self._cannot(what, "Joints, fixed tendons, and sites without refsite are moved.")

    def thrusters(self) -> Iterator[Thruster]:
        """Yield what pushes at sites."""
        for k in self._acting:
            if self._pushes(k):
                yield from self._thruster(k)

    def _motor(self, k: int) -> Iterator[Motor]:
        """Yield an actuator of a joint as a motor."""
        joint, gear = self._at(k), float(self._laws[k].gear[0])
        moved, ends = self._joints[joint], self._within_joint(k)
        if self._are_limits(k, ends):
            turns = int(self._model.jnt_type[joint]) == int(self._mujoco.mjtJoint.mjJNT_HINGE)
            name = self._input_name(k, "torque" if turns else "force")
            self._note(k, name)
            self._note_aim(k, name, Length({moved: gear}), ends, gear)
            yield Motor(name, moved, *ends.tolist())

    def _servo(self, k: int) -> Iterator[Actuator]:
        """Yield an actuator of a joint whose input is its command."""
        gear = float(self._laws[k].gear[0])
        if gear:
            along, ends = Length({self._joints[self._at(k)]: gear}), self._within_joint(k)
            yield from self._commanded_actuator(k, along, np.sort(ends / gear))

    def _pull(self, k: int) -> Iterator[Actuator]:
        """Yield an actuator of a fixed tendon."""
        tendon, law = self._at(k), self._laws[k]
        whole, gear = length_of(self._compiled, tendon), float(law.gear[0])
        assert whole is not None
        along = Length({name: gear * each for name, each in whole.joints.items() if gear * each})
        above = [name for name in whole.joints if self._limits_force(self._joints.index(name))]
        why, limited = law.refused, bool(self._model.tendon_actfrclimited[tendon])
        if above:
            why = why or f"joint {above[0]} has actuatorfrcrange"
        if limited and self._others(k):
            why = why or "its tendon has actuatorfrcrange, which limits the sum of several"
        if why:
            self._cannot(f"actuator {self._motors[k]} is no motor of a tendon: {why}.")
            return
        within = self._model.tendon_actfrcrange[tendon] if limited else UNLIMITED
        force = np.clip(law.limits(), *within)
        if self._commanded(k):
            yield from self._commanded_actuator(k, along, force)
        elif self._are_limits(k, force):
            name = self._input_name(k, "pull")
            self._note(k, name)
            self._note_aim(k, name, along, force)
            yield Actuator(name, along, *force.tolist())

    def _commanded_actuator(self, k: int, along: Length, force: Array) -> Iterator[Actuator]:
        """Yield an actuator along a length whose input is its command.

        Args:
            force: Limits (2,) of its force, infinite ones if none.
        """
        law, name = self._laws[k], self._input_name(k, "command")
        if not self._are_limits(k, law.control, of="command"):
            return
        self._note(k, name)
        inside, kept = (force, UNLIMITED) if law.even else (UNLIMITED, force)
        (lower, upper), (least, most) = law.control.tolist(), kept.tolist()
        (g0, g1, g2), (constant, of_length, of_speed) = law.gain.tolist(), law.bias.tolist()
        yield Actuator(
            name,
            along,
            lower,
            upper,
            gain=(g0, g1, g2),
            bias=constant,
            stiffness=-of_length,
            damping=-of_speed,
            least=least,
            most=most,
            filter=law.within(inside),
        )

    def _thruster(self, k: int) -> Iterator[Thruster]:
        """Yield an actuator that acts on a site as a thruster."""
        model, law, site = self._model, self._laws[k], self._at(k)
        body = int(model.site_bodyid[site])
        why = law.refused or self._limit_above(body)
        # a site has no length, so that a servo of positions pushes by its gain times its control
        if law.bias[2] or law.gain[2]:
            why = why or "it brakes its site"
        if law.through and (law.bias[0] or not law.gain[0]):
            why = why or "it pushes whatever its control is"
        if why:
            self._cannot(f"actuator {self._motors[k]} is no thruster: {why}.")
            return
        force = law.limits(at_rest=True)
        ends, unit = (law.control, law.gain[0]) if law.through else (force, 1.0)
        if self._are_limits(k, ends):
            name = self._input_name(k, "thrust")
            self._note(k, name)
            pose = pose_of(model.site_pos[site], self._compiled.turn(model.site_quat[site]))
            push, turn = unit * law.gear[:3], unit * law.gear[3:]
            lower, upper = ends.tolist()
            through = law.within(force)
            yield Thruster(name, self._bodies[body], pose, push, turn, lower, upper, through)

    def _note(self, k: int, name: str) -> None:
        """Keep in mind what is said of an input."""
        law = self._laws[k]
        if law.aims and (law.bias[1:] > 0.0).any():
            self.driving.append(name)
        if not law.aims and law.bias[1:].any() and not self._pushes(k):
            self.unaimed.append(name)
        if law.through and self._model.actuator_actearly[k]:
            self.early.append(name)

    def _note_aim(self, k: int, name: str, along: Length, ends: Array, unit: float = 1.0) -> None:
        """Keep what a servo can aim at, if that has limits.

        Args:
            name: Of its input, its force.
            ends: Limits (2,) of its input.
            unit: What the input is for each unit of its force.
        """
        law = self._laws[k]
        if law.aims:
            low, high = np.sort(unit * (law.gain[0] * law.control + law.bias[0])).tolist()
            _, of_length, of_speed = (-unit * law.bias).tolist()
            self.aims.append(Aim(name, along, low, high, of_length, of_speed, *ends.tolist()))

    def _acts(self, k: int) -> bool:
        """Whether the group of an actuator is not disabled."""
        group = int(self._model.actuator_group[k])
        return group < 0 or not int(self._model.opt.disableactuator) >> group & 1

    def _at(self, k: int) -> int:
        """Return the number of an actuator's joint, tendon or site."""
        return int(self._model.actuator_trnid[k, 0])

    def _commanded(self, k: int) -> bool:
        """Whether an actuator's input is its control; otherwise it is the force."""
        law = self._laws[k]
        freely = law.aims and (self._commands or not self._force_limited(k))
        return freely or law.through is not None or bool(law.gain[1:].any())

    def _force_limited(self, k: int) -> bool:
        """Whether something limits the force of an actuator of a joint or tendon."""
        kind = "tendon" if self._on_fixed_tendon(k) else "jnt"
        above = getattr(self._model, f"{kind}_actfrclimited")[self._at(k)]
        return bool(np.isfinite(self._laws[k].force).any() or above)

    def _on_fixed_tendon(self, k: int) -> bool:
        """Whether an actuator acts on a tendon whose length is a sum of joints' positions."""
        kind, of_tendons = int(self._model.actuator_trntype[k]), self._mujoco.mjtTrn.mjTRN_TENDON
        return kind == int(of_tendons) and length_of(self._compiled, self._at(k)) is not None

    def _pushes(self, k: int) -> bool:
        """Whether an actuator acts on a site alone, in the site's axes."""
        site = int(self._mujoco.mjtTrn.mjTRN_SITE)
        ids = self._model.actuator_trnid[k]
        return int(self._model.actuator_trntype[k]) == site and int(ids[1]) < 0

    def _turns(self, k: int) -> bool:
        """Whether an actuator acts on a joint; hinges and slides have one axis in both bodies."""
        kinds = self._mujoco.mjtTrn.mjTRN_JOINT, self._mujoco.mjtTrn.mjTRN_JOINTINPARENT
        return int(self._model.actuator_trntype[k]) in map(int, kinds)

    def _single(self, k: int) -> bool:
        """Whether an actuator of a joint acts on a hinge or slide by a known law."""
        name, joint, kinds = self._motors[k], self._at(k), self._mujoco.mjtJoint
        if int(self._model.jnt_type[joint]) not in (int(kinds.mjJNT_HINGE), int(kinds.mjJNT_SLIDE)):
            what = f"actuator {name} acts on the joint {self._joints[joint]} with several rates."
            self._cannot(what, "Motors act on hinges and slides, thrusters on sites.")
            return False
        if why := self._laws[k].refused:
            self._cannot(f"actuator {name} is no motor: {why}.")
        return not why

    def _others(self, k: int) -> list[int]:
        """Return the other actuators of an actuator's joint or tendon."""
        alike = self._on_fixed_tendon if self._on_fixed_tendon(k) else self._turns
        return [a for a in self._acting if a != k and self._at(a) == self._at(k) and alike(a)]

    def _limits_force(self, joint: int) -> bool:
        """Whether a joint limits the force of its actuators."""
        return bool(self._model.jnt_actfrclimited[joint])

    def _within_joint(self, k: int) -> Array:
        """Return the limits (2,) of an actuator's force on its joint, which may limit all of it."""
        joint, own = self._at(k), self._on_joint(k)
        if not self._limits_force(joint):
            return own
        low, high = map(float, self._model.jnt_actfrcrange[joint])
        others = [self._on_joint(a) for a in self._others(k)]
        least, most = sum(others, own)
        if low <= least <= most <= high:
            return own
        if others:
            self._cannot(
                f"joint {self._joints[joint]} has actuatorfrcrange {low:g} {high:g}, which limits "
                "the sum of several actuators.",
                "Give them limits whose sum is within it.",
            )
        return np.clip(own, low, high)

    def _on_joint(self, k: int) -> Array:
        """Return the limits (2,) of an actuator's force on its joint, infinite ones if none."""
        gear = float(self._laws[k].gear[0])
        return np.sort(gear * self._laws[k].limits()) if gear else np.zeros(2)

    def _are_limits(self, k: int, ends: Array, of: str = "force") -> bool:
        """Whether an input may have limits (2,); none needs to be there whose force is always 0."""
        name = self._motors[k]
        if not np.isfinite(ends).all():
            remedy = "Give it a ctrlrange"
            if of == "force":
                remedy += " or a forcerange, or its joint an actuatorfrcrange"
            self._cannot(f"actuator {name} has no limit of its {of}.", f"{remedy}.")
            return False
        if ends[0] == ends[1] != 0.0:
            self._cannot(f"actuator {name} always has the force {ends[0]:g}, which is no input.")
        return bool(ends[0] < ends[1])

    def _limit_above(self, body: int) -> str:
        """Return which joint that moves a body limits the force of all actuators, if any does."""
        model = self._model
        while body != WORLD_BODY:
            first = int(model.body_jntadr[body])
            for joint in range(first, first + int(model.body_jntnum[body])):
                if self._limits_force(joint):
                    return f"joint {self._joints[joint]} has actuatorfrcrange"
            body = int(model.body_parentid[body])
        return ""

    def _input_name(self, k: int, word: str) -> str:
        """Return the name of an actuator's input, with a word to it if a joint has the name."""
        name = usable_name(self._motors[k])
        return f"{name}_{word}" if name in map(usable_name, self._joints) else name
