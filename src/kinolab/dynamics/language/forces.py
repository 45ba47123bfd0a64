"""Force elements: gravity, potentials, springs, ropes, buoyancy, friction and wrenches."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass
from typing import TypeAlias

import sympy

from kinolab.arguments import checked
from kinolab.dynamics.language.bodies import Body
from kinolab.dynamics.language.expressions import exact, sympify_fields
from kinolab.dynamics.language.frames import (
    Frame,
    Number,
    distance,
    move,
    pose,
    time_derivative,
    velocity,
)
from kinolab.dynamics.language.shapes import ORIGIN, Point
from kinolab.errors import InputError, Mistake


@checked
@dataclass(frozen=True)
class Gravity:
    """Uniform gravity: ``strength`` in [m/s^2] along the world direction ``down`` (unit vector)."""

    down: tuple[float, float, float]
    strength: sympy.Expr


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


@checked
@dataclass(frozen=True)
class Potential:
    """A potential energy V(q) in [J], such as k theta^2 / 2; the force is -dV/dq."""

    energy: Number

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "energy")


@checked
@dataclass(frozen=True)
class Spring:
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

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "stiffness", "length")


@checked
@dataclass(frozen=True)
class Rope:
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

    _: KW_ONLY
    between: tuple[Frame, Frame]
    stiffness: Number
    length: Number
    damping: Number = 0

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "stiffness", "length", "damping")

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
        taut = (1 + sympy.sign(stretch)) / 2
        force = exact(self.stiffness) * stretch + exact(self.damping) * change
        return taut * sympy.Max(0, force, evaluate=False)


@checked
@dataclass(frozen=True)
class Buoyancy:
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

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "lift", "at")


@checked
@dataclass(frozen=True)
class Viscous:
    """Viscous friction: the force -coefficient * velocity along a velocity.

    Attributes:
        velocity: An expression linear in the rates, such as ``rate(phi)`` or ``V.x``.
        coefficient: In [N s/m] or [N m s/rad].
    """

    velocity: Number
    coefficient: Number

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "velocity", "coefficient")

    @property
    def power(self) -> sympy.Expr:
        """Its power in [W], negative where it takes energy out."""
        return -exact(self.coefficient) * exact(self.velocity) ** 2


@checked
@dataclass(frozen=True)
class Coulomb:
    """Regularised Coulomb friction: the force -strength * tanh(velocity / smoothing).

    Attributes:
        velocity: An expression linear in the rates.
        strength: Friction coefficient times normal force, in [N] or [N m]; may be an expression.
        smoothing: Velocity at 76 % of the full force, in [m/s] or [rad/s]; smaller values are
            stiffer.
    """

    velocity: Number
    strength: Number
    smoothing: Number = 0.01

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "velocity", "strength", "smoothing")

    @property
    def power(self) -> sympy.Expr:
        """Its power in [W], negative where it takes energy out."""
        v = exact(self.velocity)
        return -exact(self.strength) * v * sympy.tanh(v / exact(self.smoothing))


@checked
@dataclass(frozen=True)
class SlidingFriction:
    """Regularised Coulomb friction of a contact that slides in a plane, alike in every direction.

    The force is -strength * slip / sqrt(|slip|^2 + smoothing^2), against the slip as a vector: what
    a tyre needs across its tread is lost along it (the friction circle).

    Attributes:
        slip: Velocities along two perpendicular directions in the plane, linear in the rates, such
            as ``(V.x - r * rate(phi), V.y)``, in [m/s].
        strength: Friction coefficient times normal force, in [N]; may be an expression.
        smoothing: Slip at 71 % of the full force, in [m/s]; smaller values are stiffer.
    """

    slip: tuple[Number, Number]
    strength: Number
    smoothing: Number = 0.01

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "slip", "strength", "smoothing")

    @property
    def power(self) -> sympy.Expr:
        """Its power in [W], negative where it takes energy out."""
        square = sum(exact(v) ** 2 for v in self.slip)
        return -exact(self.strength) * square / sympy.sqrt(square + exact(self.smoothing) ** 2)


@checked
@dataclass(frozen=True)
class Wrench:
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

    def __post_init__(self) -> None:
        """Convert numbers to expressions."""
        sympify_fields(self, "force", "torque", "at")

    @property
    def power(self) -> sympy.Expr:
        """Its power in [W], less that of its reaction."""
        point = self.on.frame @ move(*map(exact, self.at))
        moves, force, torque = velocity(point), sympy.Matrix(self.force), sympy.Matrix(self.torque)
        power = force.dot(moves.linear) + torque.dot(moves.angular)
        if self.reacts_on is None:
            return power
        turned, place = pose(point)
        other, (axes, origin) = velocity(self.reacts_on.frame), pose(self.reacts_on.frame)
        angular = axes * other.angular
        linear = axes * other.linear + angular.cross(place - origin)
        return power - (turned * force).dot(linear) - (turned * torque).dot(angular)


Friction: TypeAlias = Viscous | Coulomb | SlidingFriction
Effort: TypeAlias = Potential | Spring | Rope | Buoyancy | Friction | Wrench


def friction_velocities(friction: Friction) -> tuple[Number, ...]:
    """Return the velocities that friction acts against."""
    return friction.slip if isinstance(friction, SlidingFriction) else (friction.velocity,)


def friction_strength(friction: Friction) -> tuple[str, sympy.Expr]:
    """Return what must not be negative, so that friction takes energy out, and its name."""
    name = "coefficient" if isinstance(friction, Viscous) else "strength"
    return name, exact(getattr(friction, name))


def effort_name(effort: Effort) -> str:
    """Return what an error or a report calls a force: its kind, and what it acts on."""
    match effort:
        case Viscous():
            return f"viscous friction of {effort.velocity}"
        case Coulomb():
            return f"Coulomb friction of {effort.velocity}"
        case SlidingFriction():
            return f"sliding friction of {effort.slip[0]} and {effort.slip[1]}"
        case Wrench():
            return f"wrench on body {effort.on.name!r}"
        case _:
            return type(effort).__name__.lower()
