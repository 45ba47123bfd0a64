"""A machine as CasADi functions, for optimal control with CasADi, acados or rockit."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from kinolab.dynamics.codegen.exports import Function
from kinolab.dynamics.derivation.expression_graph import (
    ARITHMETIC,
    UNARY,
    ExpressionGraph,
    Node,
)
from kinolab.dynamics.model.model import Model
from kinolab.dynamics.translation.translated import translated
from kinolab.lazy import library_of


@dataclass(frozen=True)
class CasadiFunctions:
    """Functions of states x (nx,), inputs u (nu,) and parameters p (np,), as ``casadi.Function``.

    Attributes:
        f: (x, u, p) to the derivative of the state.
        step: (x, u, h, p) to the state after h [s] of Runge and Kutta's method.
        jacobian: (x, u, p) to the derivatives of f by x and by u.
        energy: (x, u, p) to kinetic and potential energy in [J].
        frames: (x, p) to the poses of all bodies, rows of [R | p] one after the other.
        p: Default parameters.
    """

    f: Any
    step: Any
    jacobian: Any
    energy: Any
    frames: Any
    p: tuple[float, ...]


def casadi_functions(model: Model) -> CasadiFunctions:
    """Return a machine's equations of motion as CasADi functions, from the same expressions.

    Raises:
        InputError: If the machine has modes or feedback, or CasADi is not installed.
    """
    casadi = library_of("casadi", "casadi", "equations for CasADi need CasADi")
    graph, functions = translated(model)
    made = {name: _made(casadi, graph, function) for name, function in functions.items()}
    (x, u, p), (slope,) = made["f"]
    f = casadi.Function("f", [x, u, p], [slope], ["x", "u", "p"], ["x_dot"])
    by_x, by_u = casadi.jacobian(slope, x), casadi.jacobian(slope, u)
    names = ["x", "u", "p"]
    derivatives = casadi.Function("jacobian", [x, u, p], [by_x, by_u], names, ["by_x", "by_u"])
    (at, of_inputs, of), (energy,) = made["energy"]
    (where, given), (frames,) = made["frames"]
    defaults = dict(model.machine.parameters)
    return CasadiFunctions(
        f,
        _step(casadi, f, x, u, p, made.get("project")),
        derivatives,
        casadi.Function("energy", [at, of_inputs, of], [energy], names, ["energy"]),
        casadi.Function("frames", [where, given], [frames], ["x", "p"], ["frames"]),
        tuple(defaults[name] for name in model.parameter_names),
    )


def _step(casadi: Any, f: Any, x: Any, u: Any, p: Any, project: Any) -> Any:
    """Return a step of Runge and Kutta's method, moved back onto the constraints."""
    h = casadi.SX.sym("h")
    k1 = f(x, u, p)
    k2 = f(x + h / 2 * k1, u, p)
    k3 = f(x + h / 2 * k2, u, p)
    k4 = f(x + h * k3, u, p)
    after = x + h * (k1 + 2 * k2 + 2 * k3 + k4) / 6
    if project is not None:
        (at, given), (landed,) = project
        land = casadi.Function("project", [at, given], [landed])
        after = land(land(after, p), p)  # the second Newton step reaches rounding
    return casadi.Function("step", [x, u, h, p], [after], ["x", "u", "h", "p"], ["x_next"])


def _made(casadi: Any, graph: ExpressionGraph, function: Function) -> tuple[list[Any], list[Any]]:
    """Return a function's arguments as symbols, and its results as expressions of them."""
    arguments = {
        name: casadi.SX.sym(name, len(nodes)) for name, nodes in function.arguments.items()
    }
    entries: dict[Node, Any] = {
        node: arguments[name][k]
        for name, nodes in function.arguments.items()
        for k, node in enumerate(nodes)
    }

    def leaf(node: Node) -> Any:
        return entries[node] if node in entries else casadi.SX(graph.operations[node].value)

    # fmax, sin, …: CasADi has the names of C
    functions = {name: getattr(casadi, name) for name in (*UNARY, "fmax")} | ARITHMETIC
    results = casadi.vertcat(*graph.folded(function.outputs, leaf, functions))
    return list(arguments.values()), [results]
