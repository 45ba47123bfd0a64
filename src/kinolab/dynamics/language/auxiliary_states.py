"""Auxiliary states with differential equations of their own: currents, lags, imposed speeds."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, dataclass

from kinolab.arguments import checked
from kinolab.dynamics.language.expressions import exact, sympify_fields
from kinolab.dynamics.language.frames import Number
from kinolab.dynamics.language.symbols import StateSymbol


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
