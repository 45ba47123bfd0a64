"""The motion of a robot by Pinocchio, a second engine that reads the same file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from kinolab.dynamics import Model, System
from kinolab.numerics.arrays import Array


@dataclass(frozen=True)
class Instant:
    """A state with inputs, in the words of both engines."""

    x: Array
    u: Array
    q: Array
    v: Array
    tau: Array


class SecondEngine:
    """Pinocchio's model of a URDF file.

    Args:
        file: The file.
        floating: Whether the root moves freely.
        system: kinolab's machine, for the names and the friction, which Pinocchio leaves out.
    """

    def __init__(self, file: Path, system: System, model: Model, *, floating: bool) -> None:
        import pinocchio

        self._pin: Any = pinocchio
        root = (pinocchio.JointModelFreeFlyer(),) if floating else ()
        self.model = pinocchio.buildModelFromUrdf(str(file), *root)
        self.model.gravity.linear[:] = 0.0, 0.0, -9.81
        self._data, self._own, self._system = self.model.createData(), model, system
        self._joints = {
            name: joint
            for name, joint in zip(self.model.names, self.model.joints, strict=True)
            if name not in ("universe", "root_joint")
        }
        self._floating = floating
        # joints without room between their limits
        moving = {*model.state_names}
        self._held = {name for name in self._joints if spelled(name) not in moving}
        self.follows = {
            joint.attrib["name"]: (
                mimic.attrib["joint"],
                float(mimic.attrib.get("multiplier", 1.0)),
                float(mimic.attrib.get("offset", 0.0)),
            )
            for joint in ElementTree.parse(file).getroot().iter("joint")
            for mimic in joint.iter("mimic")
        }
        self._held -= {*self.follows}

    def at(self, generator: np.random.Generator) -> Instant:
        """Return a random state with random inputs."""
        pin, own = self._pin, self._own
        q, v, tau = pin.neutral(self.model), np.zeros(self.model.nv), np.zeros(self.model.nv)
        x, names = np.zeros(own.nx), list(own.state_names)
        if self._floating:
            place, turn = generator.normal(size=3), generator.normal(size=4)
            turn /= np.linalg.norm(turn)
            v[:6] = generator.normal(size=6)
            q[:7] = *place, *turn
            first = own.attitudes["base"]
            x[first : first + 4] = turn
            linear = self._turn(q) @ v[:3]
            for k, axis in enumerate("xyz"):
                x[names.index(axis)], x[names.index(f"{axis}_dot")] = place[k], linear[k]
                x[names.index(f"base_w{axis}")] = v[3 + k]
        inputs = [entry.name for entry in self._system.inputs]
        u = generator.normal(size=own.nu)
        for name, joint in self._joints.items():
            leader, factor, offset = self.follows.get(name, (name, 1.0, 0.0))
            if name in self.follows:
                leading = self._joints[leader]
                self._set(q, joint, factor * q[leading.idx_q] + offset)
                v[joint.idx_v] = factor * v[leading.idx_v]
                continue
            if name in self._held:
                self._set(q, joint, float(self.model.lowerPositionLimit[joint.idx_q]))
                continue
            at, v[joint.idx_v] = generator.uniform(-1.0, 1.0), generator.normal()
            self._set(q, joint, at)
            x[names.index(spelled(name))] = at
            x[names.index(f"{spelled(name)}_dot")] = v[joint.idx_v]
            for kind in ("torque", "force"):
                if f"{spelled(name)}_{kind}" in inputs:
                    tau[joint.idx_v] += u[inputs.index(f"{spelled(name)}_{kind}")]
        return Instant(x, u, q, v, tau)

    def accelerations(self, instant: Instant, friction: dict[str, tuple[float, float]]) -> Array:
        """Return the derivative of the velocities of ``v``.

        Args:
            instant: State and inputs.
            friction: Of joints by name: viscous, and Coulomb's, smoothed by 0.01.
        """
        pin, q, v, tau = self._pin, instant.q, instant.v, instant.tau.copy()
        for name, (viscous, dry) in friction.items():
            if name not in self._joints:
                continue
            k = self._joints[name].idx_v
            tau[k] -= viscous * v[k] + dry * np.tanh(v[k] / 0.01)
        if not self.follows and not self._held:
            return np.asarray(pin.aba(self.model, self._data, q, v, tau))
        # Joints that follow others: the equations of all, projected onto what moves freely.
        free = np.eye(self.model.nv)
        for name, (leader, factor, _) in self.follows.items():
            free[self._joints[name].idx_v, self._joints[leader].idx_v] = factor
        followers = {self._joints[name].idx_v for name in {*self.follows} | self._held}
        free = free[:, [k for k in range(self.model.nv) if k not in followers]]
        upper = np.triu(pin.crba(self.model, self._data, q))
        mass, bias = upper + np.triu(upper, 1).T, pin.nle(self.model, self._data, q, v)
        return np.asarray(free @ np.linalg.solve(free.T @ mass @ free, free.T @ (tau - bias)))

    def in_their_words(self, instant: Instant, slope: Array, theirs: Array) -> Array:
        """Return kinolab's state derivative as the derivative of ``v``; of followers theirs."""
        names, found = list(self._own.state_names), np.zeros(self.model.nv)
        if self._floating:
            linear = np.array([slope[names.index(f"{axis}_dot")] for axis in "xyz"])
            # Pinocchio's velocity is that of the root in its own axes, which turn.
            v = instant.v
            found[:3] = self._turn(instant.q).T @ linear - np.cross(v[3:6], v[:3])
            found[3:6] = [slope[names.index(f"base_w{axis}")] for axis in "xyz"]
        for name, joint in self._joints.items():
            k = joint.idx_v
            own = f"{spelled(name)}_dot"
            found[k] = slope[names.index(own)] if own in names else theirs[k]
        return found

    def _turn(self, q: Array) -> Array:
        return np.asarray(self._pin.Quaternion(q[3:7]).toRotationMatrix())

    def _set(self, q: Array, joint: Any, at: float) -> None:
        if joint.nq == 2:  # a joint without limits
            q[joint.idx_q : joint.idx_q + 2] = np.cos(at), np.sin(at)
        else:
            q[joint.idx_q] = at


def difference(
    file: Path, system: System, states: int, seed: int, *, floating: bool = False
) -> float:
    """Return how far accelerations differ at random states, relative to the largest one."""
    model = system.model()
    engine = SecondEngine(file, system, model, floating=floating)
    generator, friction, worst = np.random.default_rng(seed), friction_in(file), 0.0
    for _ in range(states if model.nv else 0):
        instant = engine.at(generator)
        theirs = engine.accelerations(instant, friction)
        ours = engine.in_their_words(instant, model.f(instant.x, instant.u), theirs)
        worst = max(worst, float(np.abs(ours - theirs).max() / max(1.0, np.abs(theirs).max())))
    return worst


def spelled(name: str) -> str:
    """Return a joint's name as a coordinate's."""
    made = "".join(c if c.isalnum() or c == "_" else "_" for c in name.strip())
    return f"_{made}" if made[:1].isdigit() else made


def friction_in(file: Path) -> dict[str, tuple[float, float]]:
    """Return viscous and Coulomb friction of the joints that have some, from the file itself."""
    return {
        joint.attrib["name"]: (
            float(dynamics.attrib.get("damping", 0.0)),
            float(dynamics.attrib.get("friction", 0.0)),
        )
        for joint in ElementTree.parse(file).getroot().iter("joint")
        for dynamics in joint.iter("dynamics")
        if joint.attrib.get("type") in ("revolute", "continuous", "prismatic")
    }
