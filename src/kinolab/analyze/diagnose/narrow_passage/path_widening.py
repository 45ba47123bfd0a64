"""Widen a path by smooth random deformations on all scales, so that larger machines fit.

A deformation is kept if it blocks the larger machine at no more states than before and the smaller
one at none. The machine is enlarged as far as possible.

Source of the idea: Saha, Latombe, Chang, Prinz, Finding narrow passages with probabilistic
roadmaps: the small-step retraction method, Autonomous Robots 19(3), 2005.
"""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np
from numpy.typing import NDArray

from kinolab.analyze.diagnose.narrow_passage.attached_bodies import (
    attachments,
    half_widths,
    shifts,
)
from kinolab.analyze.diagnose.narrow_passage.free_space import FreeSpace
from kinolab.analyze.diagnose.narrow_passage.path_deformation import PathDeformation
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask

SHRINKAGE_QUANTUM = 2.5e-4  # [m] per side
HORIZON = 0.1  # [m] clearance within which a displaced state need not be rechecked


class RequiredShrinkage:
    """Machines shrunk by any number of quanta, made on demand.

    Wheels that are too thin to lose as much come closer to the body beside which they are.
    """

    def __init__(self, problem: PlanningTask) -> None:
        self._problem, self._checker = problem, problem.checker()
        self._shapes: dict[int, FreeSpace] = {}
        self._attached = attachments(problem)
        self._inflated = FreeSpace(problem, self._checker.inflated(HORIZON, ground=False))

    def shape(self, slim: int) -> FreeSpace:
        """Return the machine shrunk by ``slim`` quanta on every side."""
        if slim not in self._shapes:
            by = slim * SHRINKAGE_QUANTUM
            checker = self._checker.slimmer(by) if slim > 0 else self._checker
            moved = shifts(self._attached, by, len(self._problem.bodies))
            self._shapes[slim] = FreeSpace(self._problem, checker, moved)
        return self._shapes[slim]

    def is_exact(self, slim: int, names: Collection[str]) -> bool:
        """Return whether the bodies of some names are narrower by all of the shrinkage.

        A body that is thinner than that keeps a remainder, unless it comes closer to another one.
        """
        moved = {(entry.body, entry.axis) for entry in self._attached}
        return not any(
            width < slim * SHRINKAGE_QUANTUM and (i, axis) not in moved
            for i, body in enumerate(self._problem.bodies)
            if body.name in names
            for axis, width in enumerate(half_widths(body))
        )

    def clearance(self, path: Array) -> Array:
        """Return a lower bound on the clearance at each state, shape (n,): ``HORIZON`` or 0.

        The ground does not count.
        """
        return np.where([self._inflated.collides(x) for x in path.tolist()], 0.0, HORIZON)

    def fits(self, x: Array, slim: int) -> bool:
        """Return whether the machine shrunk by ``slim`` quanta is free at a state."""
        return self.shape(slim).free(x.tolist())

    def blocked(self, path: Array, slim: int) -> NDArray[np.bool_]:
        """Return at which states of a path (n, nx) the machine is not free, shape (n,)."""
        shape = self.shape(slim)
        return np.array([not shape.free(x) for x in path.tolist()], dtype=bool)

    def least(self, path: Array, most: int) -> int:
        """Return the least shrinkage in quanta that fits everywhere, given that ``most`` does."""
        fat, slim = -1, most
        suspects = path
        while slim - fat > 1:
            middle = (fat + slim) // 2
            blocked = self.blocked(suspects, middle)
            if blocked.any():
                fat, suspects = middle, suspects[blocked]  # the others fit smaller machines as well
            else:
                slim = middle
        return slim


RESOLUTION = 0.004  # [m] of motion between two collision checks


class PathWidening:
    """Widens paths of one machine.

    Args:
        shrinkage: Gives the required shrinkage of the machine.
        cancelled: Returns whether to stop.
    """

    def __init__(
        self,
        deformation: PathDeformation,
        shrinkage: RequiredShrinkage,
        cancelled: Callable[[], bool],
    ) -> None:
        self._bands, self._fit, self._cancelled = deformation, shrinkage, cancelled
        self._draw = np.random.default_rng(0)

    def widened(self, path: Array, slim: int, spacing: float, patience: int) -> tuple[Array, int]:
        """Return a path for a larger machine, and its remaining shrinkage in quanta.

        Args:
            path: States of a path, shape (n, nx).
            slim: Shrinkage, in quanta, with which the machine passes along it.
            spacing: In [m] of motion between the states that are displaced.
            patience: Consecutive deformations that may fail.
        """
        band, slimmest, aim = self._bands.filled(path, spacing), slim, slim // 2
        while aim < slim and not self._cancelled():
            bent = self._bands.filled(self._deformed(band, slim, aim, patience), spacing)
            if not self._fit.blocked(bent, slim).any():  # nor between the displaced states
                band = bent
            if self._fit.blocked(band, aim).any():
                aim = (aim + slim + 1) // 2
            else:
                slim = self._fit.least(band, aim)
                aim = slim // 2
        dense = self._bands.filled(band, RESOLUTION)
        if self._fit.blocked(dense, slimmest).any():  # between the coarser checks
            dense = self._bands.filled(path, RESOLUTION)
        return dense, self._fit.least(dense, slimmest)

    def _deformed(self, band: Array, slim: int, aim: int, patience: int) -> Array:
        """Deform until the machine shrunk by ``aim`` fits, or patience runs out."""
        marks = self._bands.marks(band)
        blocked, clearance = self._fit.blocked(band, aim), self._fit.clearance(band)
        vain = 0
        while blocked.any() and vain < patience and not self._cancelled():
            vain += 1
            k = int(self._draw.choice(np.flatnonzero(blocked)))
            shift = self._bands.deform(band, marks, k, self._draw)
            length = np.abs(shift).sum(axis=1)
            moved, looked = (
                length > 1e-4,  # [m]: smaller displacements are dropped
                length > np.maximum(clearance, 1e-4),
            )
            tried = self._bands.shifted(band, shift)
            now = self._now_blocked(tried[looked], blocked[looked], slim, aim)
            if now is not None:
                vain = 0 if now.sum() < blocked[looked].sum() else vain
                band = np.where(moved[:, None], tried, band)
                blocked[looked] = now
                clearance = np.maximum(clearance - length, 0.0)
        return band

    def _now_blocked(
        self, tried: Array, before: NDArray[np.bool_], slim: int, aim: int
    ) -> NDArray[np.bool_] | None:
        """Return where the larger machine is blocked; None if a deformation makes it worse."""
        allowed, now = int(before.sum()), np.zeros(len(before), dtype=bool)
        for k in np.argsort(~before, kind="stable"):  # likeliest to be blocked first
            if not self._fit.fits(tried[k], aim):
                now[k] = True
                allowed -= 1
                if allowed < 0 or not self._fit.fits(tried[k], slim):
                    return None
        return now
