"""How deviations from a nominal motion grow within steps, beyond what is linear in them.

From the nominal motion to another one leads a straight line of what both start from. Along it the
state at any time is a curve x(s), s in [0, 1]. Its derivative x' obeys the linearised equations,
and half its second derivative the same ones, driven by the equations' second derivatives applied
to x' twice: that is by how much a step's end differs from its linear approximation.

Source: Althoff, Stursberg, Buss, Reachability analysis of nonlinear systems with uncertain
parameters using conservative linearization, CDC 2008 (the remainder of Lagrange's form); Althoff,
Reachability analysis of nonlinear systems using conservative polynomialization and non-convex sets,
HSCC 2013 (quadratic maps of zonotopes).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.model.flow_formulas import FlowFormulas
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.implicit_derivatives import Ball
from kinolab.numerics.interval_analysis.interval_matrices import growth, hull
from kinolab.numerics.interval_analysis.zonotopes import SUMS
from kinolab.numerics.intervals import IntervalArray

# Of sums of E^2 products over pairs of generators, some ten thousand terms: see ``SUMS``
QUADRATIC = 10.0 * SUMS


@dataclass(frozen=True, eq=False)
class Bending:
    """What is proved of the equations of motion over a step of all deviations in a box.

    Attributes:
        h: Length of the step in [s].
        grown: exp(|A| h) - 1, shape (nx, nx).
        driven: What inputs and parameters that are off by 1 add to that, shape (nx, E - nx).
        spread: Of what drives a step: (exp(|A| h) - 1) / (|A| h) - 1, shape (nx, nx).
        centre: Second derivatives of the rates by the entries that vary, in the middle of their
            intervals, shape (nx, E, E).
        radius: How far they may be from that, of the same shape.
    """

    h: float
    grown: Array
    driven: Array
    spread: Array
    centre: Array
    radius: Array

    def moved(self, sizes: Array) -> Array:
        """Return by how much deviations differ from those at the beginning at most, shape (nx,).

        Args:
            sizes: Of all deviations at the beginning, shape (E,).
        """
        nx = len(self.grown)
        return np.asarray((self.grown @ sizes[:nx] + self.driven @ sizes[nx:]) * (1.0 + SUMS))

    def remainder(self, middle: Array, generators: Array, sizes: Array) -> tuple[Array, Array]:
        """Return where a step leads less its linear approximation: a centre and radii, (nx,).

        Args:
            middle: Of the deviations at its beginning, shape (E,).
            generators: Of these, shape (E, count).
            sizes: Bounds of their magnitudes, shape (E,).
        """
        later = np.zeros_like(sizes)
        later[: len(self.grown)] = self.moved(sizes)
        centre, radius = _quadratic(self.centre, middle, generators)
        box = sizes @ (np.abs(self.centre) @ sizes).T  # less where inputs are cut
        boxed = box < np.abs(centre) + radius
        centre, radius = np.where(boxed, 0.0, centre), np.where(boxed, box, radius)
        most = np.abs(self.centre) + self.radius
        pairs = most @ later
        around = sizes @ (self.radius @ sizes).T + 2.0 * (pairs @ sizes) + pairs @ later
        rounding = QUADRATIC * ((most @ sizes) @ sizes)
        radius = 0.5 * (radius + around + rounding) * (1.0 + QUADRATIC)
        centre = 0.5 * centre
        spread = self.spread @ (np.abs(centre) + radius)
        return self.h * centre, self.h * (radius + spread) * (1.0 + SUMS)


def _quadratic(matrices: Array, middle: Array, generators: Array) -> tuple[Array, Array]:
    """Return a centre and radii of d H d over a zonotope, for each of the matrices (n, E, E).

    The square of one unknown in [-1, 1] is in [0, 1].
    """
    by = matrices @ generators
    square = np.swapaxes(by, 1, 2) @ generators
    own = np.einsum("nii->ni", square)
    linear = 2.0 * np.abs(middle @ by).sum(axis=1)
    crossed = np.abs(square).sum(axis=(1, 2)) - 0.5 * np.abs(own).sum(axis=1)
    return (matrices @ middle) @ middle + 0.5 * own.sum(axis=1), linear + crossed


def bendings(
    flow: FlowFormulas,
    boxes: IntervalArray,
    held: Array,
    off: IntervalArray,
    h: Array,
    varied: NDArray[np.intp],
) -> list[Bending | None]:
    """Enclose the equations of motion over m steps; None where there is no bound.

    Args:
        flow: The equations of motion.
        boxes: What contains the nominal motion in equal parts of each step, (nx, parts, m).
        held: Nominal inputs and parameters, shape (nu + parameters, m).
        off: Deviations of states at the beginning, of inputs and of parameters, (entries, m).
        h: Length of each step in [s], shape (m,).
        varied: The entries that vary, all states first.
    """
    nx, m = flow.nx, len(h)
    least, most = boxes.low.min(axis=1), boxes.high.max(axis=1)
    nominal = IntervalArray(np.concatenate([least, held]), np.concatenate([most, held]))
    sizes, moved = off.magnitude[varied], np.zeros((nx, m))
    known: NDArray[np.bool_] = np.zeros(m, dtype=bool)
    with np.errstate(all="ignore"):  # infinite where there is no bound
        # attempts at boxes that contain the deviations of a step; each costs the gradients
        for _ in range(8):
            around = _around(nominal, off, moved)
            slopes, _ = flow.second_order(around, varied, bent=False)
            found = _moved(_growth(slopes, h), sizes)
            known = np.asarray((found < moved).all(axis=0))
            if known.all():
                break
            # 0.1 of itself: room for what it grows by in the next attempt
            wider = np.where(known, moved, 1.1 * found + 1e-12 * sizes[:nx] + intervals.SMALLEST)
            moved = wider
        slopes, bends = flow.second_order(around, varied, bent=True)
        assert bends is not None
        grown, driven, spread = _growth(slopes, h)
    sound = known & np.isfinite(bends.radius).all(axis=(0, 1, 2))
    sound &= np.isfinite(spread).all(axis=(0, 1))
    return [
        Bending(
            float(h[k]), grown[..., k], driven[..., k], spread[..., k],
            bends.centre[..., k], bends.radius[..., k],
        )
        if sound[k] else None
        for k in range(m)
    ]  # fmt: skip


def _around(nominal: IntervalArray, off: IntervalArray, moved: Array) -> IntervalArray:
    """Return boxes of all entries within a step, from the nominal ones to those that are off."""
    more = np.concatenate([moved, np.zeros((len(off.low) - len(moved), moved.shape[1]))])
    away = IntervalArray(off.low - more, off.high + more)
    return intervals.add(nominal, hull(away, intervals.point(np.zeros_like(more))))


def _growth(slopes: Ball, h: Array) -> tuple[Array, Array, Array]:
    """Return ``grown``, ``driven`` and ``spread`` of m steps, the steps last."""
    rates = slopes.size * h
    nx = len(rates)
    unit = np.repeat(np.eye(nx)[:, :, None], len(h), axis=2)
    grown, driven = growth(rates[:, :nx], np.concatenate([rates[:, nx:], unit], axis=1))
    return grown, driven[:, : rates.shape[1] - nx], np.maximum(driven[:, -nx:] - unit, 0.0)


def _moved(found: tuple[Array, Array, Array], sizes: Array) -> Array:
    """Return by how much deviations move within m steps at most, shape (nx, m)."""
    grown, driven, _ = found
    nx = len(grown)
    moved = np.einsum("ijm,jm->im", grown, sizes[:nx]) + np.einsum("ijm,jm->im", driven, sizes[nx:])
    return np.asarray(moved * (1.0 + SUMS))
