"""Conversion of expression graph nodes to SymPy expressions in the author's symbols."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from kinolab.dynamics.derivation import lowering
from kinolab.dynamics.derivation.expression_graph import ARITHMETIC, ExpressionGraph, Node
from kinolab.dynamics.symbols.expressions import as_written

FUNCTIONS = {
    **{name: function for function, name in lowering.FUNCTIONS.items()},
    **ARITHMETIC,
    **{"sqrt": sympy.sqrt, "fmax": sympy.Max},
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

    def leaf(node: Node) -> sympy.Expr:
        operation = tape.operations[node]
        constant = operation.name == "const"
        return as_written(operation.value) if constant else symbols[operation.label]

    return tape.folded(outputs, leaf, FUNCTIONS)
