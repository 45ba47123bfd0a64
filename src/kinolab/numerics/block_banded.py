"""Linear equations along a chain: each row has the variables of one knot and the next one's states.

With rows in the order of their knots the matrix of the normal equations is a band, so that the
least weighted solution costs as much as a few steps of an integrator.

Source: Golub, Van Loan, Matrix Computations, 4th ed., sections 4.3.5 and 5.6.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import allocating_kernel

DIAGONAL_REGULARISATION = 1e-13  # share that is added to the diagonal, for rows that say the same
REFINEMENT_TOLERANCE = 1e-6  # of the right side that a solution may miss
REFINEMENTS = 3


@dataclass(frozen=True, eq=False)
class BlockBandedSystem:
    """Rows of equations in the order of their knots, and one more variable that all may share.

    Attributes:
        knot: Of each row, shape (m,), not falling.
        rows: Coefficients of a knot's variables (nx + nu) and of the next one's states (nx).
        shared: Coefficients of the shared variable, shape (m,).
        right: Right sides, shape (m,).
    """

    knot: NDArray[np.int64]
    rows: Array
    shared: Array
    right: Array

    def joined(
        self, other: BlockBandedSystem, which: NDArray[np.bool_]
    ) -> tuple[BlockBandedSystem, NDArray[np.int64]]:
        """Return these rows and some of others in order, and where those others are."""
        knot = np.concatenate([self.knot, other.knot[which]])
        order = np.argsort(knot, kind="stable")
        parts = (
            np.concatenate([mine, theirs[which]])[order]
            for mine, theirs in (
                (self.rows, other.rows),
                (self.shared, other.shared),
                (self.right, other.right),
            )
        )
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        return BlockBandedSystem(knot[order], *parts), place[len(self.knot) :]

    def residual(self, z: Array, h: float) -> Array:
        """Return what the right sides are more than the left ones, shape (m,)."""
        return np.asarray(self.right - product(self.knot, self.rows, z) - self.shared * h)

    def closed(self, z: Array, h: float, w: Array, w_h: float) -> tuple[Array, float, Array] | None:
        """Return the change of least weighted square that leaves nothing missing.

        Args:
            z: Variables of each knot so far, shape (N+1, nx + nu).
            h: The shared variable so far.
            w: Inverse weight of every variable, 0 for one that is held, same shape.
            w_h: Of the shared one.

        Returns:
            New variables, and the multipliers (m,); None where there is no such change.
        """
        try:
            factor = cholesky_banded(self._normal(w), lower=True, check_finite=False)
        except LinAlgError:
            return None
        pull = cho_solve_banded((factor, True), self.shared, check_finite=False)
        yields = 1.0 + w_h * float(self.shared @ pull)
        missing, total = self.residual(z, h), np.zeros(len(self.right))
        enough = REFINEMENT_TOLERANCE * float(np.abs(missing).max(initial=0.0))
        for _ in range(REFINEMENTS):
            by = cho_solve_banded((factor, True), missing, check_finite=False)
            dh = w_h * float(self.shared @ by) / yields
            by -= dh * pull
            total, h = total + by, h + dh
            z = z + w * transposed(self.knot, self.rows, by, *z.shape)
            missing = self.residual(z, h)
            if not np.abs(missing).max(initial=0.0) > enough:
                return z, h, total
        return None

    def _normal(self, w: Array) -> Array:
        """Return the band of rows * w * rows^T, shape (band, m)."""
        behind = np.searchsorted(self.knot, self.knot + 2)  # the first row that has nothing common
        band = np.zeros((int((behind - np.arange(len(behind))).max(initial=1)), len(self.knot)))
        normal(self.knot, self.rows, w, band)
        band[0] *= 1.0 + DIAGONAL_REGULARISATION
        return band


@allocating_kernel
def normal(knot, rows, w, band):  # type: ignore[no-untyped-def]
    """Fill the lower band of rows * w * rows^T."""
    count, own = rows.shape[0], w.shape[1]
    wide = rows.shape[1]
    weighted = np.empty(wide)
    for i in range(count):
        k = knot[i]
        for c in range(own):
            weighted[c] = w[k, c] * rows[i, c]
        for c in range(own, wide):
            weighted[c] = w[k + 1, c - own] * rows[i, c] if k + 1 < w.shape[0] else 0.0
        j = i
        while j < count and knot[j] <= k + 1:
            total = 0.0
            if knot[j] == k:
                for c in range(wide):
                    total += weighted[c] * rows[j, c]
            else:
                for c in range(own, wide):
                    total += weighted[c] * rows[j, c - own]
            band[j - i, i] = total
            j += 1


@allocating_kernel
def product(knot, rows, z):  # type: ignore[no-untyped-def]
    """Return rows * z, shape (m,)."""
    out, own = np.zeros(rows.shape[0]), z.shape[1]
    for i in range(rows.shape[0]):
        k = knot[i]
        for c in range(own):
            out[i] += rows[i, c] * z[k, c]
        if k + 1 < z.shape[0]:
            for c in range(own, rows.shape[1]):
                out[i] += rows[i, c] * z[k + 1, c - own]
    return out


@allocating_kernel
def transposed(knot, rows, by, knots, own):  # type: ignore[no-untyped-def]
    """Return rows^T * by, shape (knots, own).

    Args:
        knot: Of each row, shape (m,).
        rows: Coefficients, shape (m, own + nx).
        by: Multipliers, shape (m,).
        knots, own: How many knots there are, and variables of each.
    """
    out = np.zeros((knots, own))
    for i in range(rows.shape[0]):
        k = knot[i]
        for c in range(own):
            out[k, c] += rows[i, c] * by[i]
        if k + 1 < knots:
            for c in range(own, rows.shape[1]):
                out[k + 1, c - own] += rows[i, c] * by[i]
    return out
