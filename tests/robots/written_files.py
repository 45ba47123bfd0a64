"""Machines written to files, in the words of the engines that read them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest

from kinolab.dynamics import Attitude, Coordinate, Model, System
from kinolab.numerics.arrays import Array

mujoco: Any = pytest.importorskip("mujoco")

FREE = mujoco.mjtJoint.mjJNT_FREE
RANGE = 1.5  # [m] or [rad] on either side of zero, where a coordinate has no limits


def instants(
    system: System, model: Model, count: int
) -> Iterator[tuple[dict[str, Array], Array, Array]]:
    """Yield configurations with velocities by name, states and inputs, within limits.

    Of an attitude: quaternion x, y, z, w and turn rates; of other coordinates their value and rate.
    """
    generator, names = np.random.default_rng(5), list(model.state_names)
    for _ in range(count):
        x, given = np.zeros(model.nx), {}
        for c in system.coordinates:
            if isinstance(c, Attitude):
                turn, rates = generator.normal(size=4), generator.normal(size=3)
                turn /= np.linalg.norm(turn)
                first = model.attitudes[c.name]
                x[first : first + 4] = turn
                for axis, part in zip("xyz", rates, strict=True):
                    x[names.index(f"{c.name}_w{axis}")] = part
                given[c.name] = np.array([*turn, *rates])
                continue
            low = c.lower if np.isfinite(c.lower) else min(-RANGE, c.upper - RANGE)
            high = c.upper if np.isfinite(c.upper) else max(RANGE, c.lower + RANGE)
            given[c.name] = np.array([generator.uniform(low, high), generator.normal()])
            x[names.index(c.name)], x[names.index(f"{c.name}_dot")] = given[c.name]
        yield given, x, generator.uniform(*model.control_bounds.T)


def accelerations(system: System, model: Model, slope: Array) -> dict[str, Array]:
    """Return second derivatives by the name of the coordinate: three of an attitude."""
    names = list(model.state_names)
    return {
        c.name: np.array([slope[names.index(f"{c.name}_dot")]])
        if isinstance(c, Coordinate)
        else np.array([slope[names.index(f"{c.name}_w{axis}")] for axis in "xyz"])
        for c in system.coordinates
    }


def largest_gap(ours: Mapping[str, Array], theirs: Mapping[str, Array]) -> float:
    """Return the largest difference, relative to the largest entry or 1."""
    assert ours.keys() == theirs.keys()
    one, other = (np.concatenate([each[name] for name in ours]) for each in (ours, theirs))
    return float(np.abs(one - other).max() / max(1.0, np.abs(other).max()))


class InMujoco:
    """MuJoCo's model of a text, without contacts, limits and soft constraints.

    Args:
        text: The file.
        free: Names of the lengths x, y and z that a free joint of this name has, if any.
        factors: By which positions of joints differ from coordinates.
    """

    def __init__(
        self,
        text: str,
        free: Mapping[str, tuple[str, str, str]] | None = None,
        factors: Mapping[str, float] | None = None,
    ) -> None:
        self.model: Any = mujoco.MjModel.from_xml_string(text)
        bits = mujoco.mjtDisableBit
        self.model.opt.disableflags |= int(bits.mjDSBL_CONSTRAINT)
        self.data: Any = mujoco.MjData(self.model)
        self._free, self._factors = free or {}, factors or {}

    def put(self, given: Mapping[str, Array]) -> None:
        """Set positions and velocities."""
        data = self.data
        for j in range(self.model.njnt):
            name = self.model.joint(j).name
            q, v = int(self.model.jnt_qposadr[j]), int(self.model.jnt_dofadr[j])
            if self.model.jnt_type[j] == FREE:
                for k, axis in enumerate(self._free[name]):
                    data.qpos[q + k], data.qvel[v + k] = given[axis]
                q, v = q + 3, v + 3
            if name not in given:
                continue  # it follows another joint
            if len(given[name]) == 7:
                data.qpos[q : q + 4] = np.roll(given[name][:4], 1)  # w comes first
                data.qvel[v : v + 3] = given[name][4:]
            else:
                factor = self._factors.get(name, 1.0)
                data.qpos[q], data.qvel[v] = factor * given[name]

    def accelerations(self, given: Mapping[str, Array], u: Mapping[str, float]) -> dict[str, Array]:
        """Return second derivatives by the name of the coordinate."""
        self.put(given)
        for k in range(self.model.nu):
            self.data.ctrl[k] = u[self.model.actuator(k).name]
        mujoco.mj_forward(self.model, self.data)
        found = {}
        for j in range(self.model.njnt):
            name, v = self.model.joint(j).name, int(self.model.jnt_dofadr[j])
            if self.model.jnt_type[j] == FREE:
                for k, axis in enumerate(self._free[name]):
                    found[axis] = np.array([self.data.qacc[v + k]])
                v += 3
            if name not in given:
                continue
            size = 3 if len(given[name]) == 7 else 1
            own = np.array(self.data.qacc[v : v + size])
            found[name] = own / self._factors.get(name, 1.0)
        return found


class InPinocchio:
    """Pinocchio's model of a URDF file.

    Args:
        text: The file.
        factors: By which positions of joints differ from coordinates.
    """

    def __init__(self, text: str, factors: Mapping[str, float] | None = None) -> None:
        import pinocchio

        self._pin: Any = pinocchio
        self.model: Any = pinocchio.buildModelFromXML(text)
        self._data, self._factors = self.model.createData(), factors or {}

    def accelerations(
        self,
        given: Mapping[str, Array],
        forces: Mapping[str, float],
        damping: Mapping[str, float],
    ) -> dict[str, Array]:
        """Return second derivatives by the name of the coordinate; Pinocchio has no damping.

        Args:
            given: Positions and rates of coordinates.
            forces: Of motors, by joint.
            damping: By joint.
        """
        pin, model = self._pin, self.model
        q, v, tau = pin.neutral(model), np.zeros(model.nv), np.zeros(model.nv)
        own = {name: model.joints[model.getJointId(name)] for name in given}
        for name, joint in own.items():
            at, speed = self._factors.get(name, 1.0) * given[name]
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                at if joint.nq == 1 else [np.cos(at), np.sin(at)]
            )
            v[joint.idx_v] = speed
            tau[joint.idx_v] = forces.get(name, 0.0) - damping.get(name, 0.0) * speed
        slope = pin.aba(model, self._data, q, v, tau)
        pin.framesForwardKinematics(model, self._data, q)
        return {
            name: np.array([slope[joint.idx_v] / self._factors.get(name, 1.0)])
            for name, joint in own.items()
        }

    def pose(self, link: str, of: str) -> Array:
        """Return the pose (4, 4) of a link in another one's frame, where they were last."""
        first, second = (
            self._data.oMf[self.model.getFrameId(name)].homogeneous for name in (link, of)
        )
        found: Array = np.linalg.inv(second) @ first
        return found
