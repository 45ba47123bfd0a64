"""The motion of a robot by MuJoCo's own model of the same file, without contacts and limits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco as mujoco_library
import numpy as np

from kinolab.dynamics import Model, System
from kinolab.numerics.arrays import Array
from tests.robots.against_pinocchio import spelled

mujoco: Any = mujoco_library
FREE, BALL = mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_BALL
# Their inputs are torques and forces after the gear, those of tendons and sites before it.
ON_JOINTS = [int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)]
SMOOTHING = 0.01  # of kinolab's Coulomb friction: tanh(v / SMOOTHING)
UNCLAMPED = (
    *("actuator_ctrllimited", "actuator_forcelimited"),
    *("jnt_actfrclimited", "tendon_actfrclimited"),
)


class SecondEngine:
    """MuJoCo's own model of a file; joints that follow others do so exactly.

    Args:
        file: The file.
        system: kinolab's machine, for the names of its inputs.
        model: kinolab's model of it.
    """

    def __init__(self, file: Path, system: System, model: Model) -> None:
        before = mujoco.get_mju_user_warning()
        mujoco.set_mju_user_warning(lambda _: None)  # else it writes a file where tests run
        self.model: Any = mujoco.MjModel.from_xml_path(str(file))
        mujoco.set_mju_user_warning(before)
        bits, flags = mujoco.mjtDisableBit, self.model.opt.disableflags
        frictionless = int(bits.mjDSBL_FRICTIONLOSS) | int(bits.mjDSBL_CONSTRAINT)
        self._friction = self.model.dof_frictionloss * (not flags & frictionless)
        limited = self.model.actuator_ctrllimited.astype(bool)
        self._linear = limited & ~self.model.actuator_forcelimited.astype(bool)  # if it is a servo
        sticking = self.model.tendon_frictionloss * (not flags & frictionless)
        self._sticking = [(f, self._row(t)) for t, f in enumerate(sticking) if f]
        self._followers = {} if flags & int(bits.mjDSBL_CONSTRAINT) else dict(self._following())
        self.model.opt.disableflags |= int(bits.mjDSBL_CONSTRAINT)
        self._limited = np.array(self.model.jnt_actfrclimited)
        self._tendons_limited = np.array(self.model.tendon_actfrclimited)
        for name in UNCLAMPED:
            getattr(self.model, name)[...] = 0
        self._data, self._own, self._system = mujoco.MjData(self.model), model, system

    def joints(self) -> list[tuple[str, int, int, int]]:
        """Return name, kind and the first entries of qpos and qvel of every joint."""
        model = self.model
        return [
            (spelled(model.joint(j).name or f"joint_{j + 1}"), int(model.jnt_type[j]),
             int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j]))
            for j in range(model.njnt)
        ]  # fmt: skip

    def compare(self, generator: np.random.Generator) -> tuple[Array, Array]:
        """Return kinolab's and MuJoCo's derivative of the velocities that are free.

        The state is random, and so are the inputs.
        """
        own, model, data = self._own, self.model, self._data
        x, free, entries = self._random_state(generator)
        inputs = [entry.name for entry in self._system.inputs]
        u, data.ctrl[:] = generator.normal(size=own.nu), 0.0
        mujoco.mj_forward(model, data)
        for k, force in enumerate(np.array(data.actuator_force)):
            motor = spelled(model.actuator(k).name or f"motor_{k + 1}")
            words = "torque", "force", "thrust", "pull", "command"
            names = [motor, *(f"{motor}_{word}" for word in words)]
            at = next((i for i, name in enumerate(inputs) if name in names), None)
            if at is None:  # it does nothing, or is off
                continue
            gear = model.actuator_gear[k, 0] if model.actuator_trntype[k] in ON_JOINTS else 1.0
            servo = self._linear[k] and model.actuator_biasprm[k, 1:3].any()
            if (servo and not self._limited_above(k)) or model.actuator_dyntype[k]:
                data.ctrl[k] = u[at]  # its command
                continue
            data.ctrl[k] = (u[at] / gear - force) / model.actuator_gainprm[k, 0]
        mujoco.mj_forward(model, data)
        mass = np.empty((model.nv, model.nv))
        for k, unit in enumerate(np.eye(model.nv)):
            mujoco.mj_mulM(model, data, mass[k], unit)
        force = data.qfrc_passive + data.qfrc_actuator - data.qfrc_bias
        force = force - self._friction * np.tanh(data.qvel / SMOOTHING)
        for strength, row in self._sticking:
            force = force - strength * np.tanh(row @ data.qvel / SMOOTHING) * row
        theirs = np.linalg.solve(free.T @ mass @ free, free.T @ force)
        return own.f(x, u)[entries], theirs

    def _limited_above(self, k: int) -> bool:
        """Whether an actuator acts on a joint or tendon that limits its force."""
        on, at = int(self.model.actuator_trntype[k]), int(self.model.actuator_trnid[k, 0])
        if on == int(mujoco.mjtTrn.mjTRN_TENDON):
            return bool(self._tendons_limited[at])
        return on in ON_JOINTS and bool(self._limited[at])

    def _row(self, tendon: int) -> Array:
        """Return by how much a fixed tendon's length grows with each velocity."""
        model, row = self.model, np.zeros(self.model.nv)
        first, count = int(model.tendon_adr[tendon]), int(model.tendon_num[tendon])
        for w in range(first, first + count):
            row[model.jnt_dofadr[model.wrap_objid[w]]] += model.wrap_prm[w]
        return row

    def _random_state(self, generator: np.random.Generator) -> tuple[Array, Array, list[int]]:
        """Set MuJoCo's state; return kinolab's, the free velocities as columns, and their rates."""
        own, model, data = self._own, self.model, self._data
        names, x = list(own.state_names), np.zeros(own.nx)
        columns: list[Array] = []
        entries: list[int] = []
        for name, kind, q, v in self.joints():
            if kind in (FREE, BALL):
                turn = generator.normal(size=4)
                turn /= np.linalg.norm(turn)
                first, begin = own.attitudes[name], q + 3 * (kind == FREE)
                x[first : first + 4] = np.roll(turn, -1)  # MuJoCo's begins with w
                data.qpos[begin : begin + 4] = turn
                if kind == FREE:
                    data.qpos[q : q + 3] = generator.normal(size=3)
                    x[[names.index(f"{name}_at_{axis}") for axis in "xyz"]] = data.qpos[q : q + 3]
                rates = [f"{name}_at_{axis}_dot" for axis in "xyz"] if kind == FREE else []
                rates += [f"{name}_w{axis}" for axis in "xyz"]
            elif name in names:
                data.qpos[q] = x[names.index(name)] = generator.uniform(-1.0, 1.0)
                rates = [f"{name}_dot"]
            else:  # it follows another one, or has no room between its limits
                data.qpos[q] = model.jnt_range[model.dof_jntid[v], 0]
                continue
            for k, rate in enumerate(rates):
                columns.append(np.eye(model.nv)[v + k])
                entries.append(names.index(rate))
        free = np.array(columns).reshape(-1, model.nv).T
        for _ in self._followers:  # one follows another that follows, at most as often as there are
            for own_joint, (leader, offset, factor) in self._followers.items():
                (q, v), (ql, vl) = (
                    (int(model.jnt_qposadr[j]), int(model.jnt_dofadr[j]))
                    for j in (own_joint, leader)
                )
                data.qpos[q] = model.qpos0[q] + offset + factor * (data.qpos[ql] - model.qpos0[ql])
                free[v] = factor * free[vl]
        for k in range(model.nu):
            state = f"{spelled(model.actuator(k).name or f'motor_{k + 1}')}_act"
            if state in names:
                at = names.index(state)
                data.act[model.actuator_actadr[k]] = x[at] = generator.normal()
        rates_now = generator.normal(size=len(entries))
        x[entries], data.qvel[:] = rates_now, free @ rates_now
        return x, free, entries

    def _following(self) -> list[tuple[int, tuple[int, float, float]]]:
        """Return the joints that follow others: leader, offset and factor."""
        model = self.model
        joints = model.eq_type == int(mujoco.mjtEq.mjEQ_JOINT)
        return [
            (int(model.eq_obj1id[k]),
             (int(model.eq_obj2id[k]), float(model.eq_data[k, 0]), float(model.eq_data[k, 1])))
            for k in np.flatnonzero(joints & (model.eq_active0 != 0))
        ]  # fmt: skip


def difference(file: Path, system: System, states: int, seed: int) -> float:
    """Return how far accelerations differ at random states, relative to the largest one."""
    engine = SecondEngine(file, system, system.model())
    generator = np.random.default_rng(seed)
    pairs = [engine.compare(generator) for _ in range(states)]
    return max(
        (float(np.abs(ours - theirs).max() / max(1.0, np.abs(theirs).max()))
         for ours, theirs in pairs if len(ours)),
        default=0.0,
    )  # fmt: skip
