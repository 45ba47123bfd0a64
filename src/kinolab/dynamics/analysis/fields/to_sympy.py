"""Conversion of expression graph nodes to SymPy expressions in the author's symbols."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.language.expressions import as_written

FUNCTIONS = {
    "sin": sympy.sin,
    "cos": sympy.cos,
    "tan": sympy.tan,
    "exp": sympy.exp,
    "log": sympy.log,
    "sqrt": sympy.sqrt,
    "tanh": sympy.tanh,
    "atan": sympy.atan,
    "fabs": sympy.Abs,
    "sign": sympy.sign,
    "fmax": sympy.Max,
    "neg": lambda a: -a,
    "add": lambda a, b: a + b,
    "sub": lambda a, b: a - b,
    "mul": lambda a, b: a * b,
    "div": lambda a, b: a / b,
}


def to_sympy(
    tape: ExpressionGraph, outputs: Sequence[Node], symbols: Mapping[str, sympy.Symbol]
) -> list[sympy.Expr]:
    """Return nodes as expressions, simplified by SymPy's constructors only.

    Args:
        tape: The expression graph.
        outputs: Nodes to convert.
        symbols: Symbols of the variables, by label.
    """
    memo: dict[Node, sympy.Expr] = {}
    for node in tape.needed(outputs):
        operation = tape.operations[node]
        if operation.name == "const":
            memo[node] = as_written(operation.value)
        elif operation.name == "variable":
            memo[node] = symbols[operation.label]
        else:
            memo[node] = FUNCTIONS[operation.name](*(memo[o] for o in operation.operands))
    return [memo[output] for output in outputs]
