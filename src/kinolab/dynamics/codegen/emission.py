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

A machine without modes ignores ``mode``. Failure is a singular or a non-finite result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from kinolab.dynamics.codegen.compiled_functions import NOT_FINITE, SINGULAR
from kinolab.dynamics.codegen.exports import Function, frames_tangent_of, outputs_of, tangent_of
from kinolab.dynamics.codegen.integrators import emit_integrators, emit_linear_algebra
from kinolab.dynamics.codegen.llvm import Register, Routine, literal
from kinolab.dynamics.codegen.state_space import emit_space
from kinolab.dynamics.derivation.derivation import Derivation
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node

INTRINSICS = ("sin", "cos", "exp", "log", "sqrt", "fabs", "floor")
LIBRARY = ("tan", "tanh", "atan")
BINARY = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}


def emit_module(derivation: Derivation) -> str:
    """Return the IR text of all functions of a machine."""
    d, tape = derivation, derivation.binding.tape
    sizes = (len(d.state), len(d.binding.inputs))
    return "\n".join(
        [
            *_declarations(),
            *(_emitted(tape, function) for function in outputs_of(d)),
            _emitted(tape, tangent_of(d)),
            emit_jacobian(*sizes, sizes[0]),
            *emit_linear_algebra(),
            *emit_integrators(*sizes, projects=bool(d.projection), attitudes=d.attitudes),
            emit_rows(sizes[0], None, name="rows_at"),
            emit_rows(*sizes, name="rows_under"),
            *emit_space(d.circular, d.attitudes),
            emit_rows(sizes[0], sizes[0], name="rows_between"),
            _emitted(tape, frames_tangent_of(d)),
            emit_jacobian(
                sizes[0], None, len(d.frames), name="frames_jacobian", tangent="frames_tangent"
            ),
        ]
    )


def _emitted(tape: ExpressionGraph, function: Function) -> str:
    return emit_function(function.name, tape, function.arguments, function.outputs, function.guards)


def emit_function(
    name: str,
    tape: ExpressionGraph,
    arguments: Mapping[str, Sequence[Node]],
    outputs: Sequence[Node],
    guards: Sequence[Node] = (),
) -> str:
    """Return one function that loads its arguments, computes, stores and reports failure."""
    parameters = [("ptr", argument) for argument in arguments]
    routine = Routine(name, [*parameters, ("ptr", "out"), ("i64", "mode")])
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


def _compute(
    routine: Routine,
    tape: ExpressionGraph,
    where: Mapping[Node, tuple[str, int]],
    nodes: Sequence[Node],
) -> dict[Node, Register]:
    """Emit everything that nodes rest on, variables being entries of array arguments."""
    registers: dict[Node, Register] = {}
    for node in tape.needed(nodes):
        operation = tape.operations[node]
        operands = [registers[operand] for operand in operation.operands]
        match operation.name:
            case "const":
                registers[node] = literal(operation.value)
            case "variable":
                registers[node] = routine.load(*where[node])
            case "neg":
                registers[node] = routine.line(f"fneg double {operands[0]}")
            case "fmax":
                pair = ", ".join(f"double {operand}" for operand in operands)
                registers[node] = routine.line(f"call double @llvm.maxnum.f64({pair})")
            case "sign":
                registers[node] = _sign(routine, operands[0])
            case name if name in BINARY:
                text = f"{BINARY[name]} contract double {operands[0]}, {operands[1]}"
                registers[node] = routine.line(text)
            case name:
                text = f"call double @{_symbol(name)}(double {operands[0]})"
                registers[node] = routine.line(text)
    return registers


def _sign(routine: Routine, value: Register) -> Register:
    """Emit 1, 0 or -1."""
    zero = literal(0.0)
    above, below = (
        routine.line(f"uitofp i1 {routine.line(f'fcmp {order} double {value}, {zero}')} to double")
        for order in ("ogt", "olt")
    )
    return routine.line(f"fsub double {above}, {below}")


def _status(routine: Routine, results: Sequence[str], guards: Sequence[str]) -> Register:
    """Return SINGULAR where a guard is not positive, NOT_FINITE for NaN or infinity, else 0."""
    zero = literal(0.0)
    total = zero
    for result in results:
        vanishing = routine.line(f"fmul double {result}, {zero}")
        total = routine.line(f"fadd double {total}, {vanishing}")
    finite = routine.line(f"fcmp oeq double {total}, {zero}")
    status = routine.line(f"select i1 {finite}, i32 0, i32 {NOT_FINITE}")
    for guard in guards:
        holds = routine.line(f"fcmp ogt double {guard}, {zero}")
        status = routine.line(f"select i1 {holds}, i32 {status}, i32 {SINGULAR}")
    return status


def _symbol(name: str) -> str:
    return f"llvm.{name}.f64" if name in INTRINSICS else name


def _declarations() -> list[str]:
    return [
        *(f"declare double @{_symbol(name)}(double)" for name in (*INTRINSICS, *LIBRARY)),
        "declare double @llvm.maxnum.f64(double, double)",
    ]


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
        listing = ", ".join(f"ptr {address}" for address in (*given, column))
        failed = routine.line(f"call i32 @{tangent}({listing}, i64 %mode)")
        so_far = routine.get("i32", status)
        routine.put("i32", status, routine.line(f"or i32 {so_far}, {failed}"))
        routine.store(seeds, k, literal(0.0))
    routine.give(routine.get("i32", status))
    return routine.text()


def emit_rows(states: int, controls: int | None, *, name: str) -> str:
    """Return a loop of any function over rows; its result is the first failing row, or -1.

    Args:
        states: Length of x.
        controls: Length of u; None for functions that have no inputs.
        name: Of the loop.
    """
    tables = {"%x": states, **({} if controls is None else {"%u": controls})}
    pointers = [("ptr", name[1:]) for name in ("%function", *tables, "%p", "%out")]
    numbers = [("i64", name) for name in ("n", "size", "mode")]
    routine = Routine(name, [*pointers, *numbers], result="i64")
    worst = routine.cell("i64", "-1")
    with routine.loop(0, "%n") as i:
        given = [routine.at(a, routine.integer("mul", i, size)) for a, size in tables.items()]
        result = routine.at("%out", routine.integer("mul", i, "%size"))
        listing = ", ".join(f"ptr {address}" for address in (*given, "%p", result))
        failed = routine.line(f"call i32 %function({listing}, i64 %mode)")
        first = routine.line(f"icmp slt i64 {routine.get('i64', worst)}, 0")
        bad = routine.line(f"icmp ne i32 {failed}, 0")
        with routine.when(routine.line(f"and i1 {bad}, {first}")):
            routine.put("i64", worst, i)
    routine.give(routine.get("i64", worst))
    return routine.text()
