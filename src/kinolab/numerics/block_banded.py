"""Block-banded linear systems: each row couples one knot's variables to the next one's states.

With rows sorted by knot the matrix of the normal equations is banded, so that the weighted
least-norm solution costs as much as a few integrator steps.

Source: Golub, Van Loan, Matrix Computations, 4th ed., sections 4.3.5 and 5.6.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array
from kinolab.numerics.jit import allocating_kernel


@dataclass(frozen=True, eq=False)
class BlockBandedSystem:
    """Linear equations sorted by knot, with a few more variables shared by many rows.

    Attributes:
        knot: Knot of each row, shape (m,), nondecreasing.
        rows: Coefficients of a knot's variables and the next one's states, shape (m, 2 nx + nu).
        shared: Coefficients of the shared variables, shape (m, s).
        right: Right-hand sides, shape (m,).
    """

    knot: NDArray[np.int64]
    rows: Array
    shared: Array
    right: Array

    def joined(
        self, other: BlockBandedSystem, which: NDArray[np.bool_]
    ) -> tuple[BlockBandedSystem, NDArray[np.int64]]:
        """Return these rows merged with selected rows of ``other``, and the latter's indices."""
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

    def residual(self, z: Array, h: Array) -> Array:
        """Return right-hand sides minus left-hand sides, shape (m,)."""
        return np.asarray(self.right - product(self.knot, self.rows, z) - self.shared @ h)

    def closed(self, z: Array, h: Array, w: Array, w_h: Array) -> tuple[Array, Array, Array] | None:
        """Return the solution nearest to the current variables in the weighted norm.

        Args:
            z: Current variables of each knot, shape (N+1, nx + nu).
            h: Current shared variables, shape (s,).
            w: Inverse weight of each variable, 0 if it is fixed, same shape.
            w_h: The same of the shared ones, shape (s,).

        Returns:
            New z and h, and the multipliers (m,); None if no solution is found.
        """
        try:
            factor = scipy.linalg.cholesky_banded(self._normal(w), lower=True, check_finite=False)
        except np.linalg.LinAlgError:
            return None
        pull = scipy.linalg.cho_solve_banded((factor, True), self.shared, check_finite=False)
        yields = np.eye(len(h)) + w_h[:, None] * (self.shared.T @ pull)
        missing, total = self.residual(z, h), np.zeros(len(self.right))
        # 1e-6: allowed residual, relative to the initial one
        enough = 1e-6 * float(np.abs(missing).max(initial=0.0))
        for _ in range(3):
            by = scipy.linalg.cho_solve_banded((factor, True), missing, check_finite=False)
            dh = np.linalg.solve(yields, w_h * (self.shared.T @ by))
            by -= pull @ dh
            total, h = total + by, h + dh
            z = z + w * transposed(self.knot, self.rows, by, *z.shape)
            missing = self.residual(z, h)
            if not np.abs(missing).max(initial=0.0) > enough:
                return z, h, total
        return None

    def _normal(self, w: Array) -> Array:
        """Return the band of rows * w * rows^T, shape (band, m)."""
        behind = np.searchsorted(self.knot, self.knot + 2)  # first row without common variables
        band = np.zeros((int((behind - np.arange(len(behind))).max(initial=1)), len(self.knot)))
        normal(self.knot, self.rows, w, band)
        band[0] *= 1.0 + 1e-13  # relative increase of the diagonal, for dependent rows
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
        knot: Knot of each row, shape (m,).
        rows: Coefficients, shape (m, own + nx).
        by: Multipliers, shape (m,).
        knots, own: Number of knots, and of variables of each.
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
