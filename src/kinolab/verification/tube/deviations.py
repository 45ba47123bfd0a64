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
from typing import Any

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.flow_formulas import FlowFormulas
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.interval_matrices import hull, within
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
    count = len(h)
    rates = tuple(IntervalArray(*np.full((2, flow.nx, count), np.nan)) for _ in starts)
    found, sure, rows = starts, np.zeros(count, dtype=bool), np.arange(count)
    for _ in range(ATTEMPTS):
        some = [_columns(one, rows) for one in (nominal, off, *starts, *found)]
        made = _along(flow, some[0], some[1], some[4], some[5])
        span = IntervalArray(np.zeros(len(rows)), h[rows])
        moved = [
            intervals.add(start, intervals.mul(span, rate))
            for start, rate in zip(some[2:4], made, strict=True)
        ]
        held = [within(a, b) for a, b in zip(moved, some[4:], strict=True)]
        sure[rows] = np.logical_and(*held).all(axis=0)
        for whole, part in zip(rates, made, strict=True):
            whole.low[:, rows], whole.high[:, rows] = part.low, part.high
        sizes = [np.isfinite(one.low) & np.isfinite(one.high) for one in moved]
        going = np.logical_and(*sizes).all(axis=0) & ~sure[rows]
        if not going.any():
            break
        wider = [_wider(a, b, inside) for a, b, inside in zip(some[4:], moved, held, strict=True)]
        found = tuple(
            _replaced(one, _columns(wide, going), rows[going])
            for one, wide in zip(found, wider, strict=True)
        )  # type: ignore[assignment]
        rows = rows[going]
    return (rates[0], rates[1]), sure


def _along(
    flow: FlowFormulas,
    nominal: IntervalArray,
    off: IntervalArray,
    first: IntervalArray,
    second: IntervalArray,
) -> list[IntervalArray]:
    """Return the rates of coefficients of order 1 and 2 in boxes of them, each (nx, m)."""
    held = IntervalArray(off.low[flow.nx :], off.high[flow.nx :])
    one, two = _with(first, held), _with(second, intervals.point(np.zeros_like(held.low)))
    around = intervals.add(nominal, hull(one, intervals.point(np.zeros_like(one.low))))
    return flow.along([around, one, two])[1:]


def _columns(a: IntervalArray, rows: NDArray[Any]) -> IntervalArray:
    return IntervalArray(a.low[:, rows], a.high[:, rows])


def _replaced(a: IntervalArray, part: IntervalArray, rows: NDArray[np.intp]) -> IntervalArray:
    """Return intervals of which some columns are others."""
    low, high = a.low.copy(), a.high.copy()
    low[:, rows], high[:, rows] = part.low, part.high
    return IntervalArray(low, high)


def _wider(found: IntervalArray, moved: IntervalArray, held: Array) -> IntervalArray:
    """Return boxes with room for what they grow by in the next attempt, where they did not hold."""
    slack = 0.1 * moved.width + 1e-12 * moved.magnitude + intervals.SMALLEST  # 0.1 of the width
    low = np.where(held, found.low, moved.low - slack)
    return IntervalArray(low, np.where(held, found.high, moved.high + slack))


def _with(states: IntervalArray, held: IntervalArray) -> IntervalArray:
    """Return boxes of states with those of inputs and parameters below them."""
    pairs = (states.low, held.low), (states.high, held.high)
    return IntervalArray(*(np.concatenate(pair) for pair in pairs))


def _first(a: IntervalArray, count: int) -> IntervalArray:
    return IntervalArray(a.low[:count], a.high[:count])
