"""LLVM IR for a derived machine: plain C functions, no allocation, nonzero return is failure.

The interface, the same for every machine, so that one compiled loop serves them all:

    int f(const double *x, const double *u, const double *p, double *dx, long mode)
    int step_METHOD(const double *x, const double *u, const double *p, double h, double *out, long)
    int frames(const double *x, const double *p, double *out, long mode)     12 numbers per body
    int point_speed(const double *x, const double *u, const double *p, double *out, long mode)
    int cables(const double *x, const double *p, double *out, long mode)     6 numbers per cable
    int cable_speed(const double *x, const double *u, const double *p, double *out, long mode)
    int frames_jacobian(const double *x, const double *p, double *out, long mode)   a column per x
    int difference, retract: see state_space.py

Of f, project and the explicit steps there are twins in lanes, NAME_lanes: x, u and out hold LANES
states, inputs and results, entry by entry; bit k of what they return is set where lane k failed.

A machine without modes ignores ``mode``. Failure is a singular or a non-finite result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from kinolab.dynamics.codegen.compiled_functions import NOT_FINITE, SINGULAR
from kinolab.dynamics.codegen.exports import Function, outputs_of, tangent_of
from kinolab.dynamics.codegen.integrators import LANES, emit_integrators, emit_linear_algebra
from kinolab.dynamics.codegen.llvm import Register, Routine, in_lanes, intrinsic, literal
from kinolab.dynamics.codegen.state_space import emit_space
from kinolab.dynamics.codegen.trigonometry import emit_sine_and_cosine, sine_and_cosine
from kinolab.dynamics.derivation.derivation import Derivation
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node

INTRINSICS = ("sin", "cos", "exp", "log", "sqrt", "fabs", "floor")
BINARY = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}


def emit_module(derivation: Derivation, *, lanes: bool = False) -> str:
    """Return the IR text of all functions of a machine, with or without those in lanes."""
    d, tape = derivation, derivation.binding.tape
    sizes = (len(d.state), len(d.binding.inputs))
    functions = list(outputs_of(d))
    wide = [
        emit_sine_and_cosine(LANES),
        *(_emitted(tape, f, LANES) for f in functions if f.name in ("f", "project")),
        *emit_integrators(d, LANES),
    ]
    tangent = tangent_of(tape, Function("tangent", d.arguments, d.derivative))
    of_state = {"x": d.state, "p": d.binding.parameters}
    frames_tangent = tangent_of(tape, Function("frames_tangent", of_state, d.frames))
    return "\n".join(
        [
            *declarations(),
            emit_sine_and_cosine(1),
            *(_emitted(tape, function) for function in (*functions, tangent)),
            emit_jacobian(*sizes, sizes[0]),
            *emit_linear_algebra(),
            *emit_integrators(d),
            *(wide if lanes else ()),
            emit_rows(sizes[0], None, name="rows_at"),
            emit_rows(*sizes, name="rows_under"),
            *emit_space(d.parts),
            emit_rows(sizes[0], sizes[0], name="rows_between"),
            _emitted(tape, frames_tangent),
            emit_jacobian(
                sizes[0], None, len(d.frames), name="frames_jacobian", tangent="frames_tangent"
            ),
        ]
    )


def _emitted(tape: ExpressionGraph, function: Function, lanes: int = 1) -> str:
    name = function.name + in_lanes(lanes)
    return emit_function(
        name, tape, function.arguments, function.outputs, function.guards, lanes=lanes
    )


def emit_function(
    name: str,
    tape: ExpressionGraph,
    arguments: Mapping[str, Sequence[Node]],
    outputs: Sequence[Node],
    guards: Sequence[Node] = (),
    *,
    lanes: int = 1,
) -> str:
    """Return one function that loads its arguments, computes, stores and reports failure."""
    parameters = [("ptr", argument) for argument in arguments]
    routine = Routine(name, [*parameters, ("ptr", "out"), ("i64", "mode")], lanes=lanes)
    where = {
        node: (f"%{argument}", index)
        for argument, nodes in arguments.items()
        for index, node in enumerate(nodes)
    }
    registers = _compute(routine, tape, where, (*outputs, *guards))
    results = [registers[node] for node in outputs]
    for index, result in enumerate(results):
        routine.store("%out", index, result)
    routine.give(_status(routine, results, [registers[node] for node in guards]))
    return routine.text()


def operations_of(derivation: Derivation) -> int:
    """Return the number of operations of the equations of motion."""
    d = derivation
    return len(d.binding.tape.needed([*d.derivative, *d.guards]))


def _compute(
    routine: Routine,
    tape: ExpressionGraph,
    where: Mapping[Node, tuple[str, int]],
    nodes: Sequence[Node],
) -> dict[Node, Register]:
    """Emit everything that nodes rest on, variables being entries of array arguments."""
    registers: dict[Node, Register] = {}
    waves: dict[Node, tuple[Register, Register]] = {}
    for node in tape.needed(nodes):
        operation = tape.operations[node]
        operands = [registers[operand] for operand in operation.operands]
        match operation.name:
            case "const":
                registers[node] = routine.constant(operation.value)
            case "variable":
                array, index = where[node]
                # "%p" is the argument that is the same in all lanes.
                load = routine.load_shared if array == "%p" else routine.load
                registers[node] = load(array, index)
            case "neg":
                registers[node] = routine.neg(operands[0])
            case "fmax":
                registers[node] = routine.intrinsic("maxnum", *operands)
            case "sign":
                registers[node] = _sign(routine, operands[0])
            case "sin" | "cos":
                angle = operation.operands[0]
                if angle not in waves:
                    waves[angle] = sine_and_cosine(routine, registers[angle])
                registers[node] = waves[angle][operation.name == "cos"]
            case name if name in BINARY:
                text = f"{BINARY[name]} contract {routine.number} {operands[0]}, {operands[1]}"
                registers[node] = routine.line(text)
            case name if name in INTRINSICS:
                registers[node] = routine.intrinsic(name, operands[0])
            case name:
                registers[node] = routine.library(name, operands[0])
    return registers


def _sign(routine: Routine, value: Register) -> Register:
    """Emit 1, 0 or -1."""
    above, below = (
        routine.line(
            f"uitofp {routine.truth} {routine.compare(order, value, routine.constant(0.0))}"
            f" to {routine.number}"
        )
        for order in ("ogt", "olt")
    )
    return routine.line(f"fsub {routine.number} {above}, {below}")


def _status(routine: Routine, results: Sequence[str], guards: Sequence[str]) -> Register:
    """Return SINGULAR where a guard is not positive, NOT_FINITE for NaN or infinity, else 0."""
    zero = routine.constant(0.0)
    total = zero
    for result in results:
        vanishing = routine.line(f"fmul {routine.number} {result}, {zero}")
        total = routine.line(f"fadd {routine.number} {total}, {vanishing}")
    finite = routine.compare("oeq", total, zero)
    positive = [routine.compare("ogt", guard, zero) for guard in guards]
    if routine.lanes > 1:  # bits that are set for lanes in which a condition does not hold
        good = finite
        for condition in positive:
            good = routine.line(f"and {routine.truth} {good}, {condition}")
        bits = routine.line(f"bitcast {routine.truth} {good} to i{routine.lanes}")
        bad = routine.line(f"xor i{routine.lanes} {bits}, -1")
        return routine.line(f"zext i{routine.lanes} {bad} to i32")
    status = routine.line(f"select i1 {finite}, i32 0, i32 {NOT_FINITE}")
    for holds in positive:
        status = routine.line(f"select i1 {holds}, i32 {status}, i32 {SINGULAR}")
    return status


def declarations() -> list[str]:
    """Return the declarations of what emitted functions call."""
    found = []
    for lanes in (1, LANES):
        number = Routine("", [], lanes=lanes).number
        found += [f"declare {number} @{intrinsic(name, lanes)}({number})" for name in INTRINSICS]
        found.append(f"declare {number} @{intrinsic('maxnum', lanes)}({number}, {number})")
    found.append("declare i1 @llvm.expect.i1(i1, i1)")
    return [*found, *(f"declare double @{name}(double)" for name in ("tan", "tanh", "atan"))]


def emit_jacobian(
    states: int,
    inputs: int | None,
    results: int,
    *,
    name: str = "jacobian",
    tangent: str = "tangent",
) -> str:
    """Return all derivatives of a function of states and inputs, a call of its tangent per column.

    int NAME(const double *x, *u, *p, double *out, long mode); out holds the columns of the
    derivative with respect to x, then those with respect to u, each as long as the result.
    Where the function has no inputs (None), there is no u.
    """
    own = ["x", "p"] if inputs is None else ["x", "u", "p"]
    routine = Routine(name, [*(("ptr", key) for key in (*own, "out")), ("i64", "mode")])
    size = states + (inputs or 0)
    seeds = routine.array(size)
    status = routine.cell("i32", "0")
    with routine.loop(0, size) as i:
        routine.store(seeds, i, literal(0.0))
    with routine.loop(0, size) as k:
        routine.store(seeds, k, literal(1.0))
        column = routine.at("%out", routine.integer("mul", k, results))
        given = [*(f"%{key}" for key in own), seeds]
        given += [] if inputs is None else [routine.at(seeds, states)]
        routine.merge(status, routine.call(f"@{tangent}", *given, column))
        routine.store(seeds, k, literal(0.0))
    routine.give(routine.get("i32", status))
    return routine.text()


def emit_rows(states: int, controls: int | None, *, name: str) -> str:
    """Return a loop of any function over rows; its result is the first failing row, or -1.

    Args:
        states: Length of x.
        controls: Length of u; None for functions that have no inputs.
    """
    tables = {"%x": states, **({} if controls is None else {"%u": controls})}
    pointers = [("ptr", name[1:]) for name in ("%function", *tables, "%p", "%out")]
    numbers = [("i64", name) for name in ("n", "size", "mode")]
    routine = Routine(name, [*pointers, *numbers], result="i64")
    worst = routine.cell("i64", "-1")
    with routine.loop(0, "%n") as i:
        given = [routine.at(a, routine.integer("mul", i, size)) for a, size in tables.items()]
        result = routine.at("%out", routine.integer("mul", i, "%size"))
        failed = routine.call("%function", *given, "%p", result)
        first = routine.line(f"icmp slt i64 {routine.get('i64', worst)}, 0")
        bad = routine.line(f"icmp ne i32 {failed}, 0")
        with routine.when(routine.line(f"and i1 {bad}, {first}")):
            routine.put("i64", worst, i)
    routine.give(routine.get("i64", worst))
    return routine.text()
