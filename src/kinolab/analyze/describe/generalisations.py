"""Which of six generalisations of a course's first example a machine shows.

The example is the upright rolling disk: two inputs actuate its two degrees of freedom, without
potential energy, controller, second mechanism or switching dynamics.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from kinolab.analyze.describe.topology import mechanisms
from kinolab.dynamics import System
from kinolab.dynamics.language.mechanism_parts import dry_frictions
from kinolab.dynamics.symbols.expressions import is_zero
from kinolab.errors import counted

SIMPLEST = 2  # inputs and degrees of freedom of the upright rolling disk


@dataclass(frozen=True)
class Generalisation:
    """One generalisation.

    Attributes:
        name: Its name.
        shown: Whether the machine shows it.
        why: The reason, as a clause.
    """

    name: str
    shown: bool
    why: str


def generalisations_of(
    system: System, *, freedom: int, pushes: int, potential: bool, switching: Sequence[str] = ()
) -> tuple[Generalisation, ...]:
    """Return the six generalisations, and whether a machine shows them.

    Args:
        freedom: Number of independent velocities under its constraints.
        pushes: Number of independent directions in which its inputs act.
        potential: Whether its potential energy differs between configurations.
        switching: Names of the transitions between the modes of which this is one.
    """
    inputs, parts = len(system.inputs), len(mechanisms(system))
    more = f"{freedom}, and the upright rolling disk has {SIMPLEST}"
    apart = f"{parts} that no body, constraint or force joins" if parts > 1 else "one mechanism"
    return (
        _internal(system, freedom - pushes, freedom, potential),
        Generalisation("more than two inputs", inputs > SIMPLEST, counted(inputs, "input")),
        Generalisation("more degrees of freedom", freedom > SIMPLEST, more),
        _feedback(system),
        Generalisation("several mechanisms", parts > 1, apart),
        _transitions(system, switching),
    )


def _internal(system: System, left: int, freedom: int, potential: bool) -> Generalisation:
    lagging = [entry.name for entry in system.states if entry.velocity is None]
    facts = {
        f"no input acts on {left} of {counted(freedom, 'degree')} of freedom": left > 0,
        f"{', '.join(lagging)} with differential equations of their own": len(lagging) > 1,
        f"{', '.join(lagging)} with a differential equation of its own": len(lagging) == 1,
        "its potential energy depends on its configuration": potential,
    }
    shown = [fact for fact, holds in facts.items() if holds]
    why = "its inputs act on every degree of freedom, and its potential energy is constant"
    why = "; ".join(shown) or why
    return Generalisation("internal dynamics or potential energy", bool(shown), why)


def _feedback(system: System) -> Generalisation:
    why = "its inputs are set directly"
    if system.feedback is not None:
        followed = ", ".join(entry.name for entry in system.feedback.references)
        why = f"a controller sets its inputs; it follows {followed}"
    return Generalisation("feedback", system.feedback is not None, why)


def _transitions(system: System, switching: Sequence[str]) -> Generalisation:
    """Say whether other equations hold elsewhere; dry friction is regularised."""
    if switching:
        return Generalisation("state transitions", True, ", ".join(switching))
    values = system.substitutions
    dry = sum(not is_zero(strength.subs(values)) for _, strength in dry_frictions(system))
    why = "the same equations hold everywhere"
    if dry:
        why += f"; dry friction in {counted(dry, 'place')} is regularised, without a state that "
        why += "sticks"
    return Generalisation("state transitions", False, why)
