"""Which functions of a machine are translated."""

from __future__ import annotations

from typing import NamedTuple

from kinolab.dynamics.codegen.exports import Function, outputs_of
from kinolab.dynamics.derivation.derivation import derive
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.dynamics.model import Model
from kinolab.errors import InputError, Mistake

TRANSLATED = ("f", "frames", "energy", "project")


class Translated(NamedTuple):
    """Functions of a machine and the graph of their expressions."""

    graph: ExpressionGraph
    functions: dict[str, Function]  # ``project`` only where steps leave the constraints


def translated(model: Model) -> Translated:
    """Return what is translated of a machine.

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
    return Translated(derivation.binding.tape, functions)
