"""How fast points of a machine are, and how fast that changes, over all states within limits.

All states that a plan may hold, and all inputs, are covered by boxes over which the machine's
formulas are enclosed. The boxes that decide on a bound are halved again and again.

Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis, SIAM 2009, chapter 6.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinolab.dynamics.codegen.mode_formulas import MOST_OPERATIONS, ModeFormulas
from kinolab.dynamics.derivation.formulas import Formulas
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import IntervalArray
from kinolab.problem import PlanningTask
from kinolab.problem.task import LIMIT_TOLERANCE
from kinolab.verification.lower_bound.speed_limits import SpeedLimits

# More make bounds tighter, and take longer; they never make one false.
LEVELS = 32  # of speed, between which bounds of its change are told apart
ROUNDED = 1e-6  # by which the square of a unit vector's length may be off
FAR = 1e6  # in SI units: where what has no limit is cut next

# enclosures of rates and of their changes -> of a speed, and of its change
Measure = Callable[[Sequence[IntervalArray]], tuple[IntervalArray, IntervalArray]]


class AdmissibleStates:
    """Boxes of the states of one mode that keep all limits, with the inputs that may act in them.

    Args:
        mode: The formulas of the mode.
        formulas: That are to be enclosed.
    """

    def __init__(self, problem: PlanningTask, mode: ModeFormulas, formulas: Formulas) -> None:
        plant = problem.model.plant
        self._problem, self._mode, self._formulas = problem, mode, formulas
        self._parameters = dict(
            zip(mode.parameters, map(intervals.point, plant.parameter_vector()), strict=True)
        )
        self.names = (*mode.state, *mode.inputs)
        limits = np.vstack([problem.bounds[: len(mode.state)], plant.control_bounds])
        self.root = limits + np.array([-LIMIT_TOLERANCE, LIMIT_TOLERANCE])
        for part in plant.space.spheres:
            self.root[part.own] = -1.0 - LIMIT_TOLERANCE, 1.0 + LIMIT_TOLERANCE
        for i, name in enumerate(self.names):
            kinds = (formulas, mode.requirements, mode.velocities)
            endless = not np.isfinite(self.root[i]).all()
            if endless and all(kind.turns_with(name) for kind in kinds):
                self.root[i] = -np.pi, np.pi
        self.used = [i for i, name in enumerate(self.names) if name in formulas.variables]
        self._limited = [
            k for k, limit in enumerate(problem.rate_bounds) if np.isfinite(limit).any()
        ]

    def at(self, x: Array) -> Array:
        """Return the box of one state (nx,), shape (n, 2), with all inputs."""
        box = np.array(self.root)
        box[: len(self._mode.state)] = x[: len(self._mode.state), None]
        return box

    def goal(self) -> Array:
        """Return a box that holds all states of the goal, shape (n, 2)."""
        box, goal = np.array(self.root), self._problem.goal
        for i, target, reach in zip(goal.indices, goal.targets, goal.tolerances, strict=True):
            if i < len(self._mode.state):
                box[i] = target - reach, target + reach
        return box

    def enclosed(self, boxes: Array) -> tuple[list[IntervalArray], list[Array]]:
        """Enclose the formulas over boxes (m, n, 2), as ``Formulas.enclose_closely`` does."""
        names = [self.names[i] for i in self.used]
        found, spreads = self._formulas.enclose_closely(self._values(boxes), names)
        return [_of_shape(one, len(boxes)) for one in found], spreads

    def possible(self, boxes: Array) -> NDArray[np.bool_]:
        """Say which boxes (m, n, 2) may hold a state of a plan."""
        values, mode = self._values(boxes), self._mode
        kept = np.ones(len(boxes), dtype=bool)
        if len(mode.requirements.operations) <= MOST_OPERATIONS:
            for margin in mode.requirements.enclose(values):
                kept &= ~(margin.high < -LIMIT_TOLERANCE)
        if self._limited:
            rates = mode.velocities.enclose(values)
            for k in self._limited:
                lower, upper = self._problem.rate_bounds[k]
                kept &= ~(rates[k].low > upper + LIMIT_TOLERANCE)
                kept &= ~(rates[k].high < lower - LIMIT_TOLERANCE)
        for part in self._problem.model.plant.space.spheres:
            squares = [intervals.square(values[self.names[i]]) for i in part.entries]
            kept &= sum(s.low for s in squares) <= 1.0 + ROUNDED
            kept &= sum(s.high for s in squares) >= 1.0 - ROUNDED
        return kept

    def _values(self, boxes: Array) -> dict[str, IntervalArray]:
        sides = (IntervalArray(boxes[:, i, 0], boxes[:, i, 1]) for i in range(len(self.names)))
        return self._parameters | dict(zip(self.names, sides, strict=True))


@dataclass(frozen=True, eq=False)
class Cover:
    """Boxes that cover all states.

    Attributes:
        boxes: Shape (m, n, 2).
        speed: In each, shape (m,).
        change: How fast the speed changes in each, shape (m,).
        spreads: How much each entry widens the change, and the speed, shape (m, 2, used).
        far: A speed beyond which its changes do not matter.
    """

    boxes: Array
    speed: IntervalArray
    change: IntervalArray
    spreads: Array
    far: float = FAR

    @classmethod
    def of(
        cls, states: AdmissibleStates, boxes: Array, measure: Measure, far: float = FAR
    ) -> Cover:
        """Return boxes with what is known of them; those without a state that keeps limits go."""
        with np.errstate(all="ignore"):  # infinite where a box is too wide
            boxes = boxes[states.possible(boxes)]
            found, spreads = states.enclosed(boxes)
            speed, change = (_anything_for_nan(one) for one in measure(found))
            half = len(found) // 2
            wide = np.array([sum(spreads[half:]), sum(spreads[:half])])
        wide = np.nan_to_num(wide, nan=np.inf, posinf=np.inf).reshape(2, -1, len(boxes))
        return cls(boxes, speed, change, np.moveaxis(wide, 2, 0), far)

    @property
    def levels(self) -> Array:
        """Speeds from 0 to the largest, or far enough, between which their changes are bounded."""
        return np.linspace(0.0, min(self.top, self.far), LEVELS + 1)

    @property
    def top(self) -> float:
        """The largest speed."""
        return max(float(self.speed.high.max(initial=0.0)), 0.0)

    def limits(self) -> SpeedLimits:
        """Return bounds that hold in all boxes together."""
        gain, loss = self._by_level()
        most = (table.max(axis=1, initial=-np.inf) for table in (gain, loss))
        return SpeedLimits(self.top, self.levels, *most)

    def _by_level(self) -> tuple[Array, Array]:
        """Return gain and loss in each box, where it has speeds between two levels, (k, m)."""
        below, above = self.levels[:-1, None], self.levels[1:, None]
        met = (self.speed.high >= below) & (self.speed.low <= above)
        return np.where(met, self.change.high, -np.inf), np.where(met, -self.change.low, -np.inf)

    def halved(self, states: AdmissibleStates, measure: Measure) -> Cover:
        """Return a finer cover: halves of the boxes that decide on a bound, where they are wide."""
        fastest = np.argsort(-self.speed.high, kind="stable")[:LEVELS]
        rows = np.concatenate([*(table.argmax(axis=1) for table in self._by_level()), fastest])
        why = np.repeat([0, 1], [2 * LEVELS, len(fastest)])
        rows, first = np.unique(rows, return_index=True)
        spread = self.spreads[rows, why[first]]
        width = (
            np.ptp(self.boxes[rows][:, states.used], axis=2)
            / np.ptp(states.root, axis=1)[states.used]
        )
        endless = np.isinf(spread).any(axis=1, keepdims=True)
        spread = np.where(endless, np.where(np.isinf(spread), width, 0.0), spread)
        entries = np.array(states.used)[spread.argmax(axis=1)]
        fresh = Cover.of(states, _halves(self.boxes[rows], entries), measure, self.far)
        rest = np.delete(np.arange(len(self.boxes)), rows)
        return Cover(
            np.concatenate([self.boxes[rest], fresh.boxes]),
            _joined(self.speed, rest, fresh.speed),
            _joined(self.change, rest, fresh.change),
            np.concatenate([self.spreads[rest], fresh.spreads]),
            self.far,
        )


def _halves(boxes: Array, entries: NDArray[np.intp]) -> Array:
    """Return both halves of boxes (m, n, 2), each along an entry, (2 m, n, 2)."""
    left, right, each = boxes.copy(), boxes.copy(), np.arange(len(boxes))
    low, high = boxes[each, entries].T
    middle = np.clip(0.5 * (np.maximum(low, -FAR) + np.minimum(high, FAR)), low, high)
    left[each, entries, 1] = right[each, entries, 0] = middle
    return np.concatenate([left, right])


def along(sign: float) -> Measure:
    """Return the measure of one coordinate: its rate towards one side."""

    def measure(found: Sequence[IntervalArray]) -> tuple[IntervalArray, IntervalArray]:
        rate, change = found
        return (rate, change) if sign > 0 else (intervals.neg(rate), intervals.neg(change))

    return measure


def magnitude(found: Sequence[IntervalArray]) -> tuple[IntervalArray, IntervalArray]:
    """Measure a vector: its length, and how fast that changes, v dv/dt / |v|.

    Args:
        found: The vector's components, then their changes in the same axes; axes may turn, which
            changes no length.
    """
    half = len(found) // 2
    vector, changes = found[:half], found[half:]
    squares = [intervals.square(one) for one in vector]
    speed = intervals.sqrt(_sum(squares))
    terms = []
    for i, (one, change) in enumerate(zip(vector, changes, strict=True)):
        others = _sum([squares[j] for j in range(half) if j != i] or [intervals.point(0.0)])
        most = np.clip(_quotient(one.magnitude, speed.low), 0.0, 1.0)
        rest = np.clip(1.0 - _quotient(others.high, speed.low**2), 0.0, 1.0)
        least = np.maximum(np.sqrt(rest) * (1.0 - 1e-12), 0.0)
        direction = IntervalArray(
            np.where(one.low >= 0.0, least, -most), np.where(one.high <= 0.0, -least, most)
        )
        still = (one.low == 0.0) & (one.high == 0.0)
        direction = IntervalArray(
            np.where(still, 0.0, direction.low), np.where(still, 0.0, direction.high)
        )
        terms.append(intervals.mul(direction, change))
    change, longest = _sum(terms), intervals.sqrt(_sum([intervals.square(c) for c in changes]))
    return speed, IntervalArray(
        np.maximum(change.low, -longest.high), np.minimum(change.high, longest.high)
    )


def turning(axis: Sequence[float]) -> Measure:
    """Return the measure of a body's axis (3,): how fast it turns in the world, by its spin."""

    def measure(found: Sequence[IntervalArray]) -> tuple[IntervalArray, IntervalArray]:
        return magnitude([*_cross(found[:3], axis), *_cross(found[3:], axis)])

    return measure


def _cross(a: Sequence[IntervalArray], b: Sequence[float]) -> list[IntervalArray]:
    x, y, z = map(intervals.point, b)
    pairs = ((a[1], z, a[2], y), (a[2], x, a[0], z), (a[0], y, a[1], x))
    return [intervals.sub(intervals.mul(p, q), intervals.mul(r, s)) for p, q, r, s in pairs]


def _quotient(a: Array, b: Array) -> Array:
    """Return a / b, infinite where b is 0, a little too large."""
    return np.where(b > 0.0, a / np.where(b > 0.0, b, 1.0) * (1.0 + 1e-12), np.inf)


def _sum(terms: Sequence[IntervalArray]) -> IntervalArray:
    total = terms[0]
    for term in terms[1:]:
        total = intervals.add(total, term)
    return total


def _joined(one: IntervalArray, rows: NDArray[np.intp], other: IntervalArray) -> IntervalArray:
    low, high = (one.low[rows], other.low), (one.high[rows], other.high)
    return IntervalArray(np.concatenate(low), np.concatenate(high))


def _of_shape(one: IntervalArray, size: int) -> IntervalArray:
    return IntervalArray(np.broadcast_to(one.low, size), np.broadcast_to(one.high, size))


def _anything_for_nan(one: IntervalArray) -> IntervalArray:
    """Return intervals that hold everything where an end is not a number."""
    low, high = np.isnan(one.low), np.isnan(one.high)
    return IntervalArray(np.where(low, -np.inf, one.low), np.where(high, np.inf, one.high))
