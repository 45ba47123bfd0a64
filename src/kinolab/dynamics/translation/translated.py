"""Which functions of a machine are translated."""

from __future__ import annotations

from kinolab.dynamics.codegen.exports import Function, outputs_of
from kinolab.dynamics.derivation.derivation import derive
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.dynamics.model.model import Model
from kinolab.errors import InputError, Mistake

TRANSLATED = ("f", "frames", "energy", "mass_matrix", "project")


def translated(model: Model) -> tuple[ExpressionGraph, dict[str, Function]]:
    """Return the graph of a machine's expressions, and the functions that are translated, by name.

    There is ``project`` only where steps leave the constraints.

    Raises:
        InputError: If it has modes, whose transitions are no functions of a state, or feedback.
    """
    if model.machine.modes or model.machine.references is not None:
        has = "modes" if model.machine.modes else "feedback"
        what = f"it has {has}, which is not translated."
        remedy = "Translate its plant: with_feedback(None)." if has == "feedback" else ""
        raise InputError([Mistake(f"system {model.machine.name!r}", what, remedy)])
    derivation = derive(model.system)
    functions = {f.name: f for f in outputs_of(derivation) if f.name in TRANSLATED and f.outputs}
    return derivation.binding.tape, functions
