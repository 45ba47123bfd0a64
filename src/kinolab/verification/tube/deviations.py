"""How deviations from a nominal motion grow within steps, beyond what is linear in them.

From the nominal motion to another one leads a straight line of what both start from. Along it the
state at any time is a curve, whose Taylor coefficients of order 1 and 2 are enclosed by Picard's
iteration over the whole step: the first contains all deviations, the second is by how much the end
differs from its linear approximation.

Source: Althoff, Stursberg, Buss, Reachability analysis of nonlinear systems with uncertain
parameters using conservative linearization, CDC 2008 (the remainder of Lagrange's form); Moore,
Kearfott, Cloud, Introduction to Interval Analysis, SIAM 2009, chapter 10.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.flow_formulas import FlowFormulas
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_matrices import hull, within
from kinolab.numerics.intervals import IntervalArray

ATTEMPTS = 12  # at boxes that contain the coefficients; each costs an evaluation of the rates


@dataclass(frozen=True, eq=False)
class DeviationBounds:
    """What is proved of deviations in m steps; infinite where nothing is.

    Attributes:
        remainder: Where a step leads less its linear approximation, shape (nx, m).
        moved: By how much the deviation at any time of a step differs from that at its beginning at
            most, shape (nx, m).
        known: Whether anything is, shape (m,).
    """

    remainder: IntervalArray
    moved: Array
    known: Array


def deviation_bounds(
    flow: FlowFormulas, boxes: IntervalArray, held: Array, off: IntervalArray, h: Array
) -> DeviationBounds:
    """Enclose deviations in m steps.

    Args:
        flow: The equations of motion.
        boxes: What contains the nominal motion in equal parts of each step, (nx, parts, m).
        held: Nominal inputs and parameters, shape (nu + parameters, m).
        off: Deviations of states at the beginning, of inputs and of parameters, (entries, m).
        h: Length of each step in [s], shape (m,).
    """
    nx, parts, m = boxes.low.shape
    first, second = _first(off, nx), intervals.point(np.zeros((nx, m)))
    moved, known = np.zeros((nx, m)), np.ones(m, dtype=bool)
    with np.errstate(all="ignore"):  # infinite where there is no bound
        for k in range(parts):
            nominal = IntervalArray(
                np.concatenate([boxes.low[:, k], held]), np.concatenate([boxes.high[:, k], held])
            )
            rates, sure = _rates(flow, nominal, off, (first, second), h / parts)
            span = intervals.point(h / parts)
            first, second = (
                intervals.add(start, intervals.mul(span, rate))
                for start, rate in zip((first, second), rates, strict=True)
            )
            moved = moved + intervals.mul(span, rates[0]).magnitude * (1.0 + intervals.ROUNDING)
            known &= sure
    bad = np.where(known, 0.0, np.inf)
    return DeviationBounds(IntervalArray(second.low - bad, second.high + bad), moved + bad, known)


def _rates(
    flow: FlowFormulas,
    nominal: IntervalArray,
    off: IntervalArray,
    starts: tuple[IntervalArray, IntervalArray],
    h: Array,
) -> tuple[tuple[IntervalArray, IntervalArray], Array]:
    """Return the rates of the coefficients within a part of a step, and whether they are proved.

    Args:
        flow: The equations of motion.
        nominal: What contains the nominal entries, shape (entries, m).
        off: Deviations of all entries, of which those of inputs and parameters stay.
        starts: The coefficients of order 1 and 2 at the part's beginning, shape (nx, m).
        h: Its length in [s], shape (m,).
    """
    nx, span, found = flow.nx, IntervalArray(np.zeros_like(h), h), starts
    none = np.zeros_like(off.low[nx:])
    for _ in range(ATTEMPTS):
        first = _with(found[0], off.low[nx:], off.high[nx:])
        second = _with(found[1], none, none)
        around = intervals.add(nominal, hull(first, intervals.point(np.zeros_like(first.low))))
        _, *rates = flow.along([around, first, second])
        moved = [
            intervals.add(start, intervals.mul(span, rate))
            for start, rate in zip(starts, rates, strict=True)
        ]
        held = [within(a, b) for a, b in zip(moved, found, strict=True)]
        sure = np.logical_and(*held).all(axis=0)
        if sure.all():
            break
        found = tuple(
            _wider(a, b, inside) for a, b, inside in zip(found, moved, held, strict=True)
        )  # type: ignore[assignment]
    return (rates[0], rates[1]), sure


def _wider(found: IntervalArray, moved: IntervalArray, held: Array) -> IntervalArray:
    """Return boxes with room for what they grow by in the next attempt, where they did not hold."""
    slack = 0.1 * moved.width + 1e-12 * moved.magnitude + intervals.SMALLEST  # 0.1 of the width
    low = np.where(held, found.low, moved.low - slack)
    return IntervalArray(low, np.where(held, found.high, moved.high + slack))


def _with(states: IntervalArray, low: Array, high: Array) -> IntervalArray:
    """Return boxes of states with those of inputs and parameters below them."""
    return IntervalArray(np.concatenate([states.low, low]), np.concatenate([states.high, high]))


def _first(a: IntervalArray, count: int) -> IntervalArray:
    return IntervalArray(a.low[:count], a.high[:count])
