"""Modes and transitions: mechanics that switches, such as a foot that stands and swings.

In each mode a machine has constraints and forces of its own beside those that it always has. A
transition ends a mode where an expression falls to zero, and may change the state at that instant.

Source: Goebel, Sanfelice, Teel, Hybrid dynamical systems, IEEE Control Systems 29(2), 2009; for
blows: Murray, Li, Sastry, A Mathematical Introduction to Robotic Manipulation, 1994, chapter 6;
Hurmuzlu, Genot, Brogliato, Modeling, stability and control of biped robots, Automatica 40, 2004.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.constraints import Constraint, Requirement
from kinolab.dynamics.language.forces import Effort
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.symbols.expressions import exact

MODE = "mode"  # the state that says in which mode a machine is: 0 for the first, then 1, …


@checked
@dataclass(frozen=True)
class Mode:
    """What holds of a machine while it is in a mode, beside what always does.

    Attributes:
        name: Its name in scenarios and reports.
        constraints: ``zero(velocity)`` and ``closed(position)`` of this mode.
        efforts: Forces of this mode: springs, ropes, friction, wrenches.
        requirements: Path constraints on plans in this mode.
    """

    name: str
    _: KW_ONLY
    constraints: Sequence[Constraint] = ()
    efforts: Sequence[Effort] = ()
    requirements: Sequence[Requirement] = ()

    def __post_init__(self) -> None:
        """Take lists as tuples."""
        for key in ("constraints", "efforts", "requirements"):
            object.__setattr__(self, key, tuple(getattr(self, key)))


@checked
@dataclass(frozen=True)
class Transition:
    """How one mode gives way to another, or to itself.

    At the instant of a transition, in this order: with a ``restitution`` the velocity at which
    ``until`` falls is reversed by an impact along its gradient; ``reset`` takes effect; velocities
    that the next mode's constraints forbid are stopped by a perfectly inelastic impact,
    M (v+ - v-) = J^T impulse with J v+ = 0. Nothing moves there: positions that the next mode
    holds (``closed``) must have come to where it holds them, by ``until``, ``provided`` or
    ``reset``, which certificates check.

    Attributes:
        name: Its name in reports and errors.
        source: Name of the mode that ends.
        target: Name of the mode that follows.
        until: The mode lasts until this expression falls to zero: in coordinates, rates, states,
            parameters, inputs and ``force_of`` constraints. One of inputs alone, such as
            ``0.5 - grip.symbol`` of a hand that closes on command, ends it as soon as it is not
            positive.
        provided: The transition takes place only where this is positive, if it is given.
        restitution: Ratio of the speeds after and before the impact along ``until``, in 0..1, a
            number or a parameter; None where there is no such impact.
        reset: Coordinates, rates and states after the transition, as expressions in those before;
            what is not listed stays.
    """

    name: str
    source: str
    target: str
    _: KW_ONLY
    until: Number
    provided: Number | None = None
    restitution: Number | None = None
    reset: Mapping[sympy.Symbol, Number] | tuple[tuple[sympy.Symbol, sympy.Expr], ...] = ()

    def __post_init__(self) -> None:
        """Convert numbers to expressions, and the reset to pairs."""
        for key in ("until", "provided", "restitution"):
            if getattr(self, key) is not None:
                object.__setattr__(self, key, exact(getattr(self, key)))
        pairs = self.reset.items() if isinstance(self.reset, Mapping) else self.reset
        made = tuple((symbol, exact(value)) for symbol, value in pairs)
        object.__setattr__(self, "reset", made)
