"""Which of six ways a machine goes beyond the simplest one that a course begins with.

That one is the upright rolling disk: two inputs push its two degrees of freedom, and no potential
energy, controller, second mechanism or change of laws is there.
"""

from __future__ import annotations

from dataclasses import dataclass

from kinolab.analyze.describe.topology import mechanisms
from kinolab.dynamics import Coulomb, System
from kinolab.dynamics.language.expressions import exact, is_zero

SIMPLEST = 2  # inputs and degrees of freedom of the upright rolling disk


@dataclass(frozen=True)
class Mode:
    """One way of going beyond.

    Attributes:
        name: Of the way.
        shown: Whether the machine goes it.
        why: What decides it, a clause.
    """

    name: str
    shown: bool
    why: str


def modes_of(system: System, *, freedom: int, pushes: int, potential: bool) -> tuple[Mode, ...]:
    """Return the six ways, and whether a machine goes them.

    Args:
        system: The machine.
        freedom: How many velocities its constraints leave to choose.
        pushes: Along how many independent directions its inputs act.
        potential: Whether its potential energy differs between places.
    """
    return (
        _internal(system, freedom - pushes, freedom, potential),
        _inputs(system),
        _freedom(freedom),
        _feedback(system),
        _several(system),
        _transitions(system),
    )


def _internal(system: System, left: int, freedom: int, potential: bool) -> Mode:
    lagging = [entry.name for entry in system.states if entry.velocity is None]
    verb = "is" if left == 1 else "are"
    facts = {
        f"{left} of {_counted(freedom, 'degree')} of freedom {verb} pushed by no input": left > 0,
        f"{', '.join(lagging)} with differential equations of their own": len(lagging) > 1,
        f"{', '.join(lagging)} with a differential equation of its own": len(lagging) == 1,
        "its potential energy changes with its place": potential,
    }
    shown = [fact for fact, holds in facts.items() if holds]
    why = "its inputs move every degree of freedom, and its potential energy is the same everywhere"
    why = "; ".join(shown) or why
    return Mode("internal dynamics or potential energy", bool(shown), why)


def _inputs(system: System) -> Mode:
    count = len(system.inputs)
    return Mode("more than two inputs", count > SIMPLEST, _counted(count, "input"))


def _freedom(freedom: int) -> Mode:
    why = f"{freedom}, where the upright rolling disk has {SIMPLEST}"
    return Mode("more degrees of freedom", freedom > SIMPLEST, why)


def _feedback(system: System) -> Mode:
    why = "its inputs are chosen directly"
    if system.feedback is not None:
        followed = ", ".join(entry.name for entry in system.feedback.references)
        why = f"a controller sets its inputs; what is chosen is {followed}"
    return Mode("feedback", system.feedback is not None, why)


def _several(system: System) -> Mode:
    count = len(mechanisms(system))
    why = f"{count} that no body, constraint or force joins" if count > 1 else "one mechanism"
    return Mode("several mechanisms", count > 1, why)


def _transitions(system: System) -> Mode:
    """No machine of this vocabulary changes its laws on the way: dry friction is smooth."""
    dry = sum(_rubs(system, effort) for effort in system.efforts if isinstance(effort, Coulomb))
    why = "one set of laws holds everywhere"
    if dry:
        why += f"; dry friction in {_counted(dry, 'place')} is regularised, without a state that "
        why += "sticks"
    return Mode("state transitions", False, why)


def _rubs(system: System, friction: Coulomb) -> bool:
    """Whether a friction has any strength at the values that the parameters have."""
    values = system.parameter_values
    strength = exact(friction.strength)
    return not is_zero(strength.subs({p: values[p.name] for p in system.parameters}))


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
