"""From a derivation to the text of a machine's JavaScript."""

from __future__ import annotations

from collections.abc import Iterator

from kinolab.dynamics.codegen.closed_loop import law_of
from kinolab.dynamics.codegen.exports import Function, outputs_of, tangent_of
from kinolab.dynamics.derivation.derivation import Derivation, derive
from kinolab.dynamics.javascript.body_sizes import body_sizes
from kinolab.dynamics.javascript.constraint_forces import constraint_forces
from kinolab.dynamics.javascript.facts import as_json, facts_of
from kinolab.dynamics.javascript.functions import emit_function
from kinolab.dynamics.language.feedback import Feedback
from kinolab.dynamics.model import Model

EMITTED = (
    *("f", "frames", "cables", "energy", "constraint_residual", "constraint_forces"),
    *("requirements", "project"),
)


def emitted_module(model: Model, runtime: str, *, implicit: bool) -> str:
    """Return a machine's JavaScript after what all machines share, as ``javascript_of``."""
    system = model.system
    d = derive(system)
    holding, shapes = constraint_forces(system, d), body_sizes(system, d.binding)
    functions = [*_of_machine(d, model, implicit), *holding.functions, shapes.function]
    sizes = {function.name: len(function.outputs) for function in functions}
    facts = facts_of(model, d) | {
        "sizes": sizes,
        "constraints": holding.facts,
        "shapes": shapes.facts,
    }
    names = ", ".join(function.name for function in functions)
    return "\n".join(
        [
            "(() => {",
            '"use strict";',
            runtime,
            *(emit_function(function, d.binding.tape) for function in functions),
            f"return assemble({as_json(facts)}, {{ {names} }});",
            "})()",
        ]
    )


def _of_machine(derivation: Derivation, model: Model, implicit: bool) -> Iterator[Function]:
    """Yield the machine's functions with nonempty results, and its feedback law."""
    yield from (f for f in outputs_of(derivation) if f.name in EMITTED and f.outputs)
    if implicit:
        yield tangent_of(derivation)
    law = model.system.feedback
    if isinstance(law, Feedback):
        yield law_of(derivation, model.system, law)
