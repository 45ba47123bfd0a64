"""From a derivation to the text of a machine's JavaScript, sizes of its shapes included."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from kinolab.dynamics.codegen.closed_loop import law_of
from kinolab.dynamics.codegen.exports import Function, outputs_of, tangent_of
from kinolab.dynamics.derivation.derivation import Derivation, derive
from kinolab.dynamics.derivation.expression_graph import Node
from kinolab.dynamics.derivation.symbol_table import SymbolTable
from kinolab.dynamics.facts.mode_derivations import ModeDerivation, derive_modes
from kinolab.dynamics.javascript.constraint_forces import constraint_forces
from kinolab.dynamics.javascript.facts import as_json, facts_of
from kinolab.dynamics.javascript.functions import emit_function
from kinolab.dynamics.javascript.posing import posing
from kinolab.dynamics.language.feedback import Feedback
from kinolab.dynamics.language.shapes import Hull, Shape
from kinolab.dynamics.language.shapes.hulls import hull_surface
from kinolab.dynamics.model.model import Model
from kinolab.dynamics.symbols.expressions import exact

EMITTED = (
    *("f", "frames", "cables", "energy", "constraint_residual", "constraint_forces"),
    *("requirements", "project"),
)


def emitted_module(model: Model, runtime: str, *, implicit: bool) -> str:
    """Return a machine's JavaScript after what all machines share, as ``javascript_of``."""
    system = model.system
    if system.modes:
        modes = derive_modes(system)
        machines = ",\n".join(_mode(model, mode, implicit=implicit) for mode in modes)
        result = f"return switching([{machines}]);"
    else:
        d = derive(system)
        result = _assembled(model, d, [*_of_machine(d, model, implicit)])
    return "\n".join(["(() => {", '"use strict";', runtime, result, "})()"])


def _assembled(model: Model, d: Derivation, functions: Sequence[Function], **facts: Any) -> str:
    """Return statements that return a machine: its functions and what is known of it."""
    (constraints, holding), (shapes, dimensions) = constraint_forces(d), body_sizes(d.binding)
    posed, placing = posing(d)
    functions = [*functions, *holding, dimensions, *placing]
    sizes = {function.name: len(function.outputs) for function in functions}
    facts |= facts_of(model, d)
    facts |= {"sizes": sizes, "constraints": constraints, "shapes": shapes, **posed}
    names = ", ".join(function.name for function in functions)
    return "\n".join(
        [
            *(emit_function(function, d.binding.tape) for function in functions),
            f"return assemble({as_json(facts)}, {{ {names} }});",
        ]
    )


def _mode(model: Model, mode: ModeDerivation, *, implicit: bool) -> str:
    """Return the machine of one mode as an expression, with what ends the mode."""
    d = mode.derivation
    switches = (Function(name, d.arguments, nodes) for name, nodes in mode.switches.items())
    functions = [*_of_machine(d, model, implicit), *switches]
    names = [c.name for c in model.system.all_constraints]
    places = [names.index(c.name) for c in d.binding.system.constraints]
    text = _assembled(model, d, functions, targets=mode.targets, places=places)
    return f"(() => {{\n{text}\n}})()"


def _of_machine(derivation: Derivation, model: Model, implicit: bool) -> Iterator[Function]:
    """Yield the machine's functions with nonempty results, and its feedback law."""
    yield from (f for f in outputs_of(derivation) if f.name in EMITTED and f.outputs)
    if implicit:
        f = Function("tangent", derivation.arguments, derivation.derivative)
        yield tangent_of(derivation.binding.tape, f)
    law = model.system.feedback
    if isinstance(law, Feedback):
        yield law_of(derivation, law)


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
