"""A robot in Pinocchio, where it is installed: its mass matrix, nonlinear effects and damping.

Source: Pinocchio's documentation, classes Model, JointModelFreeFlyer and algorithms crba, nle.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.robots.compared.second_engine import AbstractSecondEngine, Held


class PinocchioEngine(AbstractSecondEngine):
    """Pinocchio's model of a URDF file. Joints that follow others move by themselves in it.

    Args:
        free: What the joint is called by which the root moves freely, if it does.
    """

    name = "Pinocchio"

    def __init__(self, pinocchio: Any, text: str, free: str | None = None) -> None:
        root = () if free is None else (pinocchio.JointModelFreeFlyer(),)
        self._pinocchio = pinocchio
        self._model = pinocchio.buildModelFromXML(text, *root)
        self._data = self._model.createData()
        named = zip(self._model.names, self._model.joints, strict=True)
        # "root_joint" and "universe" are what Pinocchio calls the joint of a root that moves freely
        self._joints = {
            free if name == "root_joint" and free is not None else str(name): joint
            for name, joint in named
            if name != "universe"
        }
        self.rates = {n: slice(j.idx_v, j.idx_v + j.nv) for n, j in self._joints.items()}

    def forces(self, at: Mapping[str, Array], v: Array, a: Array) -> tuple[Array, Array]:
        """Return M a + c - Q, and the sizes of its terms, as the base class says."""
        pinocchio, model, data = self._pinocchio, self._model, self._data
        q, v, a = pinocchio.neutral(model), v.copy(), a.copy()
        turns = np.eye(model.nv)  # a free joint's rates in Pinocchio are in its child's axes
        for name, joint in self._joints.items():
            own, where = self.rates[name], at[name]
            if joint.nv == 6:
                turn = pinocchio.Quaternion(where[3:]).toRotationMatrix()
                linear = slice(own.start, own.start + 3)
                spin = v[own][3:]
                turns[linear, linear] = turn.T
                v[linear], a[linear] = turn.T @ v[linear], turn.T @ a[linear]
                a[linear] -= np.cross(spin, v[linear])
            circular = joint.nv == 1 and joint.nq == 2
            q[joint.idx_q : joint.idx_q + joint.nq] = (
                (np.cos(where[0]), np.sin(where[0])) if circular else where
            )
        upper = np.triu(pinocchio.crba(model, data, q))
        M, bias = upper + np.triu(upper, 1).T, pinocchio.nle(model, data, q, v)
        damping = model.damping * v
        sizes = np.abs(M) @ np.abs(a) + np.abs(bias) + np.abs(damping)
        return turns.T @ (M @ a + bias + damping), np.abs(turns).T @ sizes

    def held(self, at: Mapping[str, Array]) -> Held:  # noqa: ARG002 - a URDF file holds nothing
        """Return no constraints: a URDF file has none beside joints that follow others."""
        return Held((), np.zeros(0), np.zeros((0, self._model.nv)))
