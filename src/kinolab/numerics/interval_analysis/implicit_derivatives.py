"""Derivatives of the solution of linear equations M a = F over boxes, without solving in symbols.

All is multiplied by an inverse of M in the middle of a box first, so that M is nearly the identity;
what cancels between rows then cancels before intervals are added up.

Source: Neumaier, Interval Methods for Systems of Equations, 1990, section 4.1 (preconditioning);
Griewank, Walther, Evaluating Derivatives, 2nd ed., 2008, section 15.1 (implicit functions).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.numerics.arrays import Array

# of the sizes of the terms of sums of products: they have fewer than 1000 terms, at 2.2e-16 each
ROUNDING = 2.5e-13


@dataclass(frozen=True, eq=False)
class Ball:
    """Intervals by their centres and radii, of the same shape; m of them side by side, last."""

    centre: Array
    radius: Array

    @classmethod
    def of(cls, low: Array, high: Array) -> Ball:
        """Return balls around intervals."""
        centre = 0.5 * (low + high)
        radius = np.maximum(high - centre, centre - low)
        return cls(centre, radius * (1.0 + ROUNDING) + ROUNDING * np.abs(centre))

    @property
    def size(self) -> Array:
        """The largest magnitude in each."""
        return np.abs(self.centre) + self.radius

    def plus(self, *others: Ball) -> Ball:
        """Return sums."""
        centre, radius, sizes = self.centre, self.radius, np.abs(self.centre)
        for other in others:
            centre, radius = centre + other.centre, radius + other.radius
            sizes = sizes + np.abs(other.centre)
        return Ball(centre, radius * (1.0 + ROUNDING) + ROUNDING * sizes)

    def times(self, subscripts: str, other: Ball) -> Ball:
        """Return sums of products, of which subscripts say as those of ``np.einsum`` do."""
        size, own = np.abs(other.centre), np.abs(self.centre)
        radius = np.einsum(subscripts, own, other.radius + ROUNDING * size)
        radius = radius + np.einsum(subscripts, self.radius, size + other.radius)
        return Ball(np.einsum(subscripts, self.centre, other.centre), radius * (1.0 + ROUNDING))

    def met(self, other: Ball) -> Ball:
        """Return the narrower of two balls around the same, each."""
        better = other.radius < self.radius
        return Ball(
            np.where(better, other.centre, self.centre), np.where(better, other.radius, self.radius)
        )

    def negative(self) -> Ball:
        """Return the same of the other sign."""
        return Ball(-self.centre, self.radius)


@dataclass(frozen=True, eq=False)
class Balance:
    """Both sides of M a = F, with derivatives by E entries, over m boxes.

    Attributes:
        matrix: M, shape (n, n, m).
        matrix_slopes: Shape (n, n, E, m).
        matrix_bends: Shape (n, n, E, E, m); None where they are not wanted.
        load: F, shape (n, m).
        load_slopes: Shape (n, E, m).
        load_bends: Shape (n, E, E, m); None where they are not wanted.
    """

    matrix: Ball
    matrix_slopes: Ball
    matrix_bends: Ball | None
    load: Ball
    load_slopes: Ball
    load_bends: Ball | None


def solved(over: Balance, middle: Balance, off: Array) -> tuple[Ball, Ball | None]:
    """Enclose gradients (n, E, m) and second derivatives (n, E, E, m) of a in M a = F.

    Args:
        over: Both sides over boxes.
        middle: The same in a point of each, without second derivatives.
        off: How far entries in the boxes are from these points at most, shape (E, m).

    Returns:
        Infinite radii where M may be singular; second derivatives only where those of both sides
        are given.
    """
    inverse, at, sound = _in_the_middle(middle)
    R = Ball(inverse, np.zeros_like(inverse))
    M1, F1 = (
        R.times("ikm,kjem->ijem", over.matrix_slopes),
        R.times("ikm,kem->iem", over.load_slopes),
    )
    M0, F0 = R.times("ikm,kjm->ijm", middle.matrix), R.times("ikm,km->im", middle.load)
    unit = np.eye(len(inverse))[:, :, None]
    inexact = M0.plus(Ball(-unit, 0.0 * unit)).size
    away = np.einsum("ijem,em->ijm", M1.size, off) + inexact
    bound = _series(away * (1.0 + ROUNDING))
    sound = np.asarray(sound & np.isfinite(bound).all(axis=(0, 1)))
    bound, wide = np.where(sound, bound, 0.0), np.where(sound, 0.0, np.inf)
    beyond = np.einsum("ijm,jkm->ikm", bound, away) * (1.0 + ROUNDING)
    rest = np.einsum("ijm,jkm->ikm", bound, inexact) * (1.0 + ROUNDING)  # in the middle

    def apart(one: Ball, axes: str, beyond: Array = beyond) -> Ball:
        """Return the inverse of R M applied to something whose first axis is that of a."""
        rest = np.einsum(f"ijm,j{axes}m->i{axes}m", beyond, one.size)
        return Ball(one.centre, (one.radius + rest) * (1.0 + ROUNDING) + wide)

    exact = Ball(at, np.zeros_like(at))
    first = F1.plus(M1.times("ijem,jm->iem", exact).negative())
    left = F0.plus(M0.times("ijm,jm->im", exact).negative())
    near = Ball(at, np.einsum("ijm,jm->im", bound, left.size) * (1.0 + ROUNDING))
    residual = np.einsum("iem,em->im", first.size, off) * (1.0 + ROUNDING)
    a = Ball(at, near.radius + np.einsum("ijm,jm->im", bound, residual) * (1.0 + ROUNDING) + wide)
    slopes = apart(F1.plus(M1.times("ijem,jm->iem", a).negative()), "e")
    if over.matrix_bends is None or over.load_bends is None:
        return slopes, None
    own = R.times("ikm,kjem->ijem", middle.matrix_slopes).times("ijem,jm->iem", near)
    there = apart(R.times("ikm,kem->iem", middle.load_slopes).plus(own.negative()), "e", rest)
    M2 = R.times("ikm,kjefm->ijefm", over.matrix_bends)
    F2 = R.times("ikm,kefm->iefm", over.load_bends)
    # rounds in which second derivatives make gradients narrower, and these the former
    for _ in range(3):
        mixed = M1.times("ijem,jfm->iefm", slopes).negative()
        swapped = Ball(np.swapaxes(mixed.centre, 1, 2), np.swapaxes(mixed.radius, 1, 2))
        turned = M2.times("ijefm,jm->iefm", a).negative()
        bends = apart(F2.plus(turned, mixed, swapped), "ef")
        change = np.einsum("iefm,fm->iem", bends.size, off) * (1.0 + ROUNDING)
        slopes = slopes.met(Ball(there.centre, there.radius + change))
        nearer = np.einsum("iem,em->im", slopes.size, off) * (1.0 + ROUNDING)
        a = a.met(Ball(at, nearer + near.radius + wide))
    return slopes, bends


def _in_the_middle(middle: Balance) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return inverses (n, n, m) and solutions (n, m) in the middle, and where there are any."""
    matrices = np.moveaxis(middle.matrix.centre, -1, 0)
    finite = np.isfinite(matrices).all(axis=(1, 2))
    sound = np.asarray(finite & np.isfinite(middle.load.centre).all(axis=0))
    unit = np.eye(matrices.shape[1])
    usable = np.where(sound[:, None, None], matrices, unit)
    sound = sound & (np.linalg.cond(usable) < 1e12)  # an inverse of more has lost its digits
    usable = np.where(np.reshape(sound, (-1, 1, 1)), usable, unit)
    inverse = np.moveaxis(np.linalg.inv(usable), 0, -1)
    load = np.where(sound, middle.load.centre, 0.0)
    return inverse, np.einsum("ijm,jm->im", inverse, load), sound


def _series(away: Array) -> Array:
    """Bound 1 + K + K^2 + ... for K >= 0, shape (n, n, m); infinite where that has no limit.

    N >= 1 + K N >= 1 is a bound: put into itself, it contains every partial sum.
    """
    K = np.moveaxis(away, -1, 0)
    unit = np.eye(K.shape[1])
    finite = np.reshape(np.isfinite(K).all(axis=(1, 2)), (-1, 1, 1))
    usable = np.where(finite, K, 2.0 * unit)
    small = np.asarray(np.abs(np.linalg.eigvals(usable)).max(axis=1) < 0.95)
    usable = np.where(np.reshape(small, (-1, 1, 1)), usable, 0.0)
    found = np.maximum(np.linalg.inv(unit - usable), 0.0) * (1.0 + 1e-9) + 1e-12
    fixed = (found >= (unit + usable @ found) * (1.0 + ROUNDING)).all(axis=(1, 2))
    enough = np.asarray(fixed & small)
    return np.moveaxis(np.where(np.reshape(enough, (-1, 1, 1)), found, np.inf), 0, -1)
