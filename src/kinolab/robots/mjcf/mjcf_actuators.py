"""Actuators of MJCF files: motors of joints and of fixed tendons, and thrusters at sites.

Source: MuJoCo's documentation, chapter Computation, section Actuation model.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.robots.kinematic_tree import (
    Motor,
    Servo,
    TendonMotor,
    Thruster,
    pose_of,
    usable_name,
)
from kinolab.robots.mjcf.compiled_model import WORLD_BODY, CompiledModel
from kinolab.robots.mjcf.mjcf_fields import disabled


class ActuatorReader:
    """Converts the actuators of MuJoCo's model.

    Attributes:
        servos: Those of the motors and pulls that were yielded.
        off: Names of actuators that a flag or their group disables.
    """

    def __init__(self, compiled: CompiledModel) -> None:
        self._compiled, self._cannot = compiled, compiled.cannot
        self._mujoco, self._model = mujoco, model = compiled.mujoco, compiled.model
        self._joints, self._bodies = compiled.joints, compiled.bodies
        # before MuJoCo 4 every actuator had one control and one output
        count = int(getattr(model, "nactuator", model.nu))
        self._control: Sequence[int] = getattr(model, "actuator_ctrladr", range(model.nu))
        self._output: Sequence[int] = getattr(model, "actuator_outadr", range(model.nu))
        self._motors = compiled.names("ACTUATOR", count, "motor")
        off = "ACTUATION" in disabled(mujoco, model)
        self.servos: list[Servo] = []
        self._acting = [] if off else [k for k in range(count) if self._acts(k)]
        self.off = [name for k, name in enumerate(self._motors) if k not in self._acting]

    def motors(self) -> Iterator[Motor]:
        """Yield the motors of joints."""
        for k in self._acting:
            yield from self._motor(k)

    def thrusters(self) -> Iterator[Thruster]:
        """Yield what pushes at sites."""
        for k in self._acting:
            yield from self._thruster(k)

    def pulls(self) -> Iterator[TendonMotor]:
        """Yield what acts on several joints, by a fixed tendon."""
        for k in filter(self._on_fixed_tendon, self._acting):
            tendon, pulled = int(self._model.actuator_trnid[k, 0]), dict(self._pulled(k))
            above = [j for j in pulled if self._model.jnt_actfrclimited[j]]
            why = self._no_motor(k)
            if above or self._model.tendon_actfrclimited[tendon]:
                who = f"joint {self._joints[above[0]]}" if above else "its tendon"
                why = why or f"{who} has actuatorfrcrange"
            if why:
                self._cannot(f"actuator {self._motors[k]} is no motor of a tendon: {why}.")
                continue
            force = self._force_limits(k)
            if self._are_limits(k, ends := self._input_limits(k, force)):
                joints = {self._joints[j]: factor for j, factor in pulled.items() if factor}
                name = self._input_name(k, "pull")
                self._note_servo(k, name, joints, force)
                yield TendonMotor(name, joints, *ends.tolist())

    def _on_fixed_tendon(self, k: int) -> bool:
        """Whether an actuator acts on a tendon whose length is a sum of joints' positions."""
        of_tendons = int(self._mujoco.mjtTrn.mjTRN_TENDON)
        joint = int(self._mujoco.mjtWrap.mjWRAP_JOINT)
        if int(self._model.actuator_trntype[k]) != of_tendons:
            return False
        return all(int(self._model.wrap_type[w]) == joint for w in self._wrapped(k))

    def _wrapped(self, k: int) -> range:
        tendon = int(self._model.actuator_trnid[k, 0])
        first = int(self._model.tendon_adr[tendon])
        return range(first, first + int(self._model.tendon_num[tendon]))

    def _pulled(self, k: int) -> Iterator[tuple[int, float]]:
        """Yield the joints of an actuator's tendon, and its force on each for a unit of its own."""
        gear = float(self._model.actuator_gear[self._output[k], 0])
        for w in self._wrapped(k):
            yield int(self._model.wrap_objid[w]), gear * float(self._model.wrap_prm[w])

    def _acts(self, k: int) -> bool:
        """Whether the group of an actuator is not disabled."""
        group = int(self._model.actuator_group[k])
        return group < 0 or not int(self._model.opt.disableactuator) >> group & 1

    def _motor(self, k: int) -> Iterator[Motor]:
        """Yield an actuator as a motor."""
        model, mujoco, name = self._model, self._mujoco, self._motors[k]
        if self._pushes(k) or self._on_fixed_tendon(k):
            return
        if not self._turns(k):
            kind = mujoco.mjtTrn(int(model.actuator_trntype[k])).name.split("_")[-1].lower()
            what = f"actuator {name} does not act on a joint, but by the transmission {kind}."
            self._cannot(what, "Joints, fixed tendons, and sites without refsite are moved.")
            return
        joint = int(model.actuator_trnid[k, 0])
        single = mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE
        if mujoco.mjtJoint(int(model.jnt_type[joint])) not in single:
            what = f"actuator {name} acts on the joint {self._joints[joint]} with several rates."
            self._cannot(what, "Motors act on hinges and slides, thrusters on sites.")
            return
        if why := self._no_motor(k):
            self._cannot(f"actuator {name} is no motor: {why}.")
            return
        gear, force = float(model.actuator_gear[self._output[k], 0]), self._within_joint(joint, k)
        if self._are_limits(k, ends := self._input_limits(k, force, gear)):
            turns = mujoco.mjtJoint(int(model.jnt_type[joint])) == single[0]
            name = self._input_name(k, "torque" if turns else "force")
            self._note_servo(k, name, {self._joints[joint]: gear}, force, gear)
            yield Motor(name, self._joints[joint], *ends.tolist())

    def _note_servo(
        self, k: int, name: str, lengths: Mapping[str, float], ends: Array, unit: float = 1.0
    ) -> None:
        """Keep what a servo can aim at, if that has limits.

        Args:
            k: Its number.
            name: Of its input.
            lengths: By how much its length grows with each joint.
            ends: Limits (2,) of its force, infinite ones if none, in units of its input.
            unit: What the input is for each unit of its force.
        """
        _, of_length, of_velocity = (-unit * self._bias(k)).tolist()
        if (of_length or of_velocity) and self._model.actuator_ctrllimited[self._control[k]]:
            low, high = np.sort(unit * self._aimed(k)).tolist()
            servo = Servo(name, lengths, unit, low, high, of_length, of_velocity, *ends.tolist())
            self.servos.append(servo)

    def _input_limits(self, k: int, force: Array, unit: float = 1.0) -> Array:
        """Return the limits (2,) of an input: of its force, or of what it aims at without those.

        MuJoCo does not clip the force of a servo without a ``forcerange``, which is linear then.
        """
        if np.isfinite(force).all() or not self._model.actuator_ctrllimited[self._control[k]]:
            return force
        return np.sort(unit * self._aimed(k))

    def _aimed(self, k: int) -> Array:
        """Return the force (2,) of an actuator at the ends of its control, at rest at length 0."""
        ends = np.array(self._model.actuator_ctrlrange[self._control[k]])
        return np.sort(float(self._model.actuator_gainprm[k, 0]) * ends + self._bias(k)[0])

    def _within_joint(self, joint: int, k: int) -> Array:
        """Return the limits (2,) of an actuator's force on its joint, which may limit all of it."""
        model, own = self._model, self._on_joint(k)
        if not model.jnt_actfrclimited[joint]:
            return own
        low, high = map(float, model.jnt_actfrcrange[joint])
        others = [
            self._on_joint(a)
            for a in self._acting
            if a != k and self._turns(a) and int(model.actuator_trnid[a, 0]) == joint
        ]
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
        gear = float(self._model.actuator_gear[self._output[k], 0])
        return np.sort(gear * self._force_limits(k)) if gear else np.zeros(2)

    def _are_limits(self, k: int, ends: Array) -> bool:
        """Whether an input may have limits (2,); none needs to be there that is always 0."""
        name = self._motors[k]
        if not np.isfinite(ends).all():
            remedy = "Give it a ctrlrange or a forcerange, or its joint an actuatorfrcrange."
            self._cannot(f"actuator {name} has no limit of its force.", remedy)
            return False
        if ends[0] == ends[1] != 0.0:
            self._cannot(f"actuator {name} always has the force {ends[0]:g}, which is no input.")
        return bool(ends[0] < ends[1])

    def _thruster(self, k: int) -> Iterator[Thruster]:
        """Yield an actuator that acts on a site as a thruster."""
        model, name = self._model, self._input_name(k, "thrust")
        if not self._pushes(k):
            return
        site = int(model.actuator_trnid[k, 0])
        body = int(model.site_bodyid[site])
        if why := self._no_motor(k) or self._limit_above(body):
            self._cannot(f"actuator {self._motors[k]} is no thruster: {why}.")
            return
        # a site has no length, so that a servo of positions pushes by its gain times its control
        if self._bias(k)[2]:
            self._cannot(f"actuator {self._motors[k]} is no thruster: it brakes its site.")
            return
        ends = self._force_limits(k, of_control=True)
        if self._are_limits(k, ends):
            gear = np.array(model.actuator_gear[self._output[k]])
            turn = self._compiled.turn(model.site_quat[site])
            pose = pose_of(np.array(model.site_pos[site]), turn)
            yield Thruster(name, self._bodies[body], pose, gear[:3], gear[3:], *ends.tolist())

    def _limit_above(self, body: int) -> str:
        """Return which joint that moves a body limits the force of all actuators, if any does."""
        model = self._model
        while body != WORLD_BODY:
            first = int(model.body_jntadr[body])
            for joint in range(first, first + int(model.body_jntnum[body])):
                if model.jnt_actfrclimited[joint]:
                    return f"joint {self._joints[joint]} has actuatorfrcrange"
            body = int(model.body_parentid[body])
        return ""

    def _pushes(self, k: int) -> bool:
        """Whether an actuator acts on a site alone, in the site's axes."""
        site = int(self._mujoco.mjtTrn.mjTRN_SITE)
        ids = self._model.actuator_trnid[k]
        return int(self._model.actuator_trntype[k]) == site and int(ids[1]) < 0

    def _turns(self, k: int) -> bool:
        """Whether an actuator acts on a joint; hinges and slides have one axis in both bodies."""
        kinds = self._mujoco.mjtTrn.mjTRN_JOINT, self._mujoco.mjtTrn.mjTRN_JOINTINPARENT
        return int(self._model.actuator_trntype[k]) in map(int, kinds)

    def _input_name(self, k: int, word: str) -> str:
        """Return the name of an actuator's input, with a word to it if a joint has the name."""
        name = usable_name(self._motors[k])
        return f"{name}_{word}" if name in map(usable_name, self._joints) else name

    def _no_motor(self, k: int) -> str:
        """Return why an actuator is neither a motor nor a servo, if so."""
        model, mujoco = self._model, self._mujoco
        for word, kinds, wanted in (
            ("dyntype", mujoco.mjtDyn, ("none",)),
            ("gaintype", mujoco.mjtGain, ("fixed",)),
            ("biastype", mujoco.mjtBias, ("none", "affine")),
        ):
            kind = kinds(int(getattr(model, f"actuator_{word}")[k])).name.split("_")[-1].lower()
            if kind not in wanted:
                return f"its {word} is {kind}"
        passive = not model.actuator_gainprm[k, 0] and self._bias(k).any()
        return "its gain is 0, so that it pushes whatever its control is" if passive else ""

    def _bias(self, k: int) -> Array:
        """Return constant, factors of length and of velocity of an actuator's bias, shape (3,)."""
        affine = int(self._mujoco.mjtBias.mjBIAS_AFFINE)
        counts = int(self._model.actuator_biastype[k]) == affine
        return np.array(self._model.actuator_biasprm[k, :3]) if counts else np.zeros(3)

    def _force_limits(self, k: int, *, of_control: bool = False) -> Array:
        """Return the limits (2,) of an actuator's force before its gear, infinite ones if none.

        Args:
            k: Its number.
            of_control: Whether limits of its control are limits of its force, servo or not.
        """
        model, at = self._model, self._control[k]
        gain, ends = float(model.actuator_gainprm[k, 0]), np.array([-math.inf, math.inf])
        of_control = of_control or not self._bias(k)[1:].any()
        if not gain or (model.actuator_ctrllimited[at] and of_control):
            ends = self._aimed(k)
        if model.actuator_forcelimited[k]:
            ends = np.clip(ends, *model.actuator_forcerange[k])
        return ends
