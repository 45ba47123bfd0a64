"""Force elements: gravity, potentials, loads, and the words that lower themselves to these.

A force says in ``lowered`` as which potentials and loads it acts. What derives, checks or writes a
machine knows these alone, so that a force is one class, here or in another package.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import KW_ONLY, dataclass
from functools import partial
from numbers import Real
from typing import ClassVar

import sympy

from kinolab.arguments import checked, shown
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.frames import (
    AXES,
    Axis,
    Frame,
    Number,
    distance,
    move,
    time_derivative,
)
from kinolab.dynamics.language.quantities import UP, Change, FrameSpeed, apart, place, written
from kinolab.dynamics.language.shapes import ORIGIN, Point
from kinolab.dynamics.symbols.expressions import exact, is_zero, sympify_fields
from kinolab.dynamics.symbols.words import LoweredWord, primitives_of
from kinolab.errors import InputError, Mistake


@checked
@dataclass(frozen=True)
class Gravity:
    """Uniform gravity: ``strength`` in [m/s^2] along the world direction ``down`` (unit vector).

    Both are numbers or expressions of parameters: ``Gravity((sin(slope), 0, -cos(slope)), 9.81)``.
    """

    down: tuple[Number, Number, Number]
    strength: Number

    def __post_init__(self) -> None:
        """Keep numbers of a direction as floats, whose square root is taken in pictures."""
        parts = (float(p) if exact(p).is_number else p for p in self.down)
        object.__setattr__(self, "down", tuple(parts))
        sympify_fields(self, "strength")


@checked
def toward(direction: str, strength: Number = 9.81) -> Gravity:
    """Return gravity along an axis, such as ``toward("-z", 9.81)``; renderings follow.

    Args:
        direction: A world axis with an optional sign: ``"-z"``, ``"+x"``, ``"y"``.
        strength: In [m/s^2].
    """
    signed = direction[:1] in ("+", "-")
    sign, axis = (direction[0], direction[1:]) if signed else ("+", direction)
    if axis not in ("x", "y", "z"):
        remedy = "Use x, y or z with an optional sign, such as '-z'."
        raise InputError([Mistake("gravity", f"{direction!r} is not a direction.", remedy)])
    value = -1.0 if sign == "-" else 1.0
    x, y, z = (value if axis == name else 0.0 for name in "xyz")
    return Gravity((x, y, z), exact(strength))


class Effort(LoweredWord):
    """A force on a machine; its subclasses are frozen dataclasses.

    Attributes:
        size: Name of the attribute that must not be negative, so that it takes energy out, if any.
        dry: Whether it is dry friction, of which that is the strength.
    """

    size: ClassVar[str] = ""
    dry: ClassVar[bool] = False
    wanted = "a list of forces, such as [Load(-k * V.x, V.x)]"

    def __str__(self) -> str:
        """What an error or a report calls it: its kind, and what it acts on."""
        return type(self).__name__.lower()

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, *(name for name, value in vars(self).items() if _is_number(value)))

    def _flaw_of(self, parts: Sequence[object]) -> str:
        """Say why it cannot consist of these primitives, in a sentence; nothing if it can."""
        wrong = next((part for part in parts if not isinstance(part, Effort)), None)
        return "" if wrong is None else f"it is lowered to {shown(wrong)}, which is not a force."

    @property
    def power(self) -> sympy.Expr:
        """The power of its loads in [W], negative where they take energy out."""
        loads = (part for part in primitives_of(self) if isinstance(part, Load))
        return sympy.Add(*(written(e.magnitude) * written(e.velocity) for e in loads))


def _is_number(value: object) -> bool:
    entries = value if isinstance(value, tuple) else (value,)
    return all(isinstance(entry, Real | sympy.Expr) for entry in entries)


@checked
@dataclass(frozen=True)
class Potential(Effort):
    """A potential energy V(q) in [J], such as k theta^2 / 2; the force is -dV/dq."""

    primitive = True
    energy: Number


@checked
@dataclass(frozen=True)
class Load(Effort):
    """A force along a velocity: the generalised force is magnitude * d(velocity)/d(q_dot).

    Source: Kane, Levinson, Dynamics: Theory and Applications, 1985, section 4.4 (generalised active
    forces by partial velocities).

    Attributes:
        magnitude: In [N] or [N m]: an expression in states, inputs and parameters.
        velocity: An expression linear in the rates, in [m/s] or [rad/s], or a speed of a frame.
    """

    primitive = True
    magnitude: Number
    velocity: sympy.Expr | FrameSpeed


@checked
@dataclass(frozen=True)
class Spring(Effort):
    """A linear spring between the origins of two frames.

    Attributes:
        between: The two frames.
        stiffness: In [N/m].
        length: Rest length in [m]; where it is not 0 the origins must not coincide.
    """

    _: KW_ONLY
    between: tuple[Frame, Frame]
    stiffness: Number
    length: Number = 0

    def lowered(self) -> Sequence[Potential | Load]:
        """Return its energy, stiffness / 2 times the square of how much longer it is."""
        stretch = apart(*self.between) - (0 if is_zero(self.length) else self.length)
        return (Potential(self.stiffness * stretch**2 / 2),)


@checked
@dataclass(frozen=True)
class Rope(Effort):
    """A rope or string between the origins of two frames: stretched it pulls, slack it does not.

    With the stretch s = distance - length the tension is max(0, stiffness s + damping s_dot) where
    s > 0, and 0 elsewhere.

    Attributes:
        between: The two frames; their origins must not coincide.
        stiffness: In [N/m]; of a rope of modulus E and cross-section A it is E A / length.
        length: Length of the unstretched rope in [m], positive: a number, or an expression in
            coordinates and parameters. A coordinate in it is a winch, which the tension turns.
        damping: In [N s/m].
    """

    size: ClassVar[str] = "damping"
    _: KW_ONLY
    between: tuple[Frame, Frame]
    stiffness: Number
    length: Number
    damping: Number = 0

    def lowered(self) -> Sequence[Potential | Load]:
        """Return the energy of its stretch, and damping that takes all of the tension at most.

        The stretch is that of the distance or the length, whichever is more: nothing divides by the
        distance of ends that meet while it is slack.
        """
        reach = sympy.Max(apart(*self.between) ** 2, self.length**2, evaluate=False)
        s = sympy.sqrt(reach) - self.length
        elastic = Potential(self.stiffness * s**2 / 2)
        if is_zero(self.damping):
            return (elastic,)
        s_dot = Change(s)
        damped = sympy.Max(self.damping * s_dot, -self.stiffness * s, evaluate=False)
        return elastic, Load(-damped, s_dot)

    @property
    def stretch(self) -> sympy.Expr:
        """How much longer it is than its length in [m]; negative where it is slack."""
        return distance(*self.between) - exact(self.length)

    @property
    def tension(self) -> sympy.Expr:
        """Its tension in [N], never negative, for use in requirements."""
        s = self.stretch
        return self.tension_at(s, time_derivative(s))

    def tension_at(self, stretch: sympy.Expr, change: sympy.Expr) -> sympy.Expr:
        """Return its tension in [N] at a stretch in [m] and the change of it in [m/s]."""
        force = exact(self.stiffness) * stretch + exact(self.damping) * change
        return (1 + sympy.sign(stretch)) / 2 * sympy.Max(0, force, evaluate=False)


@checked
@dataclass(frozen=True)
class Buoyancy(Effort):
    """A constant lift against gravity at a point of a body.

    Attributes:
        on: The body.
        lift: In [N]; equal to the weight for neutral buoyancy.
        at: The centre of buoyancy in the body's frame, in [m].
    """

    _: KW_ONLY
    on: Body
    lift: Number
    at: Point = ORIGIN

    def lowered(self) -> Sequence[Potential | Load]:
        """Return its energy, which falls as the point rises."""
        height = sympy.Matrix(UP).dot(place(_point(self.on.frame, self.at)))
        return (Potential(-self.lift * height),)


class Friction(Effort):
    """A force against velocities; ``kind`` is what a report calls it."""

    kind: ClassVar[str]

    def __str__(self) -> str:
        """What an error or a report calls it."""
        loads = (part for part in primitives_of(self) if isinstance(part, Load))
        return f"{self.kind} friction of {' and '.join(str(load.velocity) for load in loads)}"


@checked
@dataclass(frozen=True)
class Viscous(Friction):
    """Viscous friction: the force -coefficient * velocity along a velocity.

    Attributes:
        velocity: An expression linear in the rates, such as ``rate(phi)`` or ``V.x``.
        coefficient: In [N s/m] or [N m s/rad].
    """

    kind: ClassVar[str] = "viscous"
    size: ClassVar[str] = "coefficient"
    velocity: Number
    coefficient: Number

    def lowered(self) -> Sequence[Potential | Load]:
        """Return the force along the velocity."""
        return (Load(-(self.coefficient * self.velocity), self.velocity),)


@checked
@dataclass(frozen=True)
class Coulomb(Friction):
    """Regularised Coulomb friction: the force -strength * tanh(velocity / smoothing).

    Attributes:
        velocity: An expression linear in the rates.
        strength: Friction coefficient times normal force, in [N] or [N m]; may be an expression.
        smoothing: Velocity at 76 % of the full force, in [m/s] or [rad/s]; smaller values are
            stiffer.
    """

    kind: ClassVar[str] = "Coulomb"
    size: ClassVar[str] = "strength"
    dry: ClassVar[bool] = True
    velocity: Number
    strength: Number
    smoothing: Number = 0.01

    def lowered(self) -> Sequence[Potential | Load]:
        """Return the force along the velocity."""
        slip = sympy.tanh(exact(self.velocity) / self.smoothing)
        return (Load(-(self.strength * slip), self.velocity),)


@checked
@dataclass(frozen=True)
class SlidingFriction(Friction):
    """Regularised Coulomb friction of a contact that slides in a plane, alike in every direction.

    The force is -strength * slip / sqrt(|slip|^2 + smoothing^2), against the slip as a vector: what
    a tyre needs across its tread is lost along it (the friction circle).

    Attributes:
        slip: Velocities along two perpendicular directions in the plane, linear in the rates, such
            as ``(V.x - r * rate(phi), V.y)``, in [m/s].
        strength: Friction coefficient times normal force, in [N]; may be an expression.
        smoothing: Slip at 71 % of the full force, in [m/s]; smaller values are stiffer.
    """

    kind: ClassVar[str] = "sliding"
    size: ClassVar[str] = "strength"
    dry: ClassVar[bool] = True
    slip: tuple[Number, Number]
    strength: Number
    smoothing: Number = 0.01

    def lowered(self) -> Sequence[Potential | Load]:
        """Return the force along each of the two velocities."""
        size = sympy.sqrt(sum(exact(v) ** 2 for v in (*self.slip, self.smoothing)))
        return tuple(Load(-(self.strength * v / size), v) for v in self.slip)


@checked
@dataclass(frozen=True)
class Wrench(Effort):
    """A force and torque on a body, as expressions in states, inputs and parameters.

    Attributes:
        on: The body.
        force: Components in the body's axes, in [N].
        torque: Components in the body's axes, in [N m].
        at: Point of application in the body's frame, in [m].
        reacts_on: The body that takes the reaction, on the same line; the world when left out.
    """

    _: KW_ONLY
    on: Body
    force: Point = ORIGIN
    torque: Point = ORIGIN
    at: Point = ORIGIN
    reacts_on: Body | None = None

    def lowered(self) -> Sequence[Potential | Load]:
        """Return its components along the axes of the body."""
        point = _point(self.on.frame, self.at)
        axes = [Axis(self.on.frame, name) for name in AXES]
        speeds = [partial(FrameSpeed, axis=axis, at=point) for axis in axes]
        turns = [partial(FrameSpeed, axis=axis) for axis in axes]
        along: list[Callable[[Frame], FrameSpeed]] = [*speeds, *turns]
        parts = zip((*self.force, *self.torque), along, strict=True)
        return [
            load for part, speed in parts for load in both(part, speed, self.on, self.reacts_on)
        ]

    def __str__(self) -> str:
        """What an error or a report calls it."""
        return f"wrench on body {self.on.name!r}"


def both(
    magnitude: Number, speed: Callable[[Frame], FrameSpeed], on: Body, reacts_on: Body | None
) -> Iterator[Load]:
    """Yield a load on a body and its reaction on another, none of a magnitude that is 0.

    Args:
        magnitude: In [N] or [N m].
        speed: Of a frame, along which the load acts.
        on: The body.
        reacts_on: The body that takes the reaction; the world if None.
    """
    if not is_zero(magnitude):
        yield Load(magnitude, speed(on.frame))
        if reacts_on is not None:
            yield Load(-magnitude, speed(reacts_on.frame))


def _point(frame: Frame, at: Point) -> Frame:
    """Return a frame at a point of another."""
    return frame if all(map(is_zero, at)) else frame @ move(*at)


FORCES: tuple[type[Effort], ...] = (
    *(Buoyancy, Coulomb, Load, Potential, Rope, SlidingFriction, Spring, Viscous, Wrench),
)
