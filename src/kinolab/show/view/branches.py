"""Segments of a motion with zero-order-hold inputs, and states along them."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np

from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory

SUBSTEPS = 8  # of the integrator per segment, or part of one

# A ``np.recarray`` of segments: ``begin`` and ``end`` in [s], the states ``x`` and ``y`` there, of
# shape (nx,), and the inputs ``u`` held between them, of shape (nu,).
Branches: TypeAlias = Any


def branches_of(trajectory: Trajectory) -> Branches:
    """Return the segments of a motion between its knots."""
    t, x, u = trajectory.t, trajectory.x, trajectory.u
    ends = [("begin", float), ("end", float), ("x", float, x.shape[1:]), ("y", float, x.shape[1:])]
    pieces: Branches = np.recarray(len(u), dtype=[*ends, ("u", float, u.shape[1:])])
    pieces.begin, pieces.end, pieces.x, pieces.y, pieces.u = t[:-1], t[1:], x[:-1], x[1:], u
    return pieces


def halved(pieces: Branches, middle: Array) -> Branches:
    """Return all first halves, then all second ones; ``middle`` (n, nx) joins them."""
    first, second = pieces.copy(), pieces.copy()
    first.end = second.begin = 0.5 * (pieces.begin + pieces.end)
    first.y = second.x = middle
    return np.concatenate([first, second]).view(np.recarray)


class BranchPaths:
    """States of a machine along segments of its motion, according to [integration]."""

    def __init__(self, problem: PlanningTask) -> None:
        self.model, settings = problem.model.plant, problem.scenario.integration
        self._straight = settings.truth == "discrete"  # a discrete map is undefined between steps
        self._method = settings.accurate_method

    def state(self, pieces: Branches, fraction: float) -> Array:
        """Return the states at a fraction of each segment, shape (n, nx)."""
        if self._straight:
            return self.model.space.unit(pieces.x + fraction * (pieces.y - pieces.x))
        spans = fraction * (pieces.end - pieces.begin)
        return self.model.step(pieces.x, pieces.u, spans, method=self._method, substeps=SUBSTEPS)

    def rates(self, pieces: Branches) -> tuple[Array, Array]:
        """Return the state rates at the beginning and at the end, shape (n, nx) each."""
        if self._straight:
            slope = (pieces.y - pieces.x) / (pieces.end - pieces.begin)[:, None]
            return slope, slope
        return self.model.f(pieces.x, pieces.u), self.model.f(pieces.y, pieces.u)
