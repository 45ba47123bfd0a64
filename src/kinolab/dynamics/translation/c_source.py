"""A machine as C99 source without dependencies but the standard library's mathematics.

The functions allocate nothing, call nothing of one another but what is in the file, and have one
exit; the same numbers go in and come out on every computer whose doubles are IEEE 754's.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from kinolab.dynamics.codegen.exports import OPERATORS, Function, tangent_of
from kinolab.dynamics.codegen.methods import RK4
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node, Operation
from kinolab.dynamics.model import Model
from kinolab.dynamics.translation.translated import translated
from kinolab.errors import NoDynamicsError
from kinolab.numerics.arrays import Array

OWN = ("project", "tangent")  # functions that are called in the file alone
AGREE = 1e-12  # relative, of the test
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
    guard, defaults = f"{name.upper()}_H", dict(model.machine.parameters)
    signatures = [f"{_signature(name, function)};" for function in functions]
    return "\n".join(
        [
            f"/* Equations of motion of {name}, derived by kinolab. Units are SI. */",
            f"#ifndef {guard}",
            f"#define {guard}",
            "",
            *(
                f"#define {name.upper()}_{what} {count}"
                for what, count in (
                    ("NX", model.nx),
                    ("NU", model.nu),
                    ("NP", len(model.parameter_names)),
                    *((f.name.upper(), len(f.outputs)) for f in functions if f.name != "f"),
                )
            ),
            "",
            "/* x: " + ", ".join(model.state_names),
            "   u: " + ", ".join(model.control_names),
            "   p: " + ", ".join(f"{k} = {defaults[k]!r}" for k in model.parameter_names),
            "   A function returns 0; 1 where the state is singular; 2 where a result is not",
            "   finite. The Jacobian of f has a column for each x, then one for each u; the mass",
            f"   matrix is that of {', '.join(model.rate_names)}. */",
            "#ifdef __cplusplus",
            'extern "C" {',
            "#endif",
            f"extern const double {name}_p[];  /* default parameters */",
            *signatures,
            f"{_step_signature(name)};",
            "#ifdef __cplusplus",
            "}",
            "#endif",
            "",
            f"#endif /* {guard} */",
            "",
        ]
    )


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
    defaults = dict(model.machine.parameters)
    numbers = ", ".join(number(defaults[key]) for key in model.parameter_names) or "0.0"
    pieces = [
        f'#include "{name}.h"',
        "#include <math.h>",
        "#include <stddef.h>",
        "",
        f"const double {name}_p[] = {{{numbers}}};",
        "",
        HELPERS,
    ]
    for key, function in functions.items():
        kind = "static " if key in OWN else ""
        pieces.append(kind + _function(name, graph, function))
    pieces.append(_jacobian(name, model.nx, model.nu))
    pieces.append(_step(name, model.nx, projects="project" in functions))
    return "\n".join(pieces)


HELPERS = """static int all_finite(const double values[], size_t count) {
    int found = 1;
    for (size_t i = 0; i < count; ++i) {
        if (!isfinite(values[i])) {
            found = 0;
        }
    }
    return found;
}

static inline double sign(double value) {
    return (double)((value > 0.0) - (value < 0.0));
}
"""


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


def _jacobian(name: str, nx: int, nu: int) -> str:
    """Return all derivatives of f, a call of its tangent for each column."""
    arguments = "const double x[], const double u[], const double p[], double out[]"
    return f"""int {name}_jacobian({arguments}) {{
    enum {{ N = {nx}, COLUMNS = {nx + nu} }};
    double along[COLUMNS] = {{0.0}};
    int status = 0;
    for (size_t k = 0; (k < COLUMNS) && (status == 0); ++k) {{
        along[k] = 1.0;
        status = {name}_tangent(x, u, p, along, along + N, out + (k * N));
        along[k] = 0.0;
    }}
    return status;
}}
"""


def _step(name: str, nx: int, *, projects: bool) -> str:
    """Return a step of Runge and Kutta's method, as kinolab makes it."""
    landing = (
        [
            "if (status == 0) {",
            f"    status = {name}_project(total, p, at);",
            "}",
            "if (status == 0) { /* the second Newton step reaches rounding */",
            f"    status = {name}_project(at, p, out);",
            "}",
        ]
        if projects
        else [
            "for (size_t i = 0; i < N; ++i) {",
            "    out[i] = total[i];",
            "}",
            "if ((status == 0) && !all_finite(out, N)) {",
            "    status = 2;",
            "}",
        ]
    )
    fractions = ", ".join(number(sum(row)) for row in RK4.a)  # each stage rests on the last one
    weights = ", ".join(map(number, RK4.b))
    lines = [
        f"enum {{ N = {nx} }};",
        f"static const double fractions[{RK4.stages}] = {{{fractions}}};",
        f"static const double weights[{RK4.stages}] = {{{weights}}};",
        "double at[N];",
        "double slope[N] = {0.0};",
        "double total[N];",
        "int status = 0;",
        "for (size_t i = 0; i < N; ++i) {",
        "    total[i] = x[i];",
        "}",
        f"for (size_t stage = 0; (stage < {RK4.stages}U) && (status == 0); ++stage) {{",
        "    for (size_t i = 0; i < N; ++i) {",
        "        at[i] = x[i] + (h * fractions[stage]) * slope[i];",
        "    }",
        f"    status = {name}_f(at, u, p, slope);",
        "    for (size_t i = 0; i < N; ++i) {",
        "        total[i] = total[i] + (h * weights[stage]) * slope[i];",
        "    }",
        "}",
        *landing,
        "return status;",
    ]
    inside = "\n".join(f"    {line}" for line in lines)
    return f"{_step_signature(name)} {{\n{inside}\n}}\n"


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
    return "\n".join(
        [
            f'#include "{name}.h"',
            "#include <math.h>",
            "#include <stdio.h>",
            "",
            "static int failures = 0;",
            "",
            "static void compare(int status, const double found[], const double wanted[],",
            "                    int count, const char *what) {",
            "    double largest = 1.0;",
            "    for (int i = 0; i < count; ++i) {",
            "        largest = fmax(largest, fabs(wanted[i]));",
            "    }",
            "    for (int i = 0; i < count; ++i) {",
            "        const double gap = fabs(found[i] - wanted[i]);",
            f"        if ((status != 0) || !(gap <= {AGREE!r} * largest)) {{",
            '            (void)printf("%s, entry %d: %.17g, not %.17g\\n", what, i, found[i],',
            "                         wanted[i]);",
            "            failures = failures + 1;",
            "        }",
            "    }",
            "}",
            "",
            "int main(void) {",
            f"    double out[{size}];",
            *checks,
            '    (void)printf("%d differences\\n", failures);',
            "    return (failures == 0) ? 0 : 1;",
            "}",
            "",
        ]
    )


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
