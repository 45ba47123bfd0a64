"""A machine's JavaScript as one expression, cached on disk with its machine code."""

from __future__ import annotations

from functools import cache
from pathlib import Path

from kinolab.dynamics.model.model import Model
from kinolab.store import Kind

TEXT: Kind[str] = Kind("js", str.encode, lambda content: bytes(content).decode())
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
        implicit: Whether ``step`` offers implicit methods, whose derivatives double the
            length of the text.
    """

    def emitted() -> str:
        from kinolab.dynamics.javascript.emitted_module import emitted_module  # late: it derives

        return emitted_module(model, _runtime(), implicit=implicit)

    # the model's key stands for the code here, too
    return TEXT.get([model.key, str(implicit), _runtime()], emitted)


@cache
def _runtime() -> str:
    return "\n".join((RUNTIME / f"{part}.js").read_text(encoding="utf-8") for part in PARTS)
