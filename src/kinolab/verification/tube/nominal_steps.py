"""The nominal motion, proved step by step: where each step leads, and the derivatives of that.

Values and derivatives are Taylor polynomials in time with a remainder over a box that contains the
whole of a step, which Picard's iteration finds.

Source: Nedialkov, Jackson, Corliss, Validated solutions of initial value problems for ordinary
differential equations, Applied Mathematics and Computation 105(1), 1999, sections 5 and 6.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.model.flow_formulas import FlowFormulas
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.interval_analysis.interval_matrices import growth, meet, product, within
from kinolab.numerics.intervals import IntervalArray

ORDER = 8  # of the Taylor polynomials: their remainder is of the 9th order in the length of a part
# Of a state's scale: how far apart the bounds of a nominal step are at most; a step is divided into
# up to so many parts until they are. The verifier allows 1e-6 between a motion and its rows.
NOMINAL_WIDTH, MOST_PARTS = 1e-7, 16
BOXES = 8  # that a step is in, of its parts


@dataclass(frozen=True, eq=False)
class NominalSteps:
    """What is proved of m nominal steps; infinite where nothing is.

    Attributes:
        ends: Where they lead, shape (nx, m).
        slopes: Derivatives of that by states, inputs and parameters, shape (nx, entries, m).
        boxes: What contains each part of a step, of as many parts, shape (nx, BOXES, m).
    """

    ends: IntervalArray
    slopes: IntervalArray
    boxes: IntervalArray


def nominal_steps(flow: FlowFormulas, entries: Array, h: Array, scales: Array) -> NominalSteps:
    """Enclose steps in which inputs are held.

    Args:
        flow: The equations of motion.
        entries: States, inputs and parameters at the beginning, shape (entries, m).
        h: Length of each step in [s], shape (m,).
        scales: Of states, shape (nx,).
    """
    rows, parts, kept = np.arange(len(h)), 1, []
    while len(rows):
        found = _steps(flow, entries[:, rows], h[rows], parts)
        narrow = np.all(found.ends.width <= NOMINAL_WIDTH * scales[:, None], axis=0)
        good = np.asarray(narrow | (2 * parts > MOST_PARTS))
        kept.append((rows[good], _part(found, good)))
        rows, parts = rows[~good], 2 * parts
    return _joined(kept)


def _part(some: NominalSteps, rows: NDArray[np.bool_]) -> NominalSteps:
    each = (some.ends, some.slopes, some.boxes)
    return NominalSteps(*(IntervalArray(a.low[..., rows], a.high[..., rows]) for a in each))


def _joined(parts: list[tuple[NDArray[np.intp], NominalSteps]]) -> NominalSteps:
    order = np.argsort(np.concatenate([rows for rows, _ in parts]))

    def of(name: str) -> IntervalArray:
        each = [getattr(one, name) for _, one in parts]
        low, high = (np.concatenate([getattr(a, end) for a in each], -1) for end in ("low", "high"))
        return IntervalArray(low[..., order], high[..., order])

    return NominalSteps(of("ends"), of("slopes"), of("boxes"))


def _steps(flow: FlowFormulas, entries: Array, h: Array, parts: int) -> NominalSteps:
    """Enclose steps, each divided into so many parts."""
    nx, at, slopes, boxes = flow.nx, intervals.point(entries), _identity(entries), []
    with np.errstate(all="ignore"):  # infinite where there is no bound
        for _ in range(parts):
            at, after, box = _advanced(flow, at, h / parts)
            slopes = _stacked(product(after, slopes), slopes, nx)
            boxes.append(box)
    return NominalSteps(_first(at, nx), _first(slopes, nx), _grouped(boxes))


def _grouped(boxes: list[IntervalArray]) -> IntervalArray:
    """Return boxes of equal parts of a step, BOXES of them, from those of more or fewer parts."""
    low, high = np.array([b.low for b in boxes]), np.array([b.high for b in boxes])
    if len(boxes) < BOXES:
        low, high = (np.repeat(a, BOXES // len(boxes), axis=0) for a in (low, high))
    shape = (BOXES, len(low) // BOXES, *low.shape[1:])
    low, high = low.reshape(shape).min(axis=1), high.reshape(shape).max(axis=1)
    return IntervalArray(np.swapaxes(low, 0, 1), np.swapaxes(high, 0, 1))


def _advanced(
    flow: FlowFormulas, at: IntervalArray, h: Array
) -> tuple[IntervalArray, IntervalArray, IntervalArray]:
    """Return the entries after a part of a step, the derivatives of states, and what it is in.

    Args:
        flow: The equations of motion.
        at: Entries at its beginning, shape (entries, m).
        h: Its length in [s], shape (m,).
    """
    nx, unit = flow.nx, _identity(at.low)
    during = _containing(flow, at, h)
    rates = _slopes(flow.coefficients(during, 1, unit)[1]).magnitude * h
    change = np.concatenate(growth(rates[:, :nx], rates[:, nx:]), axis=1)
    around = intervals.add(unit, _padded(change, unit))
    inner = flow.coefficients(at, ORDER - 1, unit)
    rest = flow.coefficients(during, ORDER, around)
    after = _series(inner, rest, _orders(inner, rest), h)
    slopes = meet(_slopes(after), _first(around, nx))
    value = meet(IntervalArray(after.low[:, 0], after.high[:, 0]), _first(during, nx))
    pairs = (value.low, at.low), (value.high, at.high)
    there = IntervalArray(*(np.concatenate([new, old[nx:]]) for new, old in pairs))
    return there, slopes, _first(during, nx)


def _containing(flow: FlowFormulas, start: IntervalArray, h: Array) -> IntervalArray:
    """Return boxes that contain all motions from others for a time h, by Picard's iteration."""
    nx, found, span = flow.nx, start, IntervalArray(np.zeros_like(h), h)
    # attempts to find a box that contains a part; each costs an evaluation of the rates
    for _ in range(12):
        rate = flow.coefficients(found, 1)[1]
        rate = IntervalArray(rate.low[:, 0], rate.high[:, 0])
        moved = intervals.add(_first(start, nx), intervals.mul(span, rate))
        held = within(moved, _first(found, nx))
        if held.all():
            return found
        # 0.1 of its width: room for what it grows by in the next attempt
        slack = 0.1 * moved.width + 1e-12 * moved.magnitude + intervals.SMALLEST
        low, high = found.low.copy(), found.high.copy()
        low[:nx] = np.where(held, low[:nx], moved.low - slack)
        high[:nx] = np.where(held, high[:nx], moved.high + slack)
        last, found = held.all(axis=0), IntervalArray(low, high)
    low, high = found.low.copy(), found.high.copy()
    low[:nx, ~last], high[:nx, ~last] = -np.inf, np.inf
    return IntervalArray(low, high)


def _identity(like: Array) -> IntervalArray:
    """Return unit matrices (entries, entries, m) for boxes (entries, m)."""
    n, m = like.shape
    return intervals.point(np.repeat(np.eye(n)[:, :, None], m, axis=2))


def _first(a: IntervalArray, count: int) -> IntervalArray:
    return IntervalArray(a.low[:count], a.high[:count])


def _slopes(a: IntervalArray) -> IntervalArray:
    """Return the derivatives in coefficients (nx, 1 + entries, m)."""
    return IntervalArray(a.low[:, 1:], a.high[:, 1:])


def _padded(change: Array, like: IntervalArray) -> IntervalArray:
    """Return changes of states' derivatives, and none of inputs' and parameters'."""
    full = np.zeros_like(like.low)
    full[: len(change)] = change
    return IntervalArray(-full, full)


def _stacked(after: IntervalArray, whole: IntervalArray, nx: int) -> IntervalArray:
    """Return derivatives of all entries: of inputs and parameters, they stay the same."""
    pairs = (after.low, whole.low), (after.high, whole.high)
    return IntervalArray(*(np.concatenate([new, old[nx:]]) for new, old in pairs))


def _orders(inner: list[IntervalArray], rest: list[IntervalArray]) -> NDArray[np.intp]:
    """Return the order up to which each of m steps has Taylor coefficients, at least 1."""
    order = np.ones(inner[0].low.shape[-1], dtype=np.intp)
    for n in range(2, len(rest)):
        sound = [np.isfinite(a.low) & np.isfinite(a.high) for a in (inner[n - 1], rest[n])]
        known = np.logical_and.reduce([np.all(one, axis=(0, 1)) for one in sound])
        order = np.where(known & (order == n - 1), n, order)
    return order


def _series(
    inner: list[IntervalArray], rest: list[IntervalArray], order: NDArray[np.intp], h: Array
) -> IntervalArray:
    """Return Taylor polynomials at h with remainders, each of its own order; (nx, rows, m)."""
    total, power = inner[0], intervals.point(np.ones_like(h))
    for n in range(1, len(rest)):
        power = intervals.mul(power, intervals.point(h))
        exact = inner[n] if n < len(inner) else rest[n]
        low = np.where(n == order, rest[n].low, np.where(n < order, exact.low, 0.0))
        high = np.where(n == order, rest[n].high, np.where(n < order, exact.high, 0.0))
        total = intervals.add(total, intervals.mul(IntervalArray(low, high), power))
    return total
