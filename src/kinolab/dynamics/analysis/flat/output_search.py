"""Search for flat outputs among candidates, and among points on the axes of bodies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import scipy

from kinolab.dynamics.analysis.flat.control_system import ControlSystem, MotionSeries
from kinolab.dynamics.analysis.flat.output_candidates import Candidate, Candidates, Point
from kinolab.dynamics.analysis.flat.relative_degrees import (
    ClearRank,
    Extension,
    cleaned,
    clear_rank,
    extension,
    least_orders,
    recovers,
)
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.numerics.arrays import Array

OutputSet: TypeAlias = tuple[Candidate, ...]

# Where an input acts along each velocity, coordinates are flat by so many derivatives.
SURE_ORDER = 2


@dataclass(frozen=True)
class ProvedOutputs:
    """Outputs that are flat.

    Attributes:
        outputs: They, as many as inputs.
        orders: Number of derivatives of each that states and inputs need.
        left_over: Names of states that they do not determine, on which nothing else depends.
        margin: Smallest singular value that counted, of all ranks that prove it.
        at_rest: Whether they determine states and inputs at rest, too; None where no rest is known.
    """

    outputs: OutputSet
    orders: tuple[int, ...]
    left_over: tuple[str, ...]
    margin: float
    at_rest: bool | None


class OutputSearch:
    """The search of one machine, at a few random motions.

    Args:
        rest: A state of rest, shape (nx,), with the inputs that hold it, shape (nu,), if known.
    """

    def __init__(self, control: ControlSystem, rest: tuple[Array, Array] | None = None) -> None:
        self._control, self._rest = control, rest
        self.candidates = Candidates(control)
        self._sets = list(self.candidates.sets())
        self._motions = list(control.motions())
        if not self._motions:
            raise ArithmeticError("no regular state was found")
        self._rolled = self._what_rolls()
        self._work = 0  # multiplications so far
        self.tried = 0  # sets of candidates
        self.finished = True  # whether the algorithm has ended for all of them

    def found(self) -> ProvedOutputs | None:
        """Return flat outputs, None where none are found."""
        return self._among(self._sets) or self._among(list(self._beside_points()))

    def _among(self, sets: list[OutputSet]) -> ProvedOutputs | None:
        """Return the first flat set, in the fewest steps of the algorithm."""
        self.tried += len(sets)
        left = sets
        for k in range(1, self._motions[0].dimension + 2):
            if not left:
                return None
            if not self._reaches(self._motions[0], k):
                break
            undecided = []
            for chosen, result in zip(left, self._after(left, k), strict=True):
                if self._flat(result, self._missing(chosen)):
                    if (proved := self._proved(chosen, k)) is not None:
                        return proved
                elif not (result.closed and result.clear):
                    undecided.append(chosen)
            left = undecided
        self.finished &= not left
        return None

    @property
    def exhausted(self) -> bool:
        """Whether more would take too long."""
        return self._work > 3_000_000_000  # multiplications, a second or two

    def proved(self, chosen: OutputSet) -> ProvedOutputs | None:
        """Return what some outputs, as many as inputs, are; None if they are not flat."""
        return self._among([chosen]) if len(chosen) == len(self._control.inputs) else None

    def _after(self, sets: list[OutputSet], k: int) -> list[Extension]:
        """Return what k steps give; at another motion where the first one leaves doubt."""
        table = self._table(self._motions[0], sets, k)
        results = [self._extension(table, chosen) for chosen in sets]
        for i, chosen in enumerate(sets):
            for motion in self._motions[1:]:
                if not results[i].clear and self._reaches(motion, k):
                    results[i] = self._extension(self._table(motion, [chosen], k), chosen)
        return results

    def _proved(self, chosen: OutputSet, k: int) -> ProvedOutputs | None:
        """Return what is flat at two motions and refuted at none; with how many derivatives."""
        missing, flat = self._missing(chosen), list[tuple[MotionSeries, Extension]]()
        for motion in self._motions:
            if not self._reaches(motion, k):
                break
            result = self._extension(self._table(motion, [chosen], k), chosen)
            if self._flat(result, missing):
                flat.append((motion, result))
            elif result.clear:
                return None
        if len(flat) < 2:
            return None
        motion = max(flat, key=lambda pair: pair[1].margin)[0]
        orders = self._orders(motion, chosen, k, motion.dimension - len(missing))
        if orders is None:
            return None
        names = tuple(self._control.names[i] for i in missing)
        margin = min(result.margin for _, result in flat)
        at_rest = self._at_rest(chosen, orders, len(missing))
        return ProvedOutputs(chosen, orders, names, margin, at_rest)

    def _at_rest(self, chosen: OutputSet, orders: tuple[int, ...], missing: int) -> bool | None:
        """Return whether as many derivatives suffice at an equilibrium; None if none is found."""
        if self._rest is None or self._control.idle:
            return None
        (x, u), generator = self._rest, np.random.default_rng(0)
        held = (u, self._motions[0].pace)
        motion = MotionSeries(self._control, x, generator, held=held)
        if not self._reaches(motion, max(orders)):
            return None
        rows = self._rows(self._table(motion, [chosen], max(orders)), chosen)
        return recovers(rows, orders, motion.dimension, motion.dimension - missing)

    def _orders(
        self, motion: MotionSeries, chosen: OutputSet, k: int, dimension: int
    ) -> tuple[int, ...] | None:
        while self._reaches(motion, k) and k <= 2 * motion.dimension:
            rows = self._rows(self._table(motion, [chosen], k), chosen)
            found = least_orders(rows, motion.dimension, dimension)
            if found is not None:
                return found
            k += 1
        return None

    def _flat(self, result: Extension, missing: Sequence[int]) -> bool:
        wanted = result.dimension - len(missing)
        return result.closed and result.clear and result.determined == wanted

    def _missing(self, chosen: OutputSet) -> tuple[int, ...]:
        """Return what rolls and is not in the outputs."""
        tape = self._control.tape
        used = frozenset[Node]().union(*(tape.depends_on(one.node) for one in chosen))
        return tuple(k for k in self._rolled if self._control.state[k] not in used)

    def _what_rolls(self) -> tuple[int, ...]:
        """Return angles on which no other rate depends and that move no body's centre."""
        tape, points = self._control.tape, self.candidates.points
        placed = frozenset[Node]().union(
            *(tape.depends_on(one.node) for point in points for one in point.entries)
        )
        basis = self._motions[0].basis
        return tuple(
            k
            for k in self._control.without_effect()
            if self._control.state[k] not in placed
            and k < self._control.model.nq
            and np.count_nonzero(basis[k]) == 1  # no constraint is on it
        )

    def _reaches(self, motion: MotionSeries, k: int) -> bool:
        """Extend a motion to k derivatives, if that does not take too long."""
        while motion.order < k:
            self._work += motion.work
            if self.exhausted and k > SURE_ORDER:
                return False
            motion.extend()
        return True

    def _table(self, motion: MotionSeries, sets: Sequence[OutputSet], k: int) -> dict[Node, Array]:
        nodes = list(dict.fromkeys(one.node for chosen in sets for one in chosen))
        rows = motion.along(nodes)[:, : k + 1, : motion.width(k)]
        return dict(zip(nodes, rows, strict=True))

    def _rows(self, table: dict[Node, Array], chosen: OutputSet) -> Array:
        return np.array([table[one.node] for one in chosen])

    def _extension(self, table: dict[Node, Array], chosen: OutputSet) -> Extension:
        return self._counted(self._rows(table, chosen))

    def _counted(self, rows: Array) -> Extension:
        """Return how far the algorithm is; the work is counted."""
        count, orders, width = rows.shape
        # three ranks by 4 n^2 m multiplications each, and as long as 200000 for what is around them
        self._work += 12 * (count * orders) ** 2 * width + 200_000
        return extension(rows, self._motions[0].dimension)

    def _beside_points(self) -> Iterator[OutputSet]:
        """Yield sets with a point beside a centre of mass, where the algorithm goes further.

        The place of a point is affine in its offset along an axis, and so are all derivatives. For
        all but a few offsets the algorithm ends after k steps; it goes further where the pencil of
        matrices dy^(k)/du^(k) loses rank, which is a generalised eigenvalue.
        """
        count = len(self._control.inputs)
        for point in self.candidates.points:
            if not point.central or not 2 <= len(point.entries) <= count:
                continue
            for others in self._others(point, count - len(point.entries)):
                for axis in range(3):
                    if self.exhausted:
                        self.finished = False
                        return
                    for offset in self._offsets(point, axis, others):
                        beside = self.candidates.beside(point, axis, offset)
                        yield (*beside.entries, *others)

    def _others(self, point: Point, count: int) -> Iterator[OutputSet]:
        nodes = {one.node for one in point.entries}
        for chosen in self._sets:
            if nodes <= {one.node for one in chosen}:
                others = tuple(one for one in chosen if one.node not in nodes)
                if len(others) == count:
                    yield others

    def _offsets(self, point: Point, axis: int, others: OutputSet) -> list[float]:
        """Return the offsets that stand out at two motions alike."""
        pencils = [self._pencil(motion, point, axis, others) for motion in self._motions[:2]]
        if any(pencil is None for pencil in pencils):
            return []
        first, second = ([*_rank_drops(*pencil)] for pencil in pencils if pencil is not None)
        # 1e-6 of an offset: both are exact but for rounding, which leaves 12 digits
        alike = [a for a in first if any(abs(a - b) <= 1e-6 * abs(a) for b in second)]
        return [float(f"{offset:.12g}") for offset in alike]

    def _pencil(
        self, motion: MotionSeries, point: Point, axis: int, others: OutputSet
    ) -> tuple[Array, Array, ClearRank] | None:
        """Return dy/du without an offset, its change per metre, and the rank of most sums."""
        places = [one.node for one in (*point.entries, *others)]
        slopes = self.candidates.slopes(point, axis)
        tape, count = self._control.tape, len(places)
        if all(not tape.depends_on(node) & frozenset(self._control.state) for node in slopes):
            return None
        for k in range(1, motion.dimension + 2):
            if not self._reaches(motion, k):
                return None
            base = motion.along(places)[:, : k + 1, : motion.width(k)]
            change = np.zeros_like(base)
            change[: len(slopes)] = motion.along(slopes)[:, : k + 1, : motion.width(k)]
            result = self._counted(base + change)
            if result.closed and result.clear:
                both = np.concatenate([base, change], axis=2).reshape(count * (k + 1), -1)
                first, second = np.split(cleaned(both), 2, axis=1)
                first, second = first[:, motion.dimension :], second[:, motion.dimension :]
                return first, second, clear_rank(first + second)
        return None


def _rank_drops(base: Array, change: Array, generic: ClearRank) -> Iterator[float]:
    """Yield the real numbers s for which base + s change has less than its generic rank."""
    generator, rank = np.random.default_rng(0), generic.value
    left = generator.normal(size=(rank, len(base)))
    right = generator.normal(size=(base.shape[1], rank))
    values = scipy.linalg.eigvals(left @ base @ right, -(left @ change @ right))
    for value in values[np.isfinite(values)]:
        # 1e-4 and 1e3 [m]: an offset of a machine; rounding parts eigenvalues from the real axis
        if 1e-4 < abs(value) < 1e3 and abs(value.imag) < 1e-4 * abs(value):
            refined = _refined(base, change, rank, float(value.real))
            if refined is not None:
                yield refined


def _refined(base: Array, change: Array, rank: int, s: float) -> float | None:
    """Return s where the smallest singular value vanishes, by Newton's method; None if nowhere."""
    for _ in range(8):
        left, values, right = np.linalg.svd(base + s * change)
        slope = left[:, rank - 1] @ change @ right[rank - 1]
        if values[rank - 1] < 1e-13 * values[0] or slope == 0.0:
            break
        s -= float(values[rank - 1] / slope)
    values = np.linalg.svd(base + s * change, compute_uv=False)
    return s if values[rank - 1] < 1e-11 * values[0] else None
