"""A machine as SymPy expressions, step by step, as kinolab computes them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import sympy

from kinolab.dynamics.analysis.fields.to_sympy import FUNCTIONS
from kinolab.dynamics.analysis.trim import symbols_of_state
from kinolab.dynamics.model.model import Model
from kinolab.dynamics.translation.translated import translated


@dataclass(frozen=True, repr=False)
class SympyModel:
    """The derivative of the state as SymPy expressions.

    Common subexpressions have symbols of their own, as ``sympy.cse`` returns them: without them
    equations of large machines would not fit in memory.

    Attributes:
        x: Symbols of the state, the author's own, shape (nx,).
        u: Symbols of the inputs, shape (nu,).
        p: Symbols of the parameters.
        replacements: Pairs of a symbol and its expression in those before it.
        f: Derivative of the state in all of these, a column (nx, 1).
        values: Default values of the parameters.
    """

    x: tuple[sympy.Symbol, ...]
    u: tuple[sympy.Symbol, ...]
    p: tuple[sympy.Symbol, ...]
    replacements: tuple[tuple[sympy.Symbol, sympy.Expr], ...]
    f: sympy.Matrix
    values: Mapping[sympy.Symbol, float]

    def __repr__(self) -> str:
        """Say how large it is."""
        return (
            f"<SympyModel: {len(self.x)} states, {len(self.u)} inputs, "
            f"{len(self.replacements)} common subexpressions>"
        )

    def expanded(self) -> sympy.Matrix:
        """Return f in states, inputs and parameters alone; for small machines."""
        known: dict[sympy.Symbol, sympy.Expr] = {}
        for symbol, expression in self.replacements:
            known[symbol] = expression.xreplace(known)
        return self.f.xreplace(known)


def sympy_model(model: Model) -> SympyModel:
    """Return a machine's equations of motion as SymPy expressions.

    Raises:
        InputError: If the machine has modes or feedback.
    """
    graph, functions = translated(model)
    function, system = functions["f"], model.system
    x = tuple(symbols_of_state(model))
    u = tuple(entry.symbol for entry in system.inputs)
    p = tuple(system.parameters)
    symbols = {"x": x, "u": u, "p": p}
    text = {
        node: symbol
        for name, nodes in function.arguments.items()
        for node, symbol in zip(nodes, symbols[name], strict=True)
    }
    needed = graph.needed(function.outputs)
    used = Counter(function.outputs)
    used.update(operand for node in needed for operand in graph.operations[node].operands)
    replacements: list[tuple[sympy.Symbol, sympy.Expr]] = []
    for node in needed:
        if node in text:
            continue
        operation = graph.operations[node]
        if operation.name == "const":
            whole = operation.value.is_integer()
            text[node] = (sympy.Integer if whole else sympy.Float)(operation.value)
            continue
        expression = FUNCTIONS[operation.name](*(text[operand] for operand in operation.operands))
        if used[node] > 1:
            symbol = sympy.Symbol(f"v{len(replacements)}", real=True)
            replacements.append((symbol, expression))
            expression = symbol
        text[node] = expression
    f = sympy.Matrix([text[node] for node in function.outputs])
    values = {symbol: system.parameter_values[symbol.name] for symbol in p}
    return SympyModel(x, u, p, tuple(replacements), f, values)
