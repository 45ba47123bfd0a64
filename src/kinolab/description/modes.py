"""Which of six ways a machine goes beyond a point that is pushed about in R^n.

The definitions are kinolab's own; each is decided from the machine alone.
"""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.description.space import kind_of, mechanisms
from kinolab.dynamics import Coulomb, System
from kinolab.dynamics.derivation import is_kinematic


@dataclass(frozen=True)
class Mode:
    """One way of going beyond.

    Attributes:
        name: Of the way.
        shown: Whether the machine goes it; None where that is not known.
        why: What decides it, a clause.
    """

    name: str
    shown: bool | None
    why: str


def modes_of(system: System, *, nonholonomic: int | None, freedom: int) -> tuple[Mode, ...]:
    """Return the six ways, and whether a machine goes them.

    Args:
        system: The machine.
        nonholonomic: How many of its constraints cannot be integrated; None if that is not known.
        freedom: How many velocities its constraints leave to choose.
    """
    return (
        _curved(system),
        _nonholonomic(nonholonomic),
        _underactuated(system, freedom),
        _drifting(system),
        _switching(system),
        _several(system),
    )


def _curved(system: System) -> Mode:
    kinds = {c.name: kind_of(c) for c in system.coordinates}
    circles = ", ".join(name for name, kind in kinds.items() if kind == "S^1")
    attitudes = ", ".join(name for name, kind in kinds.items() if kind == "SO(3)")
    where = [f"{circles} on the circle"] if circles else []
    where += [f"{attitudes} on SO(3)"] if attitudes else []
    why = "; ".join(where) or "it is R^n"
    return Mode("configuration space other than R^n", bool(where), why)


def _nonholonomic(count: int | None) -> Mode:
    name = "nonholonomic constraints"
    if count is None:
        return Mode(name, None, "its constraints depend on inputs, and are not integrated here")
    what = f"{count} forbid velocities but no configuration"
    if count == 1:
        what = "1 forbids velocities but no configuration"
    return Mode(name, count > 0, what if count else "none")


def _underactuated(system: System, freedom: int) -> Mode:
    count = len(system.inputs)
    why = f"{_counted(count, 'input')} for {_counted(freedom, 'degree')} of freedom"
    return Mode("fewer inputs than degrees of freedom", count < freedom, why)


def _drifting(system: System) -> Mode:
    still = is_kinematic(system) and not system.states
    why = "its inputs are velocities" if still else "it moves on when the inputs are zero"
    return Mode("drift", not still, why)


def _switching(system: System) -> Mode:
    dry = sum(isinstance(effort, Coulomb) for effort in system.efforts)
    why = f"dry friction sticks and slips in {_counted(dry, 'place')}" if dry else "one set of laws"
    return Mode("mechanics that switch", dry > 0, why)


def _several(system: System) -> Mode:
    count = len(mechanisms(system))
    why = f"{count} that no body, constraint or force joins" if count > 1 else "one mechanism"
    return Mode("several mechanisms", count > 1, why)


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
