"""Shape dimensions as functions of parameters, emitted for drawing in web pages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

from kinolab.dynamics.codegen.exports import Function
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.shapes import Shape


@dataclass(frozen=True)
class BodySizes:
    """Shapes of all bodies and a function for their dimensions.

    Attributes:
        facts: Per body and shape: kind, axis of symmetry if any, names of its dimensions, and the
            offsets of dimensions and position among the results.
        function: ``shapes(p)``: dimensions in [m], and position in the body's frame in [m].
    """

    facts: list[list[dict[str, Any]]]
    function: Function


def body_sizes(system: Mechanism, binding: SymbolTable) -> BodySizes:
    """Return the shapes of all bodies with their dimensions as nodes."""
    outputs = list[Node]()
    facts = [[_fact(shape, binding, outputs) for shape in body.shapes] for body in system.bodies]
    return BodySizes(facts, Function("shapes", {"p": binding.parameters}, outputs))


def _fact(shape: Shape, binding: SymbolTable, outputs: list[Node]) -> dict[str, Any]:
    names = _dimensions(shape)
    first = len(outputs)
    values = (*(getattr(shape, name) for name in names), *shape.at)
    outputs += [binding.lower(exact(value)) for value in values]
    return {
        "kind": type(shape).__name__.lower(),
        "axis": getattr(shape, "axis", None),
        "dimensions": list(names),
        "first": first,
    }


def _dimensions(shape: Shape) -> Sequence[str]:
    return [field.name for field in fields(shape) if field.name not in ("axis", "at")]
