"""LLVM IR for a machine with modes: the functions of each, and those that choose among them.

Every function of a machine asks the last entry of the state in which mode it is, and calls that
mode's own. Two functions are new:

    int leaves(const double *x, const double *u, const double *p, double *out, long mode)
    int reset(const double *x, const double *u, const double *p, double *out, long mode)

``leaves`` writes the number, from 1, of the first transition that takes place at a state, 0 for
none: its guard is not positive and falls. ``reset`` writes the state after that transition, x
itself where none takes place. A step ends at the first instant at which a transition takes place,
found by bisection of the step's length; after the reset the rest is made in the next mode.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from kinolab.dynamics.codegen.compiled_functions import CHATTERS, STEPPERS
from kinolab.dynamics.codegen.emission import emit_function, emit_module
from kinolab.dynamics.codegen.integrators import STEP
from kinolab.dynamics.codegen.llvm import Register, Routine, literal
from kinolab.dynamics.mode_derivations import ModeDerivation

HALVINGS = 48  # of a step, to locate a transition: 1 s to 4e-15 s
MAX_SWITCHES = 64  # in one step; more are called chattering
DEFINED = re.compile(r"^define (?:internal )?(\w+) @(\w+)\(([^)]*)\)", re.MULTILINE)
SHARED = ("rows_at", "rows_under", "rows_between", "difference", "retract")  # know no modes
FLOW = "flow_"  # prefix of steps that switch nothing
LEAVES = [*(("ptr", name) for name in ("x", "u", "p", "out")), ("i64", "mode")]


def emit_hybrid(modes: Sequence[ModeDerivation]) -> str:
    """Return the IR text of all functions of a machine with modes."""
    states = len(modes[0].derivation.state)
    texts = [emit_module(mode.derivation) for mode in modes]
    functions = [m.groups() for m in DEFINED.finditer(texts[0])]
    lines = texts[0].splitlines()
    shared = [_body_of(texts[0], name) for _, name, _ in functions if name in SHARED]
    return "\n".join(
        [
            *(line for line in lines if line.startswith("declare")),
            *shared,
            *(_renamed(text, k) for k, text in enumerate(texts)),
            *(line for k, mode in enumerate(modes) for line in _switches(mode, k)),
            *(
                _dispatched(name, parameters, states, len(modes))
                for _, name, parameters in functions
                if name not in SHARED and "ptr %x" in parameters  # others are linear algebra
            ),
            *(_step(method, states) for method in STEPPERS),
            _leaves(modes, states),
            _reset(modes, states),
        ]
    )


def _in(mode: int, name: str) -> str:
    return f"{name}.{mode}"


def _body_of(text: str, name: str) -> str:
    """Return one function's text."""
    found = re.search(rf"^define [^\n]*@{name}\(.*?^}}", text, re.MULTILINE | re.DOTALL)
    assert found is not None
    return found.group(0)


def _renamed(text: str, mode: int) -> str:
    """Return a mode's module with names of its own, without what all modes share."""
    names = {name for _, name, _ in (m.groups() for m in DEFINED.finditer(text))}
    for name in SHARED:
        text = text.replace(_body_of(text, name), "")
    text = "\n".join(line for line in text.splitlines() if not line.startswith("declare"))
    return re.sub(r"@(\w+)\(", lambda m: f"@{_in(mode, m[1])}(" if m[1] in names else m[0], text)


def _mode_of(routine: Routine, states: int) -> Register:
    return routine.line(f"fptosi double {routine.load('%x', states - 1)} to i64")


def _dispatched(name: str, parameters: str, states: int, modes: int) -> str:
    """Return a function that calls the one of the mode in which the state is."""
    pairs = (entry.replace("%", "").split() for entry in parameters.split(", "))
    own = FLOW + name if name in STEPPERS else name
    routine = Routine(own, [(kind, label) for kind, label in pairs])
    current = _mode_of(routine, states)
    for k in range(modes - 1):
        mark = routine.fork(routine.line(f"icmp eq i64 {current}, {k}"))
        routine.give(routine.line(f"call i32 @{_in(k, name)}({parameters})"))
        routine.join(mark)
    routine.give(routine.line(f"call i32 @{_in(modes - 1, name)}({parameters})"))
    return routine.text()


def _switches(mode: ModeDerivation, k: int) -> Iterator[str]:
    """Yield a mode's guards and resets, and how its constraints stop velocities."""
    d = mode.derivation
    tape = d.binding.tape
    given = {"x": d.state, "u": d.binding.inputs, "p": d.binding.parameters}
    guards = [node for guard in mode.guards for node in guard]
    yield emit_function(_in(k, "guards"), tape, given, guards)
    for j, reset in enumerate(mode.resets):
        yield emit_function(_in(k, f"reset{j}"), tape, given, reset)
    yield emit_function(_in(k, "landed"), tape, given, mode.landed)


def _leaves(modes: Sequence[ModeDerivation], states: int) -> str:
    routine = Routine("leaves", LEAVES)
    values = routine.array(3 * max(len(mode.guards) for mode in modes))
    current = _mode_of(routine, states)
    zero = literal(0.0)
    routine.store("%out", 0, zero)
    for k, mode in enumerate(modes):
        mark = routine.fork(routine.line(f"icmp eq i64 {current}, {k}"))
        call = f"call i32 @{_in(k, 'guards')}(ptr %x, ptr %u, ptr %p, ptr {values}, i64 %mode)"
        status = routine.line(call)
        found = zero
        for j in reversed(range(len(mode.guards))):
            until, rate, condition = (routine.load(values, 3 * j + i) for i in range(3))
            over = routine.line(f"fcmp ole double {until}, {zero}")
            falls = routine.line(f"fcmp olt double {rate}, {zero}")
            holds = routine.line(f"fcmp ogt double {condition}, {zero}")
            both = routine.line(f"and i1 {over}, {routine.line(f'and i1 {falls}, {holds}')}")
            number = literal(j + 1.0)
            found = routine.line(f"select i1 {both}, double {number}, double {found}")
        routine.store("%out", 0, found)
        routine.give(status)
        routine.join(mark)
    routine.give("0")
    return routine.text()


def _reset(modes: Sequence[ModeDerivation], states: int) -> str:
    routine = Routine("reset", LEAVES)
    which, after = routine.array(1), routine.array(states)
    listing = "ptr %x, ptr %u, ptr %p"
    asked = routine.line(f"call i32 @leaves({listing}, ptr {which}, i64 %mode)")
    chosen = routine.line(f"fptosi double {routine.load(which, 0)} to i64")
    current = _mode_of(routine, states)
    for k, mode in enumerate(modes):
        for j, target in enumerate(mode.targets):
            here = routine.line(f"icmp eq i64 {current}, {k}")
            this = routine.line(f"icmp eq i64 {chosen}, {j + 1}")
            mark = routine.fork(routine.line(f"and i1 {here}, {this}"))
            call = f"call i32 @{_in(k, f'reset{j}')}({listing}, ptr {after}, i64 %mode)"
            changed = routine.line(call)
            call = f"call i32 @{_in(target, 'landed')}(ptr {after}, ptr %u, ptr %p, ptr %out"
            landed = routine.line(f"{call}, i64 %mode)")
            routine.give(routine.line(f"or i32 {changed}, {landed}"))
            routine.join(mark)
    routine.copy("%x", "%out", states)
    routine.give(asked)
    return routine.text()


def _step(method: str, states: int) -> str:
    """Return a step that switches modes on its way."""
    routine = Routine(method, STEP)
    begin, end, which = routine.array(states), routine.array(states), routine.array(1)
    status = routine.cell("i32", "0")
    rest, low, high = (routine.cell("double", literal(0.0)) for _ in range(3))
    routine.put("double", rest, "%h")
    routine.copy("%x", begin, states)

    def note(failed: Register) -> None:
        so_far = routine.get("i32", status)
        routine.put("i32", status, routine.line(f"or i32 {so_far}, {failed}"))

    def flow(length: Register) -> None:
        call = f"call i32 @{FLOW}{method}(ptr {begin}, ptr %u, ptr %p, double {length}"
        note(routine.line(f"{call}, ptr {end}, i64 %substeps, i64 %mode)"))

    def left(state: Register) -> Register:
        call = f"call i32 @leaves(ptr {state}, ptr %u, ptr %p, ptr {which}, i64 %mode)"
        note(routine.line(call))
        return routine.line(f"fcmp ogt double {routine.load(which, 0)}, {literal(0.0)}")

    with routine.loop(0, MAX_SWITCHES):
        with routine.when(left(begin)):
            note(
                routine.line(f"call i32 @reset(ptr {begin}, ptr %u, ptr %p, ptr {end}, i64 %mode)")
            )
            routine.copy(end, begin, states)
        length = routine.get("double", rest)
        flow(length)
        again = left(begin)  # as the reset has left it: another transition at the same instant
        stays = routine.line(f"xor i1 {left(end)}, true")
        done = routine.line(f"and i1 {stays}, {routine.line(f'xor i1 {again}, true')}")
        mark = routine.fork(done)
        routine.copy(end, "%out", states)
        routine.give(routine.get("i32", status))
        routine.join(mark)
        with routine.when(routine.line(f"xor i1 {again}, true")):
            routine.put("double", low, literal(0.0))
            routine.put("double", high, length)
            with routine.loop(0, HALVINGS):
                a, b = routine.get("double", low), routine.get("double", high)
                middle = routine.mul(routine.add(a, b), literal(0.5))
                flow(middle)
                over = left(end)
                routine.put(
                    "double", high, routine.line(f"select i1 {over}, double {middle}, double {b}")
                )
                routine.put(
                    "double", low, routine.line(f"select i1 {over}, double {a}, double {middle}")
                )
            made = routine.get("double", high)
            flow(made)
            routine.copy(end, begin, states)
            routine.put("double", rest, routine.sub(length, made))
    routine.copy(begin, "%out", states)
    routine.give(str(CHATTERS))
    return routine.text()
