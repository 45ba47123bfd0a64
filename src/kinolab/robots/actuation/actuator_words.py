"""What acts along lengths of a robot's joints, in words of a machine."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import sympy

from kinolab.dynamics.language.constraints import Requirement, require
from kinolab.dynamics.language.forces import Effort, Load, Potential
from kinolab.dynamics.language.inputs import Control
from kinolab.dynamics.language.quasi_velocities import State, state
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import InputSymbol
from kinolab.robots.actuation.actuators import Actuator, Aim, Filter, Tendon


@dataclass(frozen=True)
class Command:
    """An input, and what pushes at its command.

    Attributes:
        input: The input.
        states: The state that follows it, if any.
        symbol: Of what pushes, the input or the state.
    """

    input: Control
    states: tuple[State, ...]
    symbol: sympy.Symbol


def command(
    name: str, lower: float, upper: float, *, through: Filter | None, follower: str, unit: str = ""
) -> Command:
    """Return an input within limits, which a filter may delay.

    Args:
        lower, upper: Its limits.
        through: The filter, if any.
        unit: Of what pushes.
    """
    if through is None:
        control = Control(name, limit=(lower, upper), unit=unit)
        return Command(control, (), control.symbol)
    lag, own = through.time_constant, state(follower)
    control = Control(
        name, limit=(lower, upper), unit=f"{unit}/s" if unit and lag is None else unit
    )
    change = control.symbol if lag is None else (control.symbol - own) / exact(lag)
    limits, scale = (through.lower, through.upper), max(abs(lower), abs(upper))
    return Command(control, (State(follower, change, limits=limits, unit=unit, scale=scale),), own)


def actuator_efforts(
    actuator: Actuator, pushing: sympy.Symbol, length: sympy.Expr, speed: sympy.Expr
) -> Iterator[Effort]:
    """Yield the forces of an actuator: what its command gives, and a spring and a damper.

    Args:
        pushing: Its input, or the state that follows that.
        length, speed: Along which it acts.
    """
    yield Load(_gain(actuator, length, speed) * pushing, speed)
    if actuator.stiffness:
        rest = exact(actuator.bias / actuator.stiffness)
        yield Potential(actuator.stiffness / 2.0 * (length - rest) ** 2)
    elif actuator.bias:
        yield Load(actuator.bias, speed)
    if actuator.damping:
        yield Load(-actuator.damping * speed, speed)


def force_limits(
    actuator: Actuator, pushing: sympy.Symbol, length: sympy.Expr, speed: sympy.Expr
) -> Iterator[Requirement]:
    """Yield that motions keep an actuator's force within its limits, where MuJoCo would clip it."""
    force = _gain(actuator, length, speed) * pushing + exact(actuator.bias)
    force -= exact(actuator.stiffness) * length + exact(actuator.damping) * speed
    yield from _within(f"the force of {actuator.name}", force, actuator.least, actuator.most)


def aim_limits(aim: Aim, length: sympy.Expr, speed: sympy.Expr) -> Iterator[Requirement]:
    """Yield that a servo pushes as some command lets it.

    The values of a clipped interval are those between its ends that are within the limits, or the
    limit that is nearest, where the interval is beyond it.
    """
    pushes = InputSymbol(aim.input)
    aims = pushes + exact(aim.stiffness) * length + exact(aim.damping) * speed
    below = sympy.Max(aim.upper - aims, aim.least - pushes, evaluate=False)
    above = sympy.Max(aims - aim.lower, pushes - aim.most, evaluate=False)
    yield require(below, f"{aim.input} aims at no more than its ctrlrange allows")
    yield require(above, f"{aim.input} aims at no less than its ctrlrange allows")


def _gain(actuator: Actuator, length: sympy.Expr, speed: sympy.Expr) -> sympy.Expr:
    each, by_length, by_speed = map(exact, actuator.gain)
    return each + by_length * length + by_speed * speed


def spring(stiffness: Sequence[float], x: sympy.Expr) -> Iterator[Effort]:
    """Yield the potential of forces along x with coefficients of x, x^2, …, if any is not 0."""
    powers = enumerate(stiffness, start=2)
    if any(stiffness):
        yield Potential(sympy.Add(*(c * x**k / k for k, c in powers if c)))


def beyond_rest(tendon: Tendon, length: sympy.Expr) -> sympy.Expr:
    """Return by how much the length of a tendon is beyond those in which it is slack."""
    shortest, longest = tendon.rest
    if shortest == longest:
        return length - longest
    above, below = (sympy.Max(x, 0, evaluate=False) for x in (length - longest, shortest - length))
    return above - below


def length_limits(tendon: Tendon, length: sympy.Expr) -> Iterator[Requirement]:
    """Yield that motions keep the length of a tendon within its limits."""
    yield from _within(f"the length of {tendon.name}", length, tendon.lower, tendon.upper)


def _within(what: str, value: sympy.Expr, least: float, most: float) -> Iterator[Requirement]:
    """Yield two requirements, none of a limit that is infinite."""
    if math.isfinite(most):
        yield require(most - value, f"{what} is at most {most:g}")
    if math.isfinite(least):
        yield require(value - least, f"{what} is at least {least:g}")
