"""A machine's JavaScript as one expression, cached on disk with its machine code."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from kinolab.dynamics.codegen.cache import code_in, folder
from kinolab.dynamics.codegen.closed_loop import law_of
from kinolab.dynamics.codegen.exports import Function, outputs_of, tangent_of
from kinolab.dynamics.derivation.derivation import Derivation, derive
from kinolab.dynamics.javascript.body_sizes import body_sizes
from kinolab.dynamics.javascript.constraint_forces import constraint_forces
from kinolab.dynamics.javascript.facts import as_json, facts_of
from kinolab.dynamics.javascript.functions import emit_function
from kinolab.dynamics.language.feedback import Feedback
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.dynamics.model import Model
from kinolab.files import read_sealed, write_sealed

MAGIC = b"kinolab javascript 1\n"
RUNTIME = Path(__file__).parent / "runtime"  # shared by all machines
PARTS = ("basics", "linear_algebra", "steps", "lines_of_action", "arrows", "shapes", "machine")
EMITTED = (
    *("f", "frames", "cables", "energy", "constraint_residual", "constraint_forces"),
    *("requirements", "project"),
)


def javascript_of(model: Model, *, implicit: bool = False) -> str:
    """Return a JavaScript expression whose value simulates a machine in float64.

    The value mirrors ``Model``: ``f(x, u, p)``, ``step(x, u, dt, p, method, substeps)``,
    ``frames(x, p)``, ``energy(x, u, p)``, ``constraintForces(x, u, p)``, … with ``p`` the array of
    parameters in the order of ``parameters``; where the machine has feedback, u are references and
    ``plant`` is the machine without it. See ``runtime/machine.js`` for the rest.

    Args:
        model: Provides the equations; a cached result is returned without deriving.
        implicit: Whether ``step`` offers the method ``rosenbrock``, whose derivatives double the
            length of the text.
    """
    path = folder() / f"{_key(model, implicit)}.js"
    kept = read_sealed(path, MAGIC)
    if kept is not None:
        return bytes(kept).decode()
    text = _written(model, implicit)
    write_sealed(path, MAGIC, text.encode())
    return text


def _written(model: Model, implicit: bool) -> str:
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
            _runtime(),
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


def _key(model: Model, implicit: bool) -> str:
    parts = (machine_to_json(model.system), str(implicit), _own_code())
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


@cache
def _own_code() -> str:
    return code_in(Path(__file__).parents[1]) + _runtime()


@cache
def _runtime() -> str:
    return "\n".join((RUNTIME / f"{part}.js").read_text(encoding="utf-8") for part in PARTS)
