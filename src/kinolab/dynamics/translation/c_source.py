"""A machine as C99 source without dependencies but the standard library's mathematics.

The functions allocate nothing, call nothing of one another but what is in the file, and have one
exit; the same numbers go in and come out on every computer whose doubles are IEEE 754's.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.resources import files
from string import Template

import numpy as np

from kinolab.dynamics.codegen.exports import OPERATORS, Function, tangent_of
from kinolab.dynamics.codegen.methods import RK4
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node, Operation
from kinolab.dynamics.model.model import Model
from kinolab.dynamics.translation.translated import translated
from kinolab.errors import NoDynamicsError
from kinolab.numerics.arrays import Array

OWN = ("project", "tangent")  # functions that are called in the file alone
STEP = 0.01  # [s] of the test


def c_source(model: Model) -> dict[str, str]:
    """Return a machine's equations of motion in C: header, source and a test, by file name.

    ``NAME_f``, ``NAME_jacobian``, ``NAME_step`` (Runge and Kutta's method), ``NAME_mass_matrix``,
    ``NAME_energy`` and ``NAME_frames`` write into their last argument and return 0, 1 where the
    state is singular, 2 where a result is not finite. C++ may include the header. The test compares
    them with what kinolab's own machine code gives.

    Raises:
        InputError: If the machine has modes or feedback.
    """
    graph, functions = translated(model)
    name = re.sub(r"\W", "_", model.machine.name, flags=re.ASCII)
    f = functions["f"]
    functions["tangent"] = replace(tangent_of(graph, f), name="tangent", guards=f.guards)
    jacobian = replace(
        f, name="jacobian", outputs=tuple(f.outputs) * (model.nx + model.nu), guards=()
    )
    exported = [jacobian, *(entry for key, entry in functions.items() if key not in OWN)]
    head = _header(name, model, exported)
    body = _source(name, model, graph, functions)
    return {f"{name}.h": head, f"{name}.c": body, f"{name}_test.c": _test(name, model)}


def _header(name: str, model: Model, functions: Sequence[Function]) -> str:
    defaults = dict(model.machine.parameters)
    sizes = {"NX": model.nx, "NU": model.nu, "NP": len(model.parameter_names)}
    sizes |= {f.name.upper(): len(f.outputs) for f in functions if f.name != "f"}
    signatures = [*(_signature(name, function) for function in functions), _step_signature(name)]
    return _filled(
        "machine.h",
        name=name,
        upper=name.upper(),
        sizes="\n".join(f"#define {name.upper()}_{what} {count}" for what, count in sizes.items()),
        states=", ".join(model.state_names),
        inputs=", ".join(model.control_names),
        parameters=", ".join(f"{k} = {defaults[k]!r}" for k in model.parameter_names),
        rates=", ".join(model.rate_names),
        signatures="\n".join(f"{signature};" for signature in signatures),
    )


def _filled(template: str, **values: object) -> str:
    """Return a file of the folder ``c`` with values in place of names after ``$``."""
    text = files("kinolab.dynamics.translation").joinpath("c", template).read_text("utf-8")
    return Template(text).substitute(values)


def _signature(name: str, function: Function) -> str:
    arguments = ", ".join(f"const double {array}[]" for array in function.arguments)
    return f"int {name}_{function.name}({arguments}, double out[])"


def _step_signature(name: str) -> str:
    return (
        f"int {name}_step(const double x[], const double u[], const double p[], double h, "
        "double out[])"
    )


def _source(
    name: str, model: Model, graph: ExpressionGraph, functions: Mapping[str, Function]
) -> str:
    """Return the functions; the step is Runge and Kutta's, as kinolab makes it."""
    defaults = dict(model.machine.parameters)
    pieces = [
        f"{'static ' if key in OWN else ''}{_function(name, graph, function)}"
        for key, function in functions.items()
    ]
    landing = "projected.c" if "project" in functions else "unprojected.c"
    return _filled(
        "machine.c",
        name=name,
        numbers=", ".join(number(defaults[key]) for key in model.parameter_names) or "0.0",
        functions="\n".join(pieces),
        nx=model.nx,
        columns=model.nx + model.nu,
        step=_step_signature(name),
        stages=RK4.stages,
        fractions=", ".join(number(sum(row)) for row in RK4.a),  # each stage rests on the last one
        weights=", ".join(map(number, RK4.b)),
        landing=_filled(landing, name=name).rstrip("\n"),
    )


def _function(name: str, graph: ExpressionGraph, function: Function) -> str:
    text: dict[Node, str] = {
        node: f"{array}[{k}]"
        for array, nodes in function.arguments.items()
        for k, node in enumerate(nodes)
    }
    lines = [f"(void){array};" for array in function.arguments]
    for node in graph.needed((*function.outputs, *function.guards)):
        if node in text:
            continue
        operation = graph.operations[node]
        if operation.name == "const":
            text[node] = number(operation.value)
            continue
        expression = _expression(operation, [text[operand] for operand in operation.operands])
        lines.append(f"const double v{node} = {expression};")
        text[node] = f"v{node}"
    lines += [f"out[{k}] = {text[node]};" for k, node in enumerate(function.outputs)]
    lines.append(f"int status = all_finite(out, {len(function.outputs)}U) ? 0 : 2;")
    if function.guards:
        valid = " && ".join(f"({text[guard]} > 0.0)" for guard in function.guards)
        lines += [f"if (!({valid})) {{", "    status = 1;", "}"]
    lines.append("return status;")
    inside = "\n".join(f"    {line}" for line in lines)
    return f"{_signature(name, function)} {{\n{inside}\n}}\n"


def _expression(operation: Operation, operands: Sequence[str]) -> str:
    if operation.name in OPERATORS:
        return f"{operands[0]} {OPERATORS[operation.name]} {operands[1]}"
    if operation.name == "neg":
        return f"-{operands[0]}"
    return f"{operation.name}({', '.join(operands)})"


def number(value: float) -> str:
    """Return a number as C reads it back exactly."""
    text = repr(float(value))
    return f"({text})" if value < 0 else text


def _test(name: str, model: Model) -> str:
    """Return a program that compares the functions with results of kinolab's machine code."""
    generator = np.random.default_rng(0)
    low, high = np.clip(model.state_bounds, -1.0, 1.0).T
    checks: list[str] = []
    for k in range(5):  # states of the test
        x: Array = generator.uniform(low, np.maximum(high, low + 1e-6))
        for _ in range(8):  # onto closed loops, from anywhere
            x = model.project(x)
        u = np.asarray(generator.uniform(*model.control_bounds.T))
        checks += [
            "    {",
            f"        const double x[] = {_array(x)};",
            f"        const double u[] = {_array(u)};",
            *_compared(f"{name}_f(x, u, {name}_p, out)", model.f(x, u), f"f {k}"),
            *_compared(
                f"{name}_step(x, u, {name}_p, {STEP!r}, out)",
                model.step(x, u, STEP),
                f"step {k}",
            ),
            *_compared(f"{name}_jacobian(x, u, {name}_p, out)", _columns(model, x, u), f"jac {k}"),
            *_mass_compared(name, model, x, k),
            *_compared(f"{name}_frames(x, {name}_p, out)", model.frames(x).ravel(), f"frames {k}"),
            "    }",
        ]
    size = max(model.nx * (model.nx + model.nu), model.nt**2, model.frames(model.rest()).size)
    return _filled("machine_test.c", name=name, size=size, checks="\n".join(checks))


def _columns(model: Model, x: Array, u: Array) -> Array:
    return np.hstack(model.jacobian(x, u)).T.ravel()


def _mass_compared(name: str, model: Model, x: Array, k: int) -> Iterator[str]:
    try:
        mass = model.mass_matrix(x)
    except NoDynamicsError:
        return
    yield from _compared(f"{name}_mass_matrix(x, {name}_p, out)", mass.ravel(), f"mass {k}")


def _compared(call: str, wanted: Array, what: str) -> Iterator[str]:
    yield f"        {{ const double wanted[] = {_array(wanted)};"
    yield f"          const int status = {call};"
    yield f'          compare(status, out, wanted, {wanted.size}, "{what}"); }}'


def _array(values: Array) -> str:
    return (
        "{" + ", ".join(number(value) for value in np.ravel(values)) + "}"
        if values.size
        else "{0.0}"
    )
