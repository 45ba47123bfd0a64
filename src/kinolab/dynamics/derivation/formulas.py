"""Formulas as data, evaluated at arrays; unlike the expressions they come from, without SymPy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

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


# Of its upper end: how far below zero the lower end of an interval may be before its root counts as
# undefined. What cancels in numbers does not in intervals.
ROOM_BELOW_ZERO = 1e-2


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

    def sizes(self, values: Mapping[str, Array]) -> list[Array]:
        """Return how large the terms are that each is made of, at values of the variables.

        Where a sum is small because its terms cancel, this is what it is small beside.
        """
        found: list[tuple[Array, Array]] = []  # each with its value
        for operation in self.operations:
            name, given = operation.name, [found[k] for k in operation.operands]
            sizes, operands = [size for size, _ in given], [value for _, value in given]
            if name == "const":
                value = np.asarray(operation.value)
            elif name == "variable":
                value = np.asarray(values[operation.label], float)
            else:
                value = ON_ARRAYS[name](*operands)
            match name:
                case "add" | "sub":
                    size = sizes[0] + sizes[1]
                case "mul":
                    size = sizes[0] * sizes[1]
                case "div":
                    size = sizes[0] / np.abs(operands[1])
                case "fmax":
                    size = np.maximum(*sizes)
                case "neg" | "fabs":
                    size = sizes[0]
                case "sqrt":
                    size = np.sqrt(sizes[0])
                case "sin" | "cos" | "tanh" | "atan" | "sign":
                    size = np.ones_like(value)
                case _:
                    size = np.abs(value)
            found.append((size, value))
        return [found[k][0] for k in self.ends]

    def enclose(
        self, values: Mapping[str, IntervalArray], undefined: list[NDArray[np.bool_]] | None = None
    ) -> list[IntervalArray]:
        """Enclose what they are over boxes of the variables; a constant's has shape ().

        Args:
            values: The boxes.
            undefined: Takes where a root or a logarithm may have no value, for each of them.
        """
        found: list[IntervalArray] = []
        for operation in self.operations:
            operands = [found[k] for k in operation.operands]
            if undefined is not None and operation.name in ("sqrt", "log"):
                undefined.append(operands[0].low < -ROOM_BELOW_ZERO * np.abs(operands[0].high))
            if operation.name == "const":
                found.append(intervals.point(operation.value))
            elif operation.name == "variable":
                found.append(values[operation.label])
            elif operation.name == "mul" and operation.operands[0] == operation.operands[1]:
                found.append(intervals.square(operands[0]))
            else:
                found.append(ON_INTERVALS[operation.name](*operands))
        return [found[k] for k in self.ends]
