"""Formulas as data, evaluated at arrays; unlike the expressions they come from, without SymPy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node, Operation
from kinolab.numerics import intervals
from kinolab.numerics.arrays import Array
from kinolab.numerics.intervals import ON_INTERVALS, IntervalArray

ON_ARRAYS: dict[str, np.ufunc] = {
    **{name: getattr(np, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh")},
    **{"atan": np.arctan, "fabs": np.abs, "sign": np.sign, "neg": np.negative},
    **{"add": np.add, "sub": np.subtract, "mul": np.multiply, "div": np.divide},
    "fmax": np.maximum,
}

TURNED = ("add", "sub", "neg")  # an argument that grows by full turns makes these do so, too

# Of the size of its terms, below which a sum counts as nothing: a root of what is that far below
# zero is undefined, and a quotient by it has no bound. What cancels in numbers may not in boxes.
CANCELLED = 1e-2


@dataclass(frozen=True)
class Formulas:
    """Functions of named variables.

    Attributes:
        operations: Each with operands before it.
        ends: Indices of the operations whose values are returned.
    """

    operations: tuple[Operation, ...]
    ends: tuple[int, ...]

    @classmethod
    def of(cls, graph: ExpressionGraph, outputs: Sequence[Node]) -> Formulas:
        """Return what some nodes of a graph depend on."""
        needed = graph.needed(outputs)
        place = {node: k for k, node in enumerate(needed)}
        operations = []
        for node in needed:
            made = graph.operations[node]
            operands = tuple(place[operand] for operand in made.operands)
            operations.append(Operation(made.name, operands, made.value, made.label))
        return cls(tuple(operations), tuple(place[node] for node in outputs))

    def part(self, ends: Iterable[int]) -> Formulas:
        """Return some of the functions, by their places among the ends."""
        roots = [self.ends[k] for k in ends]
        needed, stack = set[int](), list(roots)
        while stack:
            if (k := stack.pop()) not in needed:
                needed.add(k)
                stack += self.operations[k].operands
        place = {k: i for i, k in enumerate(sorted(needed))}
        operations = (
            self.operations[k]._replace(
                operands=tuple(place[o] for o in self.operations[k].operands)
            )
            for k in place
        )
        return Formulas(tuple(operations), tuple(place[k] for k in roots))

    def beside(self, other: Formulas) -> Formulas:
        """Return these functions, then other ones."""
        shift = len(self.operations)
        moved = (
            operation._replace(operands=tuple(k + shift for k in operation.operands))
            for operation in other.operations
        )
        ends = (*self.ends, *(k + shift for k in other.ends))
        return Formulas((*self.operations, *moved), ends)

    @property
    def variables(self) -> set[str]:
        """Names of what the functions depend on."""
        return {operation.label for operation in self.operations if operation.label}

    def turns_with(self, variable: str) -> bool:
        """Whether the functions stay the same when a variable grows by a full turn, for sure.

        It is so where the variable, with terms added to it, is an argument of waves alone.
        """
        bare: list[bool] = []  # does it grow by turns with the variable?
        for operation in self.operations:
            turned = any(bare[k] for k in operation.operands)
            bare.append(operation.label == variable or (turned and operation.name in TURNED))
            if turned and operation.name not in (*TURNED, "sin", "cos", "tan"):
                return False
        return not any(bare[k] for k in self.ends)

    def __call__(self, values: Mapping[str, Array]) -> list[Array]:
        """Evaluate at values of the variables; a constant's result has shape ()."""
        found: list[Array] = []
        for operation in self.operations:
            if operation.name == "const":
                found.append(np.asarray(operation.value))
            elif operation.name == "variable":
                found.append(np.asarray(values[operation.label], float))
            else:
                operands = (found[k] for k in operation.operands)
                found.append(ON_ARRAYS[operation.name](*operands))
        return [found[k] for k in self.ends]

    def enclose(self, values: Mapping[str, IntervalArray]) -> list[IntervalArray]:
        """Enclose what they are over boxes of the variables; a constant's has shape ()."""
        found = self._enclosed(values)
        return [found[k] for k in self.ends]

    def enclose_closely(
        self, values: Mapping[str, IntervalArray], varying: Sequence[str]
    ) -> tuple[list[IntervalArray], list[Array]]:
        """Enclose over boxes by the mean value theorem, too: four times as closely in half the box.

        What differs from the value in the middle is at most the sum of derivatives in the box times
        distances from the middle.

        Args:
            values: The boxes (m,) of each variable.
            varying: Names of the variables that differ in them.

        Returns:
            Enclosures, and how much of their width comes from each of those variables at most,
            shape (len(varying), m).

        Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis, SIAM 2009, section 6.3.
        """
        found = self._enclosed(values)
        low, high = (
            np.array([getattr(values[name], end) for name in varying]) for end in ("low", "high")
        )
        middle = 0.5 * (low + high)
        at = dict(values) | dict(zip(varying, map(intervals.point, middle), strict=True))
        slopes, reach = self._slopes(found, varying), np.maximum(high - middle, middle - low)
        closer, spreads = [], []
        for k, value in zip(self.ends, self.enclose(at), strict=True):
            slope = slopes[k]
            size = np.zeros_like(reach) if slope is None else slope.magnitude
            spread = np.where(reach > 0.0, size * reach, 0.0)
            gap = spread.sum(axis=0) * (1.0 + len(varying) * intervals.ROUNDING)
            around = intervals.add(value, IntervalArray(-gap, gap))
            low, high = np.fmax(found[k].low, around.low), np.fmin(found[k].high, around.high)
            closer.append(IntervalArray(low, high))
            spreads.append(spread)
        return closer, spreads

    def _slopes(
        self, found: Sequence[IntervalArray], varying: Sequence[str]
    ) -> list[IntervalArray | None]:
        """Enclose derivatives of operations by some variables, (n, ...); None: all are 0."""
        slopes: list[IntervalArray | None] = []
        for (name, operands, _, label), value in zip(self.operations, found, strict=True):
            slope = None
            if label in varying:
                own = np.array([label == variable for variable in varying], dtype=float)
                slope = intervals.point(own[:, None])
            for k, operand in enumerate(operands):
                if (d := slopes[operand]) is not None:
                    part = intervals.slope_of(name, k, [found[o] for o in operands], value, d)
                    slope = part if slope is None else intervals.add(slope, part)
            slopes.append(slope)
        return slopes

    def enclose_with_sizes(
        self, values: Mapping[str, IntervalArray]
    ) -> tuple[list[IntervalArray], list[Array]]:
        """Enclose over boxes, with how large in them the terms are at least that each is made of.

        Where a sum is small because its terms cancel, these are what it is small beside. From minus
        infinity where a root or a logarithm may have no value.
        """
        found = self._enclosed(values)
        sizes, gap = self._least_sizes(found, values), np.asarray(False)
        for operation in self.operations:
            if operation.name in ("sqrt", "log"):
                (k,) = operation.operands
                gap = gap | (found[k].low < -CANCELLED * sizes[k])
        ends = [found[k] for k in self.ends]
        ends = [IntervalArray(np.where(gap, -np.inf, one.low), one.high) for one in ends]
        return ends, [sizes[k] for k in self.ends]

    def _enclosed(self, values: Mapping[str, IntervalArray]) -> list[IntervalArray]:
        """Enclose all operations."""
        found: list[IntervalArray] = []
        for operation in self.operations:
            operands = [found[k] for k in operation.operands]
            if operation.name == "const":
                found.append(intervals.point(operation.value))
            elif operation.name == "variable":
                found.append(values[operation.label])
            elif operation.name == "mul" and operation.operands[0] == operation.operands[1]:
                found.append(intervals.square(operands[0]))
            else:
                found.append(ON_INTERVALS[operation.name](*operands))
        return found

    def _least_sizes(
        self, found: Sequence[IntervalArray], values: Mapping[str, IntervalArray]
    ) -> list[Array]:
        """Return the least sizes of all operations, given what encloses them.

        Terms are those of sums, and of their multiples, 0 / 0 included. All else is a term itself,
        as large as its value: where ``|x - a|`` or ``(x - a)^2`` is nothing, ``a`` excuses nothing.
        """
        sizes: list[Array] = []
        fixed: list[bool] = []  # does it not depend on what varies in the boxes?
        for operation, enclosed in zip(self.operations, found, strict=True):
            name, of = operation.name, operation.operands
            if name == "variable":
                box = values[operation.label]
                fixed.append(np.array_equal(box.low, box.high))
            else:
                fixed.append(all(fixed[k] for k in of))
            size = enclosed.mignitude
            match name:
                case "add" | "sub":
                    size = sizes[of[0]] + sizes[of[1]]
                case "neg":
                    size = sizes[of[0]]
                case "mul" if fixed[of[0]]:
                    size = found[of[0]].mignitude * sizes[of[1]]
                case "mul" if fixed[of[1]]:
                    size = sizes[of[0]] * found[of[1]].mignitude
                case "div":
                    over = found[of[1]]
                    cancels = over.mignitude < CANCELLED * sizes[of[1]]
                    multiple = sizes[of[0]] / over.magnitude
                    size = np.where(fixed[of[1]] | cancels, multiple, size)
                case "sin" | "cos" | "tanh" | "atan":
                    size = np.ones_like(size)
            sizes.append(size)
        return sizes
