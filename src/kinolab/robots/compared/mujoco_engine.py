"""A robot in MuJoCo: its mass matrix, bias and passive forces, and its equality constraints.

Source: MuJoCo's documentation, chapter Computation, General framework.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.robots.compared.second_engine import AbstractSecondEngine, Held

WIDTHS = {"FREE": (7, 6), "BALL": (4, 3), "SLIDE": (1, 1), "HINGE": (1, 1)}  # qpos, rates


class MujocoEngine(AbstractSecondEngine):
    """MuJoCo's model of a file.

    Args:
        model: Its compiled model, of which nobody asks for contacts any more.
        joints: What its joints are called.
    """

    name = "MuJoCo"

    def __init__(self, mujoco: Any, model: Any, joints: Sequence[str]) -> None:
        model.opt.enableflags = 0  # one lets trees sleep that should move
        model.jnt_actgravcomp[:] = 0  # what bears weight is passive, whatever takes its force
        for flag in ("CONTACT", "LIMIT", "FRICTIONLOSS", "ACTUATION"):  # by flags of <option>
            model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}"))
        self._mujoco, self._model, self._data = mujoco, model, mujoco.MjData(model)
        self._positions: dict[str, slice] = {}
        rates: dict[str, slice] = {}
        for k, name in enumerate(joints):
            kind = mujoco.mjtJoint(int(model.jnt_type[k])).name.removeprefix("mjJNT_")
            q, v = int(model.jnt_qposadr[k]), int(model.jnt_dofadr[k])
            self._positions[name] = slice(q, q + WIDTHS[kind][0])
            rates[name] = slice(v, v + WIDTHS[kind][1])
        self.rates = rates

    def forces(self, at: Mapping[str, Array], v: Array, a: Array) -> tuple[Array, Array]:
        """Return M a + c - Q, and the sizes of its terms, as the base class says."""
        model, data = self._model, self._data
        self._place(at, v)
        M = np.array([self._times(self._mujoco.mj_mulM, model.nv, e) for e in np.eye(model.nv)])
        bias, passive = np.array(data.qfrc_bias), np.array(data.qfrc_passive)
        return M @ a + bias - passive, np.abs(M) @ np.abs(a) + np.abs(bias) + np.abs(passive)

    def held(self, at: Mapping[str, Array]) -> Held:
        """Return what equality constraints hold together, welds without their scale of torques."""
        model, data = self._model, self._data
        self._place(at, np.zeros(model.nv))
        rows, units = int(data.nefc), np.eye(model.nv)
        slopes = np.array([self._times(self._mujoco.mj_mulJacVec, rows, e) for e in units]).T
        numbers = [int(k) for k in data.efc_id[:rows]]
        scales = np.ones(rows)
        for row, k in enumerate(numbers):
            welded = int(model.eq_type[k]) == int(self._mujoco.mjtEq.mjEQ_WELD)
            if welded and row - numbers.index(k) >= 3 and model.eq_data[k, 10]:
                scales[row] = model.eq_data[k, 10]
        kind = self._mujoco.mjtObj.mjOBJ_EQUALITY
        found = [self._mujoco.mj_id2name(model, kind, k) or f"equality_{k + 1}" for k in numbers]
        gaps = np.array(data.efc_pos[:rows]) / scales
        return Held(tuple(found), gaps, slopes.reshape(rows, model.nv) / scales[:, None])

    def _place(self, at: Mapping[str, Array], v: Array) -> None:
        """Set positions and rates, and compute all that depends on them."""
        for name, where in at.items():
            own = np.array(where)
            if len(own) >= 4:  # MuJoCo's quaternions begin with w
                own[-4:] = np.roll(own[-4:], 1)
            self._data.qpos[self._positions[name]] = own
        self._data.qvel[:] = v
        with quiet(self._mujoco):
            self._mujoco.mj_fwdPosition(self._model, self._data)
            self._mujoco.mj_fwdVelocity(self._model, self._data)

    def _times(self, multiply: Any, size: int, vector: Array) -> Array:
        """Return the product of a matrix of MuJoCo's and a vector, shape (size,)."""
        product = np.zeros(size)
        multiply(self._model, self._data, product, vector)
        return product


@contextmanager
def quiet(mujoco: Any) -> Iterator[None]:
    """Let MuJoCo say no warnings, which go to a file in the working directory."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)
