"""Formulas as data, evaluated at arrays; unlike the expressions they come from, without SymPy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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

    def enclose(self, values: Mapping[str, IntervalArray]) -> list[IntervalArray]:
        """Enclose what they are over boxes of the variables; a constant's has shape ()."""
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
        return [found[k] for k in self.ends]
