"""LLVM IR for a derived machine: plain C functions, no allocation, nonzero return is failure.

The interface, the same for every machine, so that one compiled loop serves them all:

    int f(const double *x, const double *u, const double *p, double *dx, long mode)
    int step_METHOD(const double *x, const double *u, const double *p, double h, double *out, long)
    int frames(const double *x, const double *p, double *out, long mode)     12 numbers per body
    int point_speed(const double *x, const double *u, const double *p, double *out, long mode)

A machine without modes ignores ``mode``. Failure is a singular or a non-finite result.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from itertools import count

from kinolab.dynamics.derivation import Derivation
from kinolab.dynamics.tape import Node, Tape

INTRINSICS = ("sin", "cos", "tan", "exp", "log", "sqrt", "fabs")
LIBRARY = ("tanh", "atan")
BINARY = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
METHODS = ("rk4", "euler")

SINGULAR, NOT_FINITE = 1, 2


def emit_module(derivation: Derivation) -> str:
    """Return the IR text of all functions of a machine."""
    d = derivation
    arguments = {"x": d.state, "u": d.inputs, "p": d.parameters}
    fixed = {"x": d.state, "p": d.parameters}
    functions = [
        emit_function("f", d.tape, arguments, d.derivative, d.guards),
        emit_function("velocity", d.tape, arguments, d.rates),
        emit_function("frames", d.tape, fixed, d.frames),
        emit_function("point_speed", d.tape, arguments, d.point_speeds),
        emit_function("energy", d.tape, fixed, d.energy),
        emit_function("mass_matrix", d.tape, fixed, d.mass_matrix),
        emit_function("constraint_residual", d.tape, arguments, d.constraint_residual),
        *(_emit_step(method, len(d.state)) for method in METHODS),
        _emit_batch(len(d.state), len(d.inputs)),
    ]
    return "\n".join([*_declarations(), *functions])


def emit_function(
    name: str,
    tape: Tape,
    arguments: Mapping[str, Sequence[Node]],
    outputs: Sequence[Node],
    guards: Sequence[Node] = (),
) -> str:
    """Return one function that loads its arguments, computes, stores and reports failure."""
    body = _Body(tape)
    for argument, nodes in arguments.items():
        body.bind(argument, nodes)
    results = [body.value(node) for node in outputs]
    for index, result in enumerate(results):
        body.store("out", index, result)
    body.check(results, [body.value(node) for node in guards])
    parameters = ", ".join(f"ptr noalias %{argument}" for argument in arguments)
    header = f"define i32 @{name}({parameters}, ptr noalias %out, i64 %mode) {{"
    return "\n".join([header, *body.lines, "}"])


class _Body:
    """The lines of one function."""

    def __init__(self, tape: Tape) -> None:
        self.tape = tape
        self.lines: list[str] = []
        self._names: dict[Node, str] = {}
        self._where: dict[Node, tuple[str, int]] = {}
        self._counter = count()

    def bind(self, argument: str, nodes: Sequence[Node]) -> None:
        """Say that variables are the entries of an array argument."""
        for index, node in enumerate(nodes):
            self._where[node] = (argument, index)

    def value(self, node: Node) -> str:
        """Return the register or constant that holds a node, emitting what it needs."""
        for needed in self.tape.needed([node]):
            if needed not in self._names:
                self._names[needed] = self._emit(needed)
        return self._names[node]

    def store(self, argument: str, index: int, value: str) -> None:
        """Write a value to an entry of an array argument."""
        address = self._line(f"getelementptr double, ptr %{argument}, i64 {index}")
        self.lines.append(f"  store double {value}, ptr {address}")

    def check(self, results: Sequence[str], guards: Sequence[str]) -> None:
        """Return SINGULAR where a guard is not positive, NOT_FINITE for NaN or infinity, else 0."""
        status = "0"
        total = literal(0.0)
        for result in results:
            vanishing = self._line(f"fmul double {result}, {literal(0.0)}")
            total = self._line(f"fadd double {total}, {vanishing}")
        finite = self._line(f"fcmp oeq double {total}, {literal(0.0)}")
        status = self._line(f"select i1 {finite}, i32 0, i32 {NOT_FINITE}")
        for guard in guards:
            holds = self._line(f"fcmp ogt double {guard}, {literal(0.0)}")
            status = self._line(f"select i1 {holds}, i32 {status}, i32 {SINGULAR}")
        self.lines.append(f"  ret i32 {status}")

    def _line(self, instruction: str) -> str:
        name = f"%v{next(self._counter)}"
        self.lines.append(f"  {name} = {instruction}")
        return name

    def _emit(self, node: Node) -> str:
        operation = self.tape.operations[node]
        operands = [self._names[operand] for operand in operation.operands]
        match operation.name:
            case "const":
                return literal(operation.value)
            case "variable":
                argument, index = self._where[node]
                address = self._line(f"getelementptr double, ptr %{argument}, i64 {index}")
                return self._line(f"load double, ptr {address}")
            case "neg":
                return self._line(f"fneg double {operands[0]}")
            case "fmax":
                pair = ", ".join(f"double {operand}" for operand in operands)
                return self._line(f"call double @llvm.maxnum.f64({pair})")
            case name if name in BINARY:
                return self._line(f"{BINARY[name]} contract double {operands[0]}, {operands[1]}")
            case name if name in INTRINSICS:
                return self._line(f"call double @{_intrinsic(name)}(double {operands[0]})")
            case name:
                return self._line(f"call double @{name}(double {operands[0]})")


def literal(value: float) -> str:
    """Return a double as LLVM's exact hexadecimal constant."""
    return f"0x{struct.unpack('<Q', struct.pack('<d', value))[0]:016X}"


def _intrinsic(name: str) -> str:
    return name if name == "tan" else f"llvm.{name}.f64"


def _declarations() -> list[str]:
    unary = [_intrinsic(name) for name in INTRINSICS] + list(LIBRARY)
    return [
        *(f"declare double @{name}(double)" for name in unary),
        "declare double @llvm.maxnum.f64(double, double)",
    ]


def _emit_step(method: str, size: int) -> str:
    """Return one integrator step; stage k runs from x + h a_k k_(k-1).

    Source: Hairer, Norsett, Wanner, Solving ODEs I, 2nd ed., section II.1.
    """
    stages, weights = {
        "rk4": ((0.0, 0.5, 0.5, 1.0), (1 / 6, 1 / 3, 1 / 3, 1 / 6)),
        "euler": ((0.0,), (1.0,)),
    }[method]
    lines = [
        f"define i32 @step_{method}"
        "(ptr noalias %x, ptr %u, ptr %p, double %h, ptr noalias %out, i64 %mode) {",
        *(f"  %k{s} = alloca [{size} x double]" for s in range(len(stages))),
        f"  %at = alloca [{size} x double]",
    ]
    number = count()

    def line(instruction: str) -> str:
        name = f"%v{next(number)}"
        lines.append(f"  {name} = {instruction}")
        return name

    def entry(array: str, index: int) -> str:
        return line(f"getelementptr double, ptr %{array}, i64 {index}")

    def load(array: str, index: int) -> str:
        return line(f"load double, ptr {entry(array, index)}")

    status = "0"
    for s, fraction in enumerate(stages):
        source = "x"
        if s:
            source = "at"
            reach = line(f"fmul double %h, {literal(fraction)}")
            for i in range(size):
                change = line(f"fmul contract double {reach}, {load(f'k{s - 1}', i)}")
                moved = line(f"fadd contract double {load('x', i)}, {change}")
                lines.append(f"  store double {moved}, ptr {entry('at', i)}")
        failed = line(f"call i32 @f(ptr %{source}, ptr %u, ptr %p, ptr %k{s}, i64 %mode)")
        status = line(f"or i32 {status}, {failed}")
    for i in range(size):
        total = load("x", i)
        for s, weight in enumerate(weights):
            share = line(f"fmul double %h, {literal(weight)}")
            change = line(f"fmul contract double {share}, {load(f'k{s}', i)}")
            total = line(f"fadd contract double {total}, {change}")
        lines.append(f"  store double {total}, ptr {entry('out', i)}")
    return "\n".join([*lines, f"  ret i32 {status}", "}"])


def _emit_batch(states: int, inputs: int) -> str:
    """Return a loop of f over rows; its result is the first failing row, or -1."""
    return f"""define i64 @f_batch(i64 %n, ptr %x, ptr %u, ptr %p, ptr %out, i64 %mode) {{
start:
  br label %next
next:
  %i = phi i64 [0, %start], [%after, %loop]
  %done = icmp sge i64 %i, %n
  br i1 %done, label %good, label %loop
loop:
  %xo = mul i64 %i, {states}
  %uo = mul i64 %i, {inputs}
  %xi = getelementptr double, ptr %x, i64 %xo
  %ui = getelementptr double, ptr %u, i64 %uo
  %oi = getelementptr double, ptr %out, i64 %xo
  %status = call i32 @f(ptr %xi, ptr %ui, ptr %p, ptr %oi, i64 %mode)
  %after = add i64 %i, 1
  %failed = icmp ne i32 %status, 0
  br i1 %failed, label %bad, label %next
good:
  ret i64 -1
bad:
  ret i64 %i
}}"""
