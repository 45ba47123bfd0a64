"""JavaScript functions from expression graph nodes: the same operations in the same order.

A node used once is inlined; the others become constants of the function.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence

from kinolab.dynamics.codegen.exports import OPERATORS, Function
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node, Operation

SINGULAR = 1  # status where a guard fails; a non-finite result has status 2

BUILT_IN = {"fabs": "Math.abs"}


def emit_function(function: Function, tape: ExpressionGraph) -> str:
    """Return the text of ``name(x, u, p, out)``, which writes into out and returns a status.

    The status is 0, or what the runtime calls SINGULAR or NOT_FINITE.
    """
    wanted = (*function.outputs, *function.guards)
    body = _Body(tape, function.arguments, wanted)
    results = [f"out[{k}] = {body.text[node]};" for k, node in enumerate(function.outputs)]
    lines = [*body.lines, *results, f"return {_status(function, body.text)};"]
    inside = "\n".join(f"  {line}" for line in lines)
    return f"function {function.name}({', '.join(function.arguments)}, out) {{\n{inside}\n}}"


class _Body:
    """The statements of one function, and the text of each node."""

    def __init__(
        self, tape: ExpressionGraph, arguments: Mapping[str, Sequence[Node]], wanted: Sequence[Node]
    ) -> None:
        self.lines: list[str] = []
        self.text: dict[Node, str] = {}
        places = {
            node: (array, index)
            for array, nodes in arguments.items()
            for index, node in enumerate(nodes)
        }
        needed = tape.needed(wanted)
        uses = Counter(wanted)
        for node in needed:
            uses.update(tape.operations[node].operands)
        for node in needed:
            operation = tape.operations[node]
            match operation.name:
                case "const":
                    self.text[node] = number(operation.value)
                case "variable":
                    array, index = places[node]
                    self._name(node, f"{array}{index}", f"{array}[{index}]")
                case _:
                    operands = [self.text[operand] for operand in operation.operands]
                    self.text[node] = expression = _expression(operation, operands)
                    # 160 characters; a longer node becomes a constant
                    if uses[node] > 1 or len(expression) > 160:
                        self._name(node, f"v{node}", expression)

    def _name(self, node: Node, name: str, expression: str) -> None:
        self.lines.append(f"const {name} = {expression};")
        self.text[node] = name


def number(value: float) -> str:
    """Return a number as text that round-trips exactly."""
    if not math.isfinite(value):
        return "NaN" if math.isnan(value) else f"({'-' * (value < 0)}Infinity)"
    text = repr(value).removesuffix(".0")
    return f"({text})" if value < 0 else text


def _expression(operation: Operation, operands: Sequence[str]) -> str:
    name = operation.name
    if name in OPERATORS:
        return f"({operands[0]} {OPERATORS[name]} {operands[1]})"
    if name == "neg":
        return f"(-{operands[0]})"
    # These are defined in the runtime: Math treats NaN differently
    called = name if name in ("fmax", "sign") else BUILT_IN.get(name, f"Math.{name}")
    return f"{called}({', '.join(operands)})"


def _status(function: Function, text: Mapping[Node, str]) -> str:
    finite = f"finite(out, {len(function.outputs)})"
    if not function.guards:
        return finite
    valid = " && ".join(f"{text[guard]} > 0" for guard in function.guards)
    return f"{valid} ? {finite} : {SINGULAR}"
