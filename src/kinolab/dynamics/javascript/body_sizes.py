"""Shape dimensions as functions of parameters, emitted for drawing in web pages."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinolab.dynamics.codegen.exports import Function
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.language.expressions import exact
from kinolab.dynamics.language.shapes import Hull, Shape
from kinolab.dynamics.language.shapes.hulls import hull_surface


def body_sizes(binding: SymbolTable) -> tuple[list[list[dict[str, Any]]], Function]:
    """Return the shapes of all bodies, and a function for their dimensions.

    Returns:
        Facts per body and shape: kind, axis of symmetry if any, names of its dimensions, and the
        offsets of dimensions and position among the results; and the surface of a hull, which
        follows no parameter. Then ``shapes(p)``: dimensions in [m], and position in the body's
        frame in [m].
    """
    outputs, system = list[Node](), binding.system
    facts = [
        [
            _fact(shape, binding, outputs) | (_surface(shape) if isinstance(shape, Hull) else {})
            for shape in system.kept_shapes(body)
        ]
        for body in system.bodies
    ]
    return facts, Function("shapes", {"p": binding.parameters}, outputs)


def _fact(shape: Shape, binding: SymbolTable, outputs: list[Node]) -> dict[str, Any]:
    names = shape.lengths()
    first = len(outputs)
    values = (*(getattr(shape, name) for name in names), *shape.at)
    outputs += [binding.lower(exact(value)) for value in values]
    return {
        "kind": type(shape).__name__.lower(),
        "axis": shape.axis,
        "dimensions": names,
        "first": first,
    }


def _surface(hull: Hull) -> dict[str, Any]:
    """Return the corners and faces of a hull, along the axes of its body's frame."""
    _, (_, _, _, *corners) = hull.lowered()
    vertices, faces, _ = hull_surface(np.reshape(corners, (-1, 3)))
    vertices = np.roll(vertices, "xyz".index(hull.axis) + 1, axis=1)  # own z lies along the axis
    return {"hull": {"corners": vertices.tolist(), "faces": faces.ravel().tolist()}}
