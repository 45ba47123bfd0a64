"""Validity of configurations, without dynamics: limits, workspace and collisions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.problem.task import LIMIT_TOLERANCE
from kinolab.simulation import CompiledStep
from kinolab.world import CollisionChecker


class FreeSpace:
    """Checks configurations of a machine, or of a shrunk one.

    Args:
        checker: Collision checker of the machine, shrunk as desired.
        shifts: How its bodies are displaced in their own frames in [m], shape (bodies, 3).
    """

    def __init__(
        self, problem: PlanningTask, checker: CollisionChecker, shifts: Array | None = None
    ) -> None:
        self._calls = CompiledStep(problem)
        poses = self._calls.poses.reshape(-1, 3, 4)  # of the same memory
        self._axes, self._places = poses[:, :, :3], poses[:, :, 3:]
        self._shifts = shifts[:, :, None] if shifts is not None and shifts.any() else None
        self._problem, self._checker = problem, checker
        nq, unlimited = problem.model.nq, problem.space.turns
        self._limits = [
            (i, float(lower) - LIMIT_TOLERANCE, float(upper) + LIMIT_TOLERANCE)
            for i, (lower, upper) in enumerate(problem.bounds[:nq])
            if not unlimited[i]
        ]

    def free(self, x: Sequence[float]) -> bool:
        """Return whether a state's configuration is within all limits and collision-free."""
        for i, lower, upper in self._limits:
            if not lower <= x[i] <= upper:
                return False
        calls = self._place(x)
        if next(self._problem.outside_world(calls.poses), None) is not None:
            return False
        return not self._checker.collides(calls.poses, calls.ends)

    def collides(self, x: Sequence[float], shift: Array | None = None) -> bool:
        """Return whether the machine collides when translated by ``shift`` (3,) in [m]."""
        shift = np.zeros(3) if shift is None else shift
        calls = self._place(x)
        poses, ends = calls.poses.copy(), calls.ends.copy()
        poses[:, 3::4] += shift
        ends += np.tile(shift, 2)
        return self._checker.collides(poses, ends)

    def touches(self, x: Sequence[float]) -> list[str]:
        """Name the colliding pairs of body and obstacle."""
        calls = self._place(x)
        found = self._checker.contacts(calls.poses, calls.ends)
        return [f"{contact.body} – {contact.obstacle}" for contact in found]

    def _place(self, x: Sequence[float]) -> CompiledStep:
        self._calls.next[:] = x
        self._calls.frames()
        if self._shifts is not None:
            self._places += np.matmul(self._axes, self._shifts)
        return self._calls
