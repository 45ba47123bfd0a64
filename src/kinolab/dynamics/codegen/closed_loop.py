"""LLVM IR for a machine with feedback: its functions again, of references instead of inputs.

    int law(const double *x, const double *r, const double *p, double *u, long mode)
    int closed_NAME(const double *x, const double *r, const double *p, …)

Each ``closed_`` function evaluates the law at the state that it is given and calls the machine's
own function with the inputs that come out. A step holds them to its end.
"""

from __future__ import annotations

from collections.abc import Sequence

from kinolab.dynamics.codegen.compiled_functions import PREFIX, RATES
from kinolab.dynamics.codegen.emission import emit_function, emit_jacobian, emit_rows
from kinolab.dynamics.codegen.exports import Function
from kinolab.dynamics.codegen.integrators import STEP, steppers
from kinolab.dynamics.codegen.llvm import Register, Routine
from kinolab.dynamics.derivation.derivation import Derivation
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph, Node
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.language.feedback import Feedback
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.errors import InputError, Mistake


def emit_closed_loop(derivation: Derivation, system: Mechanism, feedback: Feedback) -> str:
    """Return the IR text of what a law adds to a machine's functions.

    Raises:
        InputError: If the law rests on what it gives, or has a symbol of nothing.
    """
    binding = derivation.binding
    tape, states, inputs = binding.tape, len(derivation.state), len(binding.inputs)
    law = law_of(derivation, system, feedback)
    references, outputs = law.arguments["u"], law.outputs
    size = len(references)
    return "\n".join(
        [
            emit_function("law", tape, law.arguments, outputs),
            _emit_law_tangent(derivation, references, outputs),
            emit_jacobian(states, size, inputs, name="law_jacobian", tangent="law_tangent"),
            *(_emit_closed(name, inputs) for name in RATES),
            *(_emit_closed_step(name, inputs) for name in steppers()),
            _emit_closed_tangent(inputs),
            emit_jacobian(
                states, size, states, name=f"{PREFIX}jacobian", tangent=f"{PREFIX}tangent"
            ),
            emit_rows(states, size, name=f"{PREFIX}rows_under"),
        ]
    )


def law_of(derivation: Derivation, system: Mechanism, feedback: Feedback) -> Function:
    """Return the inputs as a function of state and references, cut at their limits.

    Raises:
        InputError: If the law rests on what it gives, or has a symbol of nothing.
    """
    binding, tape = derivation.binding, derivation.binding.tape
    references = [tape.variable(f"reference {entry.name}") for entry in feedback.references]
    symbols = [entry.symbol for entry in feedback.references]
    own = dict(zip(symbols, references, strict=True))
    lower = Lowering(tape, {**binding.lower.symbols, **own})
    expressions, nodes = dict(feedback.law), []
    for entry in system.inputs:
        wanted = lower(expressions[entry.name])
        (node,) = tape.substitute([wanted], binding.at(derivation.velocities))
        if tape.depends_on(node) & frozenset(binding.inputs):
            what = f"the law of {entry.name} rests on a velocity that inputs decide."
            remedy = "Use coordinates, independent rates and references in it."
            raise InputError([Mistake(f"system {system.name!r} feedback", what, remedy)])
        nodes.append(_between(tape, node, *bounds_of(entry)))
    arguments = {"x": derivation.state, "u": references, "p": binding.parameters}
    return Function("law", arguments, nodes)


def _between(tape: ExpressionGraph, node: Node, lower: float, upper: float) -> Node:
    """Return a node cut at two limits."""
    above = tape.maximum(node, tape.constant(lower))
    return tape.neg(tape.maximum(tape.neg(above), tape.constant(-upper)))


def _emit_law_tangent(
    derivation: Derivation, references: Sequence[Node], outputs: Sequence[Node]
) -> str:
    """Return the derivative of the law along a direction of states and references."""
    tape = derivation.binding.tape
    along = (*derivation.state, *references)
    seeds = {node: tape.variable(f"d {tape.operations[node].label}") for node in along}
    arguments = {
        "x": derivation.state,
        "u": references,
        "p": derivation.binding.parameters,
        "dx": [seeds[node] for node in derivation.state],
        "du": [seeds[node] for node in references],
    }
    return emit_function("law_tangent", tape, arguments, tape.derivative(outputs, seeds))


def _emit_closed(name: str, inputs: int) -> str:
    parameters = [("ptr", "x"), ("ptr", "u"), ("ptr", "p"), ("ptr", "out"), ("i64", "mode")]
    routine = Routine(PREFIX + name, parameters)
    acting, failed = _call_law(routine, inputs)
    call = f"call i32 @{name}(ptr %x, ptr {acting}, ptr %p, ptr %out, i64 %mode)"
    routine.give(routine.line(f"or i32 {failed}, {routine.line(call)}"))
    return routine.text()


def _emit_closed_step(name: str, inputs: int) -> str:
    routine = Routine(PREFIX + name, STEP)
    acting, failed = _call_law(routine, inputs)
    call = f"call i32 @{name}(ptr %x, ptr {acting}, ptr %p, double %h, ptr %out"
    made = routine.line(f"{call}, i64 %substeps, i64 %mode)")
    routine.give(routine.line(f"or i32 {failed}, {made}"))
    return routine.text()


def _emit_closed_tangent(inputs: int) -> str:
    pointers = [("ptr", name) for name in ("x", "u", "p", "dx", "du", "out")]
    routine = Routine(f"{PREFIX}tangent", [*pointers, ("i64", "mode")])
    acting, failed = _call_law(routine, inputs)
    change = routine.array(inputs)
    call = f"call i32 @law_tangent(ptr %x, ptr %u, ptr %p, ptr %dx, ptr %du, ptr {change}"
    failed = routine.line(f"or i32 {failed}, {routine.line(f'{call}, i64 %mode)')}")
    call = f"call i32 @tangent(ptr %x, ptr {acting}, ptr %p, ptr %dx, ptr {change}, ptr %out"
    routine.give(routine.line(f"or i32 {failed}, {routine.line(f'{call}, i64 %mode)')}"))
    return routine.text()


def _call_law(routine: Routine, inputs: int) -> tuple[Register, Register]:
    """Emit the law; returns where the inputs are and whether it failed."""
    acting = routine.array(inputs)
    call = f"call i32 @law(ptr %x, ptr %u, ptr %p, ptr {acting}, i64 %mode)"
    return acting, routine.line(call)
