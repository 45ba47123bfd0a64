"""LLVM IR for a machine with modes: the functions of each, and those that choose among them.

Every function of a machine asks the last entry of the state in which mode it is, and calls that
mode's own. Four functions are new:

    int leaves(const double *x, const double *u, const double *p, double *out, long mode)
    int guards(const double *x, const double *u, const double *p, double *out, long mode)
    int reset(const double *x, const double *u, const double *p, double *out, long mode)
    int through(const double *x, const double *u, const double *p, double *out, long mode)

``leaves`` writes the number, from 1, of the first transition that takes place at a state, 0 for
none: its guard is not positive and falls. ``guards`` writes the same number and, for each
transition, its guard, the guard's rate and the condition under which it counts. ``reset`` writes
the state after that transition, x itself where none takes place; ``through`` the state after the
transition whose number ``mode`` is, whether it takes place there or not.

A step ends at the first instant at which a transition takes place, found by bisection of the step's
length; after the reset the rest is made in the next mode. A guard may also fall below zero and
return within one step. Where it falls at the beginning and rises at the end, its tangents there
bound a convex guard from below; only if that bound is not positive is the guard's minimum searched.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from kinolab.dynamics.codegen.compiled_functions import CHATTERS
from kinolab.dynamics.codegen.emission import emit_function, emit_module
from kinolab.dynamics.codegen.integrators import RATE, STEP, steppers
from kinolab.dynamics.codegen.llvm import Register, Routine, literal
from kinolab.dynamics.codegen.trigonometry import NAME
from kinolab.dynamics.facts.mode_derivations import ModeDerivation

DEFINED = re.compile(r"^define (?:internal )?(\w+|\{.*?\}) @(\w+)\(([^)]*)\)", re.MULTILINE)
LOOPS = ("rows_at", "rows_under", "rows_between")
SHARED = (*LOOPS, "difference", "retract", NAME)  # know no modes
FLOW = "flow_"  # prefix of steps that switch nothing


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
            *(_Step(method, states, _most_guards(modes)).text() for method in steppers()),
            _leaves(modes),
            _guards(modes, states),
            _through(modes, states),
            _reset(),
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
    names = {m[2] for m in DEFINED.finditer(text)}.difference(SHARED)
    for name in SHARED:
        text = text.replace(_body_of(text, name), "")
    text = "\n".join(line for line in text.splitlines() if not line.startswith("declare"))
    return re.sub(r"@(\w+)\(", lambda m: f"@{_in(mode, m[1])}(" if m[1] in names else m[0], text)


def _mode_of(routine: Routine, states: int) -> Register:
    return routine.line(f"fptosi double {routine.load('%x', states - 1)} to i64")


def _dispatched(name: str, parameters: str, states: int, modes: int) -> str:
    """Return a function that calls the one of the mode in which the state is."""
    pairs = (entry.replace("%", "").split() for entry in parameters.split(", "))
    own = FLOW + name if name in steppers() else name
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
    for name, nodes in mode.switches.items():
        yield emit_function(_in(k, name), d.binding.tape, d.arguments, nodes)


def _most_guards(modes: Sequence[ModeDerivation]) -> int:
    return max(len(mode.targets) for mode in modes)


def _leaves(modes: Sequence[ModeDerivation]) -> str:
    routine = Routine("leaves", RATE)
    seen = routine.array(1 + 3 * _most_guards(modes))
    status = routine.call("@guards", "%x", "%u", "%p", seen)
    routine.store("%out", 0, routine.load(seen, 0))
    routine.give(status)
    return routine.text()


def _guards(modes: Sequence[ModeDerivation], states: int) -> str:
    routine = Routine("guards", RATE)
    values = routine.at("%out", 1)
    current = _mode_of(routine, states)
    zero, far = literal(0.0), literal(1.0)
    routine.store("%out", 0, zero)
    for j in range(_most_guards(modes)):  # a mode may have fewer
        for i, value in enumerate((far, zero, zero)):
            routine.store(values, 3 * j + i, value)
    for k, mode in enumerate(modes):
        mark = routine.fork(routine.line(f"icmp eq i64 {current}, {k}"))
        status = routine.call(f"@{_in(k, 'guards')}", "%x", "%u", "%p", values)
        found = zero
        for j in reversed(range(len(mode.targets))):
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


def _through(modes: Sequence[ModeDerivation], states: int) -> str:
    routine = Routine("through", RATE)
    after, current = routine.array(states), _mode_of(routine, states)
    for k, mode in enumerate(modes):
        for j, target in enumerate(mode.targets):
            here = routine.line(f"icmp eq i64 {current}, {k}")
            this = routine.line(f"icmp eq i64 %mode, {j + 1}")
            mark = routine.fork(routine.line(f"and i1 {here}, {this}"))
            changed = routine.call(f"@{_in(k, f'reset{j}')}", "%x", "%u", "%p", after)
            landed = routine.call(f"@{_in(target, 'landed')}", after, "%u", "%p", "%out")
            routine.give(routine.line(f"or i32 {changed}, {landed}"))
            routine.join(mark)
    routine.copy("%x", "%out", states)
    routine.give("0")
    return routine.text()


def _reset() -> str:
    routine = Routine("reset", RATE)
    which = routine.array(1)
    asked = routine.call("@leaves", "%x", "%u", "%p", which)
    chosen = routine.line(f"fptosi double {routine.load(which, 0)} to i64")
    arguments = f"ptr %x, ptr %u, ptr %p, ptr %out, i64 {chosen}"
    done = routine.line(f"call i32 @through({arguments})")
    routine.give(routine.line(f"or i32 {asked}, {done}"))
    return routine.text()


class _Step:
    """A step that switches modes on its way, written part by part."""

    def __init__(self, method: str, states: int, guards: int) -> None:
        self._method, self._states, self._guards = method, states, guards
        self._routine = routine = Routine(method, STEP)
        self._begin, self._end, self._between = (routine.array(states) for _ in range(3))
        self._here, self._there, self._seen = (routine.array(1 + 3 * guards) for _ in range(3))
        self._status = routine.cell("i32", "0")
        zero = literal(0.0)
        self._rest, self._low, self._high = (routine.cell("double", zero) for _ in range(3))
        self._crossed = routine.cell("i1", "false")

    def text(self) -> str:
        """Return the whole function."""
        routine, begin, end = self._routine, self._begin, self._end
        routine.put("double", self._rest, "%h")
        routine.copy("%x", begin, self._states)
        with routine.loop(0, 64):  # in one step; more are called chattering
            with routine.when(self._left(begin, self._here)):
                self._note(routine.call("@reset", begin, "%u", "%p", end))
                routine.copy(end, begin, self._states)
            length = routine.get("double", self._rest)
            self._flow(length, end)
            again = self._left(begin, self._here)  # another one at the same instant
            over = self._left(end, self._there)
            routine.put("i1", self._crossed, over)
            routine.put("double", self._high, length)
            with routine.when(self._not(again)):
                self._shorten(over)
            stays = self._not(routine.get("i1", self._crossed))
            mark = routine.fork(routine.line(f"and i1 {stays}, {self._not(again)}"))
            routine.copy(end, "%out", self._states)
            routine.give(routine.get("i32", self._status))
            routine.join(mark)
            with routine.when(self._not(again)):
                routine.copy(end, begin, self._states)
                made = routine.get("double", self._high)
                routine.put("double", self._rest, routine.sub(length, made))
        routine.copy(begin, "%out", self._states)
        routine.give(str(CHATTERS))
        return routine.text()

    def _not(self, condition: Register) -> Register:
        return self._routine.line(f"xor i1 {condition}, true")

    def _note(self, failed: Register) -> None:
        self._routine.merge(self._status, failed)

    def _flow(self, length: Register, to: Register) -> None:
        """Make a step in one mode."""
        call = f"call i32 @{FLOW}{self._method}(ptr {self._begin}, ptr %u, ptr %p, double {length}"
        self._note(self._routine.line(f"{call}, ptr {to}, i64 %substeps, i64 %mode)"))

    def _left(self, state: Register, values: Register) -> Register:
        """Return whether a transition takes place at a state; its guards are written."""
        self._note(self._routine.call("@guards", state, "%u", "%p", values))
        found = self._routine.load(values, 0)
        return self._routine.line(f"fcmp ogt double {found}, {literal(0.0)}")

    def _halve(self) -> Register:
        a, b = (self._routine.get("double", cell) for cell in (self._low, self._high))
        return self._routine.mul(self._routine.add(a, b), literal(0.5))

    def _narrow(self, down: Register, middle: Register) -> None:
        """Make a length the upper end of the interval where a condition holds, else the lower."""
        a, b = (self._routine.get("double", cell) for cell in (self._low, self._high))
        for cell, pair in ((self._high, (middle, b)), (self._low, (a, middle))):
            self._routine.put("double", cell, self._routine.select(down, *pair))

    def _shorten(self, over: Register) -> None:
        """Shorten the step to its first transition: at its end, or where a guard is least."""
        routine = self._routine
        with routine.when(over):
            self._locate()
            self._left(self._end, self._there)
        for j in range(self._guards):
            span = routine.get("double", self._high)
            with routine.when(_returns(routine, self._here, self._there, j, span)):
                self._search(j)

    def _locate(self) -> None:
        """Shorten ``high``, at which a transition takes place, to the first such instant."""
        routine = self._routine
        routine.put("double", self._low, literal(0.0))
        with routine.loop(0, 48):  # halvings of a step, to locate a transition: 1 s to 4e-15 s
            middle = self._halve()
            self._flow(middle, self._end)
            self._narrow(self._left(self._end, self._seen), middle)
        self._flow(routine.get("double", self._high), self._end)

    def _search(self, j: int) -> None:
        """Shorten the step to a transition near the minimum of guard j, if there is one."""
        routine = self._routine
        found, length = routine.cell("i1", "false"), routine.get("double", self._high)
        routine.put("double", self._low, literal(0.0))
        # 24 halvings of a step, to find where a guard is least: 1 s to 6e-8 s
        with routine.loop(0, 24), routine.when(self._not(routine.get("i1", found))):
            middle = self._halve()
            self._flow(middle, self._between)
            over = self._left(self._between, self._seen)
            routine.put("i1", found, over)
            rate = routine.load(self._seen, 3 * j + 2)
            rises = routine.line(f"fcmp oge double {rate}, {literal(0.0)}")
            self._narrow(routine.line(f"or i1 {over}, {rises}"), middle)
        over = routine.get("i1", found)
        with routine.when(over):
            routine.put("i1", self._crossed, "true")
            self._locate()
            self._left(self._end, self._there)
        with routine.when(self._not(over)):
            routine.put("double", self._high, length)


def _returns(routine: Routine, here: Register, there: Register, j: int, span: Register) -> Register:
    """Return whether a guard may have been negative for a while within a step.

    It is positive and falls at the beginning, rises at the end, and is not positive there or where
    the tangents meet, below which a convex guard never is.

    Args:
        routine: What asks.
        here: What ``guards`` wrote at the beginning.
        there: The same at the end.
        span: Length of the step in [s].
    """
    zero = literal(0.0)
    g, falling = (routine.load(here, 3 * j + i) for i in (1, 2))
    last, rising = (routine.load(there, 3 * j + i) for i in (1, 2))
    height = routine.sub(routine.sub(last, g), routine.mul(rising, span))
    meet = routine.div(height, routine.sub(falling, rising))
    least = routine.add(g, routine.mul(falling, meet))
    low = routine.line(f"fcmp ole double {least}, {zero}")
    below = routine.line(f"fcmp ole double {last}, {zero}")
    returns = routine.line(f"or i1 {low}, {below}")
    for test in (
        f"fcmp ogt double {g}, {zero}",
        f"fcmp olt double {falling}, {zero}",
        f"fcmp ogt double {rising}, {zero}",
    ):
        returns = routine.line(f"and i1 {returns}, {routine.line(test)}")
    return returns
