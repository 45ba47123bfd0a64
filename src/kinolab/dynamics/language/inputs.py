"""Control inputs: forces, torques, tensions, velocities and accelerations, with limits.

An input says in ``lowered`` what it consists of: a symbol with limits (``Control``) and the loads
that it is in, an imposed velocity (``Rate``) or an imposed acceleration (``Drive``).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass
from functools import partial
from numbers import Real
from typing import TYPE_CHECKING, ClassVar, Protocol, TypeAlias

from kinolab.arguments import checked
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.forces import Load, both
from kinolab.dynamics.language.frames import Axis, Frame, Number
from kinolab.dynamics.language.quantities import Change, FrameSpeed, apart
from kinolab.dynamics.symbols.dimensions import rate_unit_of
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import Coordinate, InputSymbol, rate
from kinolab.dynamics.symbols.words import LoweredWord
from kinolab.errors import InputError, Mistake

Limit: TypeAlias = float | tuple[float, float]


@dataclass(frozen=True)
class Input(LoweredWord):
    """A control input; ``name`` is used in scenarios and files.

    Subclasses are frozen dataclasses with a ``limit``.
    """

    if TYPE_CHECKING:

        @property
        def limit(self) -> Limit:
            """Largest magnitude, or (lower, upper), in ``unit``."""

        @property
        def unit(self) -> str:
            """SI unit as text."""

    else:
        unit = ""

    remedy: ClassVar[str] = "Let it act on a body that it can move, or leave it out."
    wanted = "a list with one Control, Rate or Drive of its name and limit, and loads"

    name: str

    def _flaw_of(self, parts: Sequence[object]) -> str:
        """Say why it cannot consist of these primitives, in a sentence; nothing if it can.

        What is planned with is its name and limit, and what is read from files those of the parts.
        """
        own = [part for part in parts if isinstance(part, Input)]
        other = [part for part in parts if not isinstance(part, Input | Load)]
        if len(own) != 1 or other:
            kinds = ", ".join(type(part).__name__ for part in parts) or "nothing"
            return f"it is lowered to {kinds}."
        part, limit = own[0], getattr(self, "limit", None)
        same = part.limit is limit or _range(part.limit) == _range(limit)
        if part.name != self.name or not same:
            said = f"it is {self.name!r} with the limit {limit}"
            return f"{said}, and lowered to {part.name!r} with the limit {part.limit}."
        return ""

    def __str__(self) -> str:
        """What an error calls it."""
        return f"input {self.name!r}"

    @property
    def symbol(self) -> InputSymbol:
        """The symbol of the input's value."""
        return InputSymbol(self.name)


@checked
@dataclass(frozen=True)
class Torque(Input):
    """An input torque in [N m] on a body about an axis.

    Attributes:
        name: Its name in scenarios and files.
        on: The body it acts on.
        about: The axis, fixed in its frame, with which it moves.
        limit: Largest magnitude, or (lower, upper), in [N m].
        reacts_on: The body that takes the reaction torque; the world when left out.
    """

    _: KW_ONLY
    on: Body
    about: Axis
    limit: Limit
    reacts_on: Body | None = None
    unit: ClassVar[str] = "N m"

    def lowered(self) -> Sequence[Input | Load]:
        """Return its symbol, and the torque on both bodies."""
        turn = partial(FrameSpeed, axis=self.about)
        loads = both(self.symbol, turn, self.on, self.reacts_on)
        return (Control(self.name, limit=self.limit, unit=self.unit), *loads)


@checked
@dataclass(frozen=True)
class Force(Input):
    """An input force in [N] on a body's centre of mass along an axis.

    Attributes:
        name: Its name in scenarios and files.
        on: The body it acts on.
        along: The axis, fixed in its frame, with which it moves.
        limit: Largest magnitude, or (lower, upper), in [N].
        reacts_on: The body that takes the reaction, on the same line; the world when left out.
    """

    _: KW_ONLY
    on: Body
    along: Axis
    limit: Limit
    reacts_on: Body | None = None
    unit: ClassVar[str] = "N"

    def lowered(self) -> Sequence[Input | Load]:
        """Return its symbol, and the force on both bodies."""
        speed = partial(FrameSpeed, axis=self.along, at=self.on.frame)
        loads = both(self.symbol, speed, self.on, self.reacts_on)
        return (Control(self.name, limit=self.limit, unit=self.unit), *loads)


@checked
@dataclass(frozen=True)
class Pull(Input):
    """An input tension in [N] between two frames' origins, as of a rope or muscle.

    Attributes:
        name: Its name in scenarios and files.
        between: The two frames; their origins must not coincide.
        limit: Largest tension, or (lower, upper), in [N]; a single number means from 0 to it.
    """

    _: KW_ONLY
    between: tuple[Frame, Frame]
    limit: Limit
    unit: ClassVar[str] = "N"

    def __post_init__(self) -> None:
        """Expand a single limit to (0, limit): a rope only pulls."""
        if not isinstance(self.limit, tuple):
            object.__setattr__(self, "limit", (0.0, float(self.limit)))

    def lowered(self) -> Sequence[Input | Load]:
        """Return its symbol, and the tension against the distance."""
        tension = Load(-self.symbol, Change(apart(*self.between)))
        return Control(self.name, limit=self.limit, unit=self.unit), tension


@checked
@dataclass(frozen=True)
class Rate(Input):
    """An input that imposes a velocity, for kinematic machines.

    Attributes:
        name: Its name in scenarios and files.
        on: A coordinate whose rate it is, or any expression linear in the rates, such as ``V.x``.
        limit: Largest magnitude, or (lower, upper), in the unit of the velocity.
    """

    primitive = True
    _: KW_ONLY
    on: Number
    limit: Limit

    @property
    def velocity(self) -> Number:
        """The imposed velocity, an expression linear in the rates."""
        return rate(self.on) if isinstance(self.on, Coordinate) else self.on

    @property
    def unit(self) -> str:
        """Unit of the input."""
        return rate_unit_of(exact(self.velocity))


@checked
@dataclass(frozen=True)
class Drive(Input):
    """An input that imposes the acceleration of a coordinate, whatever force that takes.

    Attributes:
        name: Its name in scenarios and files.
        on: The coordinate.
        limit: Largest magnitude, or (lower, upper), in its unit per s^2.
    """

    primitive = True
    _: KW_ONLY
    on: Coordinate
    limit: Limit
    remedy: ClassVar[str] = "Let it drive a coordinate that is free to move."

    @property
    def unit(self) -> str:
        """Unit of the input."""
        return f"{self.on.unit}/s^2"


@checked
@dataclass(frozen=True)
class Control(Input):
    """An input used in expressions: ``throttle.symbol`` in a wrench or a motor.

    Attributes:
        name: Its name in scenarios and files.
        limit: Largest magnitude, or (lower, upper), in ``unit``.
        unit: SI unit as text, empty if dimensionless.
    """

    primitive = True
    _: KW_ONLY
    limit: Limit
    unit: str = ""


INPUTS: tuple[type[Input], ...] = (Control, Drive, Force, Pull, Rate, Torque)


def _range(limit: object) -> object:
    return (-limit, limit) if isinstance(limit, Real) else limit


class Limited(Protocol):
    """Anything with limits: an input, or a reference of a feedback law."""

    @property
    def name(self) -> str:
        """Its name in scenarios and files."""

    @property
    def limit(self) -> Limit:
        """Largest magnitude, or (lower, upper)."""


def bounds_of(entry: Limited, kind: str = "input") -> tuple[float, float]:
    """Return the limits of an input or reference as (lower, upper).

    Raises:
        InputError: If they are not finite, or lower is not below upper.
    """
    limit = entry.limit
    lower, upper = limit if isinstance(limit, tuple) else (-limit, limit)
    if not (math.isfinite(lower) and math.isfinite(upper) and lower < upper):
        remedy = "Give a positive magnitude, or (lower, upper), finite."
        raise InputError([Mistake(f"{kind} {entry.name!r}", f"its limit is {limit!r}.", remedy)])
    return float(lower), float(upper)
