"""The rate at which a motion's cost grows, as a scenario's [objective] says it."""

from __future__ import annotations

from collections.abc import Iterator

import sympy

from kinolab.dynamics.language.frames import velocity
from kinolab.dynamics.language.mechanism import Mechanism
from kinolab.dynamics.language.mechanism_parts import loads
from kinolab.dynamics.language.quantities import written
from kinolab.dynamics.symbols.expressions import exact
from kinolab.errors import InputError
from kinolab.problem.objective.formula import formula
from kinolab.scenario import Issue, Scenario, mistake_at, place_at

# [m/s] Of a body at rest: the norm of a speed has no slope at 0. At v it is SLOWEST^2 / 2v more.
SLOWEST = 1e-4


def running_cost(scenario: Scenario, system: Mechanism) -> sympy.Expr:
    """Return the cost per second, in the symbols of a machine.

    Effort is the sum of the inputs' squares, and energy that of what each of them does or takes up,
    |u dP/du| in [W], as actuators need it which get nothing back.

    Raises:
        InputError: If the machine has no such terms, or a formula or a body is none of it.
    """
    section = scenario.objective
    assert section is not None
    squares = (one.symbol**2 for one in system.inputs)
    terms = [
        exact(section.time),
        section.effort * sympy.Add(*squares),
        section.energy and section.energy * sympy.Add(*_powers(scenario, system)),
        section.expression and formula(section.expression, system, _place(scenario, "expression")),
    ]
    frames = {body.name: body.frame for body in system.bodies}
    for name, weight in section.length.items():
        linear = velocity(frames[name]).linear
        terms.append(weight * sympy.sqrt(linear.dot(linear) + SLOWEST**2))
    return sympy.Add(*(term for term in terms if term))


def _powers(scenario: Scenario, system: Mechanism) -> Iterator[sympy.Expr]:
    """Yield the magnitude of each input's power in [W]."""
    for one in system.inputs:
        shares = [*_power_of(one.symbol, system)]
        if not shares:
            what = f"the input {one.name!r} is a given motion, whose power is not known."
            remedy = "Leave energy out, or let the machine be driven by forces."
            issue = Issue(("objective", "energy"), what, remedy)
            raise InputError([mistake_at(issue, scenario.origin)])
        yield sympy.Abs(sympy.Add(*shares))


def _power_of(symbol: sympy.Symbol, system: Mechanism) -> Iterator[sympy.Expr]:
    for _, load in loads(system):
        magnitude = written(load.magnitude)
        share = magnitude - magnitude.xreplace({symbol: sympy.Integer(0)})
        if share != 0:
            yield share * written(load.velocity)


def _place(scenario: Scenario, key: str) -> str:
    return place_at(("objective", key), scenario.origin)
