"""Evaluation points of rank tests: user-given states, and rational ones near samples."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import tan
from typing import Any

import sympy

from kinolab.dynamics.analysis.fields.vector_fields import VectorFields
from kinolab.dynamics.analysis.jets.scalars import Turn
from kinolab.dynamics.symbols.symbols import QuaternionEntry
from kinolab.errors import InputError, Mistake, UnknownNameError

# rational points are multiples of 1 / RATIONAL_DENOMINATOR, so that their powers stay small
RATIONAL_DENOMINATOR = 16


def complete_point(fields: VectorFields, at: Mapping[Any, Any]) -> dict[str, Any]:
    """Complete a point: missing state entries are 0, attitudes the identity.

    Raises:
        UnknownNameError: If the state has no entry of that name.
    """
    given = {getattr(key, "name", key): value for key, value in at.items()}
    for name in given:
        if name not in (*fields.names, *fields.values):
            raise UnknownNameError("variable", name, known=fields.names)
    upright = {
        s.name: 1.0 for s in fields.symbols if isinstance(s, QuaternionEntry) and s.index == 3
    }
    return dict.fromkeys(fields.names, 0.0) | upright | given


def rational_point(fields: VectorFields, point: Mapping[str, float]) -> dict[str, Any]:
    """Return a rational state near a sampled one: angles with rational sines, unit quaternions.

    Raises:
        InputError: If states must satisfy equations, which may have no rational solution nearby.
    """
    if fields.held:
        remedy = "Give a rational state that satisfies them."
        what = "its states satisfy constraints of position."
        raise InputError([Mistake("exact rank", what, remedy)])
    turning = turning_variables(fields)
    found: dict[str, Any] = {}
    for symbol in fields.symbols:
        value = point[symbol.name]
        found[symbol.name] = _turn(value) if symbol.name in turning else _grained(value)
    for symbol in fields.symbols:
        if isinstance(symbol, QuaternionEntry) and symbol.index == 0:
            found |= _unit_quaternion(symbol, found)
    return found


def turning_variables(fields: VectorFields) -> frozenset[str]:
    """Return the names of variables that occur in sines, cosines or tangents."""
    tape = fields.tape
    nodes = tape.needed([node for parts in fields.components.values() for node in parts])
    inside = frozenset[int]().union(
        *(
            tape.depends_on(node)
            for node in nodes
            if tape.operations[node].name in ("sin", "cos", "tan")
        )
    )
    return frozenset(tape.operations[node].label for node in inside)


def _grained(value: float) -> Fraction:
    return Fraction(round(value * RATIONAL_DENOMINATOR), RATIONAL_DENOMINATOR)


def _turn(value: float) -> Turn:
    """Return an angle near another whose sine and cosine are rational (half-angle tangent)."""
    t = _grained(max(-64.0, min(64.0, tan(value / 2))))
    return Turn((1 - t * t) / (1 + t * t), 2 * t / (1 + t * t))


def _unit_quaternion(symbol: sympy.Symbol, found: Mapping[str, Any]) -> dict[str, Fraction]:
    """Project three rational numbers stereographically onto the unit quaternions."""
    x, y, z, w = (entry.name for entry in symbol.attitude.quaternion)
    square = sum(found[name] ** 2 for name in (x, y, z))
    vector = {name: 2 * found[name] / (1 + square) for name in (x, y, z)}
    return vector | {w: (1 - square) / (1 + square)}
