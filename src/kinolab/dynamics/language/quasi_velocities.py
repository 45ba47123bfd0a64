"""States beside coordinates and their rates: quasi-velocities and auxiliary states.

Quasi-velocities are not rates of coordinates, such as a body's V.x. They are linear in the rates,
v = w(q) q_dot, and need not be the derivative of anything.

Source: Bloch, Nonholonomic Mechanics and Control, 2003, section 3.8; Siciliano et al., Robotics:
Modelling, Planning and Control, 2009, section 11.2 (quasi-velocities of wheeled robots).
"""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass
from typing import Any

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.symbols.expressions import exact, sympify_fields
from kinolab.dynamics.symbols.symbols import (
    Acceleration,
    MachineSymbol,
    RateSymbol,
    StateSymbol,
    TurnAcceleration,
    TurnRate,
)
from kinolab.errors import InputError, Mistake


class QuasiVelocitySymbol(MachineSymbol):
    """The value of a quasi-velocity, named after it; for equations, feedback and steady motions."""

    velocity: sympy.Expr  # linear in the rates

    def __new__(cls, name: str, velocity: sympy.Expr) -> QuasiVelocitySymbol:
        """Make the symbol; users take ``QuasiVelocity.symbol``."""
        return cls._build(name, (velocity,))


class QuasiAcceleration(MachineSymbol):
    """The time derivative of a quasi-velocity; it occurs in equations only."""

    velocity: QuasiVelocitySymbol

    def __new__(cls, velocity: QuasiVelocitySymbol) -> QuasiAcceleration:
        """Make the derivative of a quasi-velocity."""
        letter, _, index = velocity.name.partition("_")
        return cls._build(f"{letter}dot_{index}" if index else f"{letter}_dot", (velocity,))

    def _latex(self, printer: Any) -> str:
        letter, _, index = self.velocity.name.partition("_")
        dotted = rf"\dot{{{printer._print(sympy.Symbol(letter))}}}"
        return f"{dotted}_{{{index}}}" if index else dotted


# every symbol of a velocity or an acceleration
MOTIONS = (
    *(RateSymbol, Acceleration, TurnRate, TurnAcceleration),
    *(QuasiVelocitySymbol, QuasiAcceleration),
)


@checked
@dataclass(frozen=True)
class QuasiVelocity:
    """A velocity that is a state instead of coordinates' rates, for a machine's ``velocities``.

    Args:
        name: Its name in scenarios and files.
        velocity: What it is, linear in the rates, such as ``V.x``.
        unit: SI unit as text.
        speed: Largest magnitude in ``unit``; what is left out is not limited.
        scale: Characteristic magnitude in ``unit``; distances are divided by it where nothing
            limits the velocity.
        direction: What it is in words; for reading only.

    Raises:
        InputError: If a size is not positive or no number.
    """

    name: str
    velocity: Number
    unit: str = "m/s"
    speed: float = math.inf
    scale: float = 1.0
    direction: str = ""

    def __post_init__(self) -> None:
        """Convert the velocity to an expression and check the sizes."""
        object.__setattr__(self, "velocity", exact(self.velocity))
        if not (self.speed > 0 and 0 < self.scale < math.inf):
            what = f"its speed is {self.speed:g} and its scale {self.scale:g}."
            raise InputError([Mistake(f"velocity {self.name!r}", what, "Both must be positive.")])

    @property
    def symbol(self) -> QuasiVelocitySymbol:
        """The symbol of its value."""
        return QuasiVelocitySymbol(self.name, self.velocity)


@checked
@dataclass(frozen=True)
class State:
    """An auxiliary state with its own differential equation.

    Attributes:
        name: Its name in scenarios and files.
        derivative: Its time derivative, an expression in states, inputs and parameters; ``state``
            returns the symbol of the state itself.
        limits: Lower and upper limit in ``unit``.
        unit: SI unit as text.
        scale: Characteristic magnitude in ``unit``; distances are divided by it.
        velocity: The velocity that this state imposes, an expression linear in the rates such as
            ``V.x``, if the state is a speed of a kinematic machine.
    """

    name: str
    derivative: Number
    _: KW_ONLY
    limits: tuple[float, float] = (-math.inf, math.inf)
    unit: str = ""
    scale: float = 1.0
    velocity: Number | None = None

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "derivative", *(() if self.velocity is None else ("velocity",)))

    @property
    def symbol(self) -> StateSymbol:
        """The symbol of the state's value."""
        return StateSymbol(self.name)


@checked
def state(name: str) -> StateSymbol:
    """Return the symbol of an auxiliary state, by the state's name, for use in its derivative."""
    return StateSymbol(name)


@checked
def lag(name: str, signal: Number, time_constant: Number, *, unit: str = "") -> State:
    """Return a state that follows a signal with a first-order lag, as actuators do.

    Args:
        name: Name of the state.
        signal: The signal, usually an input's symbol.
        time_constant: In [s].
        unit: Of the signal and the state.
    """
    change = (exact(signal) - StateSymbol(name)) / exact(time_constant)
    return State(name, change, unit=unit)
