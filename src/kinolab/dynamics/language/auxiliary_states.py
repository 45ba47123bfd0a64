"""States with a rate of their own: currents, lags, speeds of what is moved and not pushed."""

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
    """A further state with its own differential equation.

    Attributes:
        name: What scenarios and files call it.
        derivative: Its rate of change, an expression in states, inputs and parameters; ``state``
            gives the symbol that stands for the state itself.
        limits: Lower and upper limit in ``unit``.
        unit: SI unit as text.
        scale: What counts as a large difference, in ``unit``.
        velocity: What moves at this value, an expression linear in the rates such as ``V.x``, if
            the state is a speed of a kinematic machine.
    """

    name: str
    derivative: Number
    _: KW_ONLY
    limits: tuple[float, float] = (-math.inf, math.inf)
    unit: str = ""
    scale: float = 1.0
    velocity: Number | None = None

    def __post_init__(self) -> None:
        """Let numbers stand for expressions."""
        sympify_fields(self, "derivative", *(() if self.velocity is None else ("velocity",)))

    @property
    def symbol(self) -> StateSymbol:
        """The symbol of the state's value."""
        return StateSymbol(self.name)


@checked
def state(name: str) -> StateSymbol:
    """Return the symbol of a further state, to write its own derivative with."""
    return StateSymbol(name)


@checked
def lag(name: str, signal: Number, time_constant: Number, *, unit: str = "") -> State:
    """Return a state that follows a signal with a first-order lag, as an actuator does.

    Args:
        name: Of the state.
        signal: What it follows, usually an input's symbol.
        time_constant: In [s].
        unit: Of the signal and the state.
    """
    change = (exact(signal) - StateSymbol(name)) / exact(time_constant)
    return State(name, change, unit=unit)
