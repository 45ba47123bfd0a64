"""LLVM IR for a machine with feedback: its functions again, of references instead of inputs.

    int law(const double *x, const double *r, const double *p, double *u, long mode)
    int closed_NAME(const double *x, const double *r, const double *p, …)

Each ``closed_`` function evaluates the law at the state that it is given and calls the machine's
own function with the inputs that come out. A step holds them to its end.
"""

from __future__ import annotations

from kinolab.dynamics.codegen.compiled_functions import PREFIX, RATES
from kinolab.dynamics.codegen.emission import emit_function, emit_jacobian, emit_rows
from kinolab.dynamics.codegen.exports import Function, tangent_of
from kinolab.dynamics.codegen.integrators import RATE, STEP, steppers
from kinolab.dynamics.codegen.llvm import Register, Routine
from kinolab.dynamics.derivation.derivation import Derivation
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.dynamics.language.feedback import Feedback
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.errors import InputError, Mistake


def emit_closed_loop(derivation: Derivation, feedback: Feedback) -> str:
    """Return the IR text of what a law adds to a machine's functions.

    Raises:
        InputError: If the law rests on what it gives, or has a symbol of nothing.
    """
    binding = derivation.binding
    tape, states, inputs = binding.tape, len(derivation.state), len(binding.inputs)
    law = law_of(derivation, feedback)
    tangent, size = tangent_of(tape, law), len(feedback.references)
    return "\n".join(
        [
            emit_function("law", tape, law.arguments, law.outputs),
            emit_function("law_tangent", tape, tangent.arguments, tangent.outputs),
            emit_jacobian(states, size, inputs, name="law_jacobian", tangent="law_tangent"),
            *(_emit_closed(name, RATE, inputs) for name in RATES),
            *(_emit_closed(name, STEP, inputs) for name in steppers()),
            _emit_closed_tangent(inputs),
            emit_jacobian(
                states, size, states, name=f"{PREFIX}jacobian", tangent=f"{PREFIX}tangent"
            ),
            emit_rows(states, size, name=f"{PREFIX}rows_under"),
        ]
    )


def law_of(derivation: Derivation, feedback: Feedback) -> Function:
    """Return the inputs as a function of state and references, cut at their limits.

    Raises:
        InputError: If the law rests on what it gives, or has a symbol of nothing.
    """
    binding, tape = derivation.binding, derivation.binding.tape
    system = binding.system
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
        lower_limit, upper_limit = bounds_of(entry)
        above = tape.maximum(node, tape.constant(lower_limit))
        nodes.append(tape.neg(tape.maximum(tape.neg(above), tape.constant(-upper_limit))))
    return Function("law", {**derivation.arguments, "u": references}, nodes)


def _emit_closed(name: str, parameters: list[tuple[str, str]], inputs: int) -> str:
    """Return a function of a machine again, of references instead of inputs."""
    routine = Routine(PREFIX + name, parameters)
    acting, failed = _call_law(routine, inputs)
    given = (f"{kind} {acting if label == 'u' else f'%{label}'}" for kind, label in parameters)
    made = routine.line(f"call i32 @{name}({', '.join(given)})")
    routine.give(routine.line(f"or i32 {failed}, {made}"))
    return routine.text()


def _emit_closed_tangent(inputs: int) -> str:
    pointers = [("ptr", name) for name in ("x", "u", "p", "dx", "du", "out")]
    routine = Routine(f"{PREFIX}tangent", [*pointers, ("i64", "mode")])
    acting, failed = _call_law(routine, inputs)
    change = routine.array(inputs)
    turned = routine.call("@law_tangent", "%x", "%u", "%p", "%dx", "%du", change)
    failed = routine.line(f"or i32 {failed}, {turned}")
    made = routine.call("@tangent", "%x", acting, "%p", "%dx", change, "%out")
    routine.give(routine.line(f"or i32 {failed}, {made}"))
    return routine.text()


def _call_law(routine: Routine, inputs: int) -> tuple[Register, Register]:
    """Emit the law; returns where the inputs are and whether it failed."""
    acting = routine.array(inputs)
    return acting, routine.call("@law", "%x", "%u", "%p", acting)
