"""A machine with modes as one machine for each, with what is said of the mode."""

from __future__ import annotations

from collections.abc import Iterator

import sympy

from kinolab.dynamics import System, in_mode
from kinolab.dynamics.language.modes import Mode, Transition
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import ForceSymbol


def in_each_mode(system: System) -> Iterator[tuple[str, System]]:
    """Yield a machine in each of its modes, with a title; itself, without one, if it has none."""
    if not system.modes:
        yield "", system
    for mode in system.modes:
        yield _title(system, mode), System.of(in_mode(system, mode.name))


def _title(system: System, mode: Mode) -> str:
    leaving = [t for t in system.transitions if t.source == mode.name]
    lines = [f"{system.name} in mode {mode.name!r}", *map(_line, leaving)]
    return "\n".join(lines if leaving else [*lines, "  which it never leaves"])


def _line(transition: Transition) -> str:
    after = "it begins anew" if transition.source == transition.target else transition.target
    until = exact(transition.until)
    forces = [s for s in until.free_symbols if isinstance(s, ForceSymbol)]
    shown = until.xreplace({s: sympy.Symbol(f"force of {s.name!r}") for s in forces})
    line = f"  {transition.name}: until {shown} falls to 0"
    if transition.provided is not None:
        line += f", provided that {transition.provided} > 0"
    if transition.restitution is not None:
        line += f"; an impact returns {transition.restitution} of that speed"
    if transition.reset:
        line += f"; {', '.join(f'{symbol} becomes {value}' for symbol, value in transition.reset)}"
    return f"{line}; then {after}"
