"""Squeeze a way: bend it at random, smoothly and on all scales, so that fatter machines fit.

Bends are kept where they leave no more places at which the fatter machine is blocked, and the
slimmer one nowhere. How fat that one is, is raised as far as it goes.

Source of the idea: Saha, Latombe, Chang, Prinz, Finding narrow passages with probabilistic
roadmaps: the small-step retraction method, Autonomous Robots 19(3), 2005.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from kinolab.analyze.diagnose.narrow_passage.path_deformation import PathDeformation
from kinolab.analyze.diagnose.narrow_passage.required_shrinkage import RequiredShrinkage
from kinolab.numerics.arrays import Array

RESOLUTION = 0.004  # [m] of motion between two looks at a way
MIN_DEFORMATION = 1e-4  # [m] that need not be bent


class PathWidening:
    """Bends ways of one machine.

    Args:
        deformation: Bends them.
        shrinkage: Tells how slim the machine must be.
        cancelled: Says whether to stop.
    """

    def __init__(
        self,
        deformation: PathDeformation,
        shrinkage: RequiredShrinkage,
        cancelled: Callable[[], bool],
    ) -> None:
        self._bands, self._fit, self._late = deformation, shrinkage, cancelled
        self._draw = np.random.default_rng(0)

    def widened(self, path: Array, slim: int, spacing: float, patience: int) -> tuple[Array, int]:
        """Return a way for a fatter machine, and how slim that still is, in quanta.

        Args:
            path: States of a way, shape (n, nx).
            slim: How slim the machine is that passes along it.
            spacing: In [m] of motion between the states that are bent.
            patience: Bends in a row that may be in vain.
        """
        band, slimmest, aim = self._bands.filled(path, spacing), slim, slim // 2
        while aim < slim and not self._late():
            bent = self._bands.filled(self._deformed(band, slim, aim, patience), spacing)
            if not self._fit.blocked(bent, slim).any():  # nor between the states that were bent
                band = bent
            if self._fit.blocked(band, aim).any():
                aim = (aim + slim + 1) // 2
            else:
                slim = self._fit.least(band, aim)
                aim = slim // 2
        dense = self._bands.filled(band, RESOLUTION)
        if self._fit.blocked(dense, slimmest).any():  # where it was not looked at so closely
            dense = self._bands.filled(path, RESOLUTION)
        return dense, self._fit.least(dense, slimmest)

    def _deformed(self, band: Array, slim: int, aim: int, patience: int) -> Array:
        """Bend until a machine slimmer by ``aim`` fits, as far as the patience goes."""
        marks = self._bands.marks(band)
        blocked, clearance = self._fit.blocked(band, aim), self._fit.clearance(band)
        vain = 0
        while blocked.any() and vain < patience and not self._late():
            vain += 1
            k = int(self._draw.choice(np.flatnonzero(blocked)))
            shift = self._bands.deform(band, marks, k, self._draw)
            length = np.abs(shift).sum(axis=1)
            moved, looked = (
                length > MIN_DEFORMATION,
                length > np.maximum(clearance, MIN_DEFORMATION),
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
        """Say where the fatter machine is blocked; None where a bend makes matters worse."""
        allowed, now = int(before.sum()), np.zeros(len(before), dtype=bool)
        for k in np.argsort(~before, kind="stable"):  # what was blocked is most likely to be
            if not self._fit.fits(tried[k], aim):
                now[k] = True
                allowed -= 1
                if allowed < 0 or not self._fit.fits(tried[k], slim):
                    return None
        return now
