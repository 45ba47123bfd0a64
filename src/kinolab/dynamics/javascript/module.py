"""A machine's JavaScript as one expression, cached on disk with its machine code."""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

from kinolab.dynamics.codegen.cache import folder
from kinolab.dynamics.model import Model
from kinolab.files import read_sealed, write_sealed

MAGIC = b"kinolab javascript 1\n"
RUNTIME = Path(__file__).parent / "runtime"  # shared by all machines
PARTS = (
    *("basics", "linear_algebra", "steps", "lines_of_action", "arrows", "shapes"),
    *("machine", "modes"),
)


def javascript_of(model: Model, *, implicit: bool = False) -> str:
    """Return a JavaScript expression whose value simulates a machine in float64.

    The value mirrors ``Model``: ``f(x, u, p)``, ``step(x, u, dt, p, method, substeps)``,
    ``frames(x, p)``, ``energy(x, u, p)``, ``constraintForces(x, u, p)``, … with ``p`` the array of
    parameters in the order of ``parameters``; where the machine has feedback, u are references and
    ``plant`` is the machine without it; a machine with modes changes its mode on the way. See
    ``runtime/machine.js`` for the rest.

    Args:
        model: Provides the equations; a cached result is returned without deriving.
        implicit: Whether ``step`` offers the method ``rosenbrock``, whose derivatives double the
            length of the text.
    """
    path = folder() / f"{_key(model, implicit)}.js"
    kept = read_sealed(path, MAGIC)
    if kept is not None:
        return bytes(kept).decode()
    from kinolab.dynamics.javascript.emitted_module import emitted_module  # late: it derives

    text = emitted_module(model, _runtime(), implicit=implicit)
    write_sealed(path, MAGIC, text.encode())
    return text


def _key(model: Model, implicit: bool) -> str:
    parts = (model.key, str(implicit), _runtime())  # the first stands for the code here, too
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()


@cache
def _runtime() -> str:
    return "\n".join((RUNTIME / f"{part}.js").read_text(encoding="utf-8") for part in PARTS)
