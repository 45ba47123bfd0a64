"""What is emitted of a derived machine, whatever the language: functions as nodes of its tape."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from kinolab.dynamics.codegen.compiled_functions import NEED_CHART
from kinolab.dynamics.derivation.cancellation import Cancellation
from kinolab.dynamics.derivation.derivation import Derivation
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node

OPERATORS = {"add": "+", "sub": "-", "mul": "*", "div": "/"}  # of C and of JavaScript
STATE_ONLY = ("frames", "cables", "mass_matrix", "project")


@dataclass(frozen=True)
class Function:
    """A function of numbers.

    Attributes:
        name: What code calls it.
        arguments: The variables of each array that it takes, by the array's name.
        outputs: What it computes.
        guards: Each must be positive for that to be valid.
    """

    name: str
    arguments: Mapping[str, Sequence[Node]]
    outputs: Sequence[Node]
    guards: Sequence[Node] = ()


def results_of(d: Derivation) -> dict[str, Sequence[Node]]:
    """Return what follows from a state beside f, by the name of the function that gives it."""
    return {
        "velocity": d.velocities,
        "flow": d.flow,
        "frames": d.frames,
        "cables": d.cables,
        "point_speed": d.point_speeds,
        "cable_speed": d.cable_speeds,
        "energy": d.energy,
        "power": d.power,
        "mass_matrix": d.mass_matrix,
        "constraint_residual": d.constraint_residual,
        "constraint_forces": d.constraint_forces,
        "requirements": d.requirements,
        "project": d.projection,
    }


def outputs_of(derivation: Derivation) -> Iterator[Function]:
    """Yield f and everything else that follows from a state, what cancels out left out."""
    d, arguments = derivation, derivation.arguments
    short = Cancellation(d.binding.tape).rewritten
    yield Function("f", arguments, short(d.derivative), short(d.guards))
    for name, nodes in results_of(d).items():
        taken = {k: v for k, v in arguments.items() if k != "u" or name not in STATE_ONLY}
        guards = short(d.chart_guards) if name in NEED_CHART else ()
        yield Function(name, taken, short(nodes), guards)


def tangent_of(tape: ExpressionGraph, function: Function) -> Function:
    """Return the derivative of a function along a direction of all arguments but parameters.

    It takes the directions dx of x and du of u after those arguments.
    """
    varying = {key: nodes for key, nodes in function.arguments.items() if key != "p"}
    seeds = {n: tape.variable(f"d {tape.operations[n].label}") for k in varying for n in varying[k]}
    along = {f"d{key}": [seeds[node] for node in nodes] for key, nodes in varying.items()}
    outputs = tape.derivative(function.outputs, seeds)
    return Function(function.name, {**function.arguments, **along}, outputs)
