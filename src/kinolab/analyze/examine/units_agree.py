"""Whether what is added has one unit, and whether forces, energies and rates have theirs.

Numbers may stand for anything, as 2 does in a drag of 2 * v**2, and so may what has no unit: only
what is certain is told. Halves and signs have none, but for the half of a mass as an inertia, as
m / 4 and m / 12 have of 1 m^2.

Source: Bridgman, Dimensional Analysis, 1922, chapter 2 (terms of a sum have one dimension).
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, TypeAlias

import sympy

from kinolab.analyze.examine.remarks.remark import Remark
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.dynamics.language.mechanism_parts import coordinate_of, energies_in, loads_in
from kinolab.dynamics.language.quantities import Change, FrameSpeed, Place
from kinolab.dynamics.symbols.expressions import exact
from kinolab.dynamics.symbols.symbols import (
    Coordinate,
    InputSymbol,
    Parameter,
    RateSymbol,
    StateSymbol,
)

Dimension: TypeAlias = tuple[Fraction, ...]  # exponents of m, kg, s and A
Stated: TypeAlias = tuple[tuple[str, str], str, Any, str]  # part, about, expression, unit due

NONE: Dimension = (Fraction(0),) * 4
# BIPM, The International System of Units, 9th ed., 2019, tables 2 and 4.
UNITS = {
    "rad": (0, 0, 0, 0), "1": (0, 0, 0, 0), "m": (1, 0, 0, 0), "kg": (0, 1, 0, 0),
    "s": (0, 0, 1, 0), "A": (0, 0, 0, 1), "N": (1, 1, -2, 0), "J": (2, 1, -2, 0),
    "W": (2, 1, -3, 0), "V": (2, 1, -3, -1), "ohm": (2, 1, -3, -2), "Ω": (2, 1, -3, -2),
    "H": (2, 1, -2, -2), "F": (-2, -1, 4, 2), "C": (0, 0, 1, 1), "T": (0, 1, -2, -1),
    "Wb": (2, 1, -2, -1), "Pa": (-1, 1, -2, 0), "Hz": (0, 0, -1, 0),
}  # fmt: skip
INERTIA = "kg m^2"
HARMLESS = frozenset({sympy.Integer(-1), sympy.Rational(1, 2), sympy.Rational(-1, 2)})
FACTOR = re.compile(r"([A-Za-zΩ]+|1)(?:\^(-?\d+(?:\.\d+)?))?$")


class UnlikeTermsError(Exception):
    """A sum of terms of two dimensions, which are its arguments with them."""


def units_agree(subject: Subject) -> Iterator[Remark]:
    """Yield the words of a machine with a sum of unlike terms, or of another unit than is due."""
    told = set[tuple[str, str]]()
    scale = _Scale(subject)
    for part, about, expression, unit in _stated(subject):
        try:
            found = scale.of(expression)
        except UnlikeTermsError as unlike:
            one, first, other, second = unlike.args
            what = f"{one} is in {_text(first)} and {other} in {_text(second)}, and they are added "
            what += "to each other: is one a coordinate where its rate is meant, or without a "
            what += "factor?"
        else:
            if found is None or not unit or found == parsed(unit):
                continue
            halved = exact(expression).as_coeff_Mul()[0] == sympy.Rational(1, 2)
            if halved and (found, unit) == (parsed("kg"), INERTIA):
                continue
            what = f"{expression} is in {_text(found)}, and it stands where {unit} is due: is a "
            what += "coordinate there where its rate is meant, or is a factor missing?"
        if (part[0], about) not in told:
            told.add((part[0], about))
            yield Remark("units that do not match", about, what, part)


def _stated(subject: Subject) -> Iterator[Stated]:
    """Yield the expressions of a machine, each with the unit that is due; empty for any."""
    system = subject.system
    if system.gravity is not None:
        yield ("toward", ""), "gravity", system.gravity.strength, "m/s^2"
    for body in system.bodies:
        part = ("Body", body.name)
        yield part, body.name, body.mass, "kg"
        yield from ((part, body.name, entry, INERTIA) for entry in body.inertia_matrix)
        for motion in body.frame.motions:
            yield from ((part, body.name, entry, "m") for entry in getattr(motion, "by", ()))
            yield part, body.name, getattr(motion, "angle", 0), "rad"
    for effort in system.efforts:
        part, about = (type(effort).__name__, ""), str(effort)
        yield from ((part, about, energy, "J") for energy in energies_in(effort))
        for load in loads_in(effort):
            speed = load.velocity
            if isinstance(speed, FrameSpeed):
                yield part, about, load.magnitude, "N m" if speed.at is None else "N"
            else:
                yield part, about, load.magnitude, ""
                yield part, about, exact(load.magnitude) * exact(speed), "W"
    for state in system.states:
        unit = f"{state.unit}/s" if state.unit else ""
        yield ("State", state.name), state.name, state.derivative, unit
    for held in system.constraints:
        yield ("zero", held.name), held.name, held.stated, ""
    for wish in system.requirements:
        yield ("require", wish.name), wish.name, wish.margin, ""


class _Scale:
    """Says of which dimension expressions of a machine are."""

    def __init__(self, subject: Subject) -> None:
        units = {entry.name: entry.unit for entry in subject.system.inputs}
        self._units = units | {state.name: state.unit for state in subject.system.states}

    def of(self, expression: Any) -> Dimension | None:
        """Return the dimension of an expression; None if it may be any.

        Raises:
            UnlikeTermsError: If it holds a sum of unlike terms.
        """
        return self._of(exact(expression))

    def _of(self, e: sympy.Expr) -> Dimension | None:
        if isinstance(e, sympy.Symbol):
            return self._symbol(e)
        if isinstance(e, sympy.Add | sympy.Max | sympy.Min):
            known = [(term, found) for term in e.args if (found := self._of(term)) is not None]
            for term, found in known[1:]:
                if found != known[0][1]:
                    raise UnlikeTermsError(*known[0], term, found)
            return known[0][1] if known else None
        parts = [self._of(a) for a in e.args if a not in HARMLESS or not e.is_Mul]
        if isinstance(e, sympy.Abs):
            return parts[0]
        if isinstance(e, sympy.sin | sympy.cos | sympy.tan | sympy.sign):
            return NONE
        if e.is_Pow and e.exp.is_Rational and parts[0] is not None:
            power = Fraction(int(e.exp.p), int(e.exp.q))
            return tuple(power * exponent for exponent in parts[0])
        if e.is_Mul and None not in parts:
            return tuple(map(sum, zip(*parts, strict=True)))  # type: ignore[arg-type]
        return None

    def _symbol(self, symbol: sympy.Symbol) -> Dimension | None:
        if isinstance(symbol, Change):
            place = self._of(exact(symbol.position))
            return None if place is None else _times(place, parsed("1/s"))
        owner = coordinate_of(symbol)
        if isinstance(symbol, RateSymbol):
            unit = f"{symbol.coordinate.unit}/s" if symbol.coordinate.unit else ""
        elif isinstance(symbol, Parameter | Coordinate):
            unit = symbol.unit
        elif isinstance(symbol, InputSymbol | StateSymbol):
            unit = self._units.get(symbol.name, "")
        elif isinstance(symbol, Place):
            unit = "m"
        else:  # an entry of a rotation, or a rate of one
            unit = "" if owner is None else "rad/s" if symbol in owner.rates else "1"
        return parsed(unit)


def parsed(unit: str) -> Dimension | None:
    """Return the dimension of a unit such as ``N s/m``; None where it cannot be read for sure."""
    found = NONE
    for k, below in enumerate(unit.replace("*", " ").replace("²", "^2").split("/")):
        factors = below.split()
        if not factors or (k and len(factors) > 1):
            return None  # N/m s may be N/(m s)
        for factor in factors:
            read = FACTOR.match(factor)
            if read is None or read[1] not in UNITS:
                return None
            power = Fraction(read[2] or 1) * (-1 if k else 1)
            found = _times(found, tuple(power * e for e in UNITS[read[1]]))
    return found


def _times(one: Dimension, other: Dimension | None) -> Dimension:
    return tuple(a + b for a, b in zip(one, other or NONE, strict=True))


def _text(dimension: Dimension) -> str:
    """Return a dimension as a unit: a known one where there is one."""
    for name, exponents in UNITS.items():
        for more, power in (("", 0), (" m", 1), (" s", 1), ("/s", -1), ("/m", -1)):
            extra = tuple(power * e for e in UNITS.get(more.strip(" /"), NONE))
            if dimension == tuple(map(sum, zip(exponents, extra, strict=True))):
                return "no unit" if not any(dimension) else f"{name}{more}"
    powers = [(name, e) for name, e in zip(("m", "kg", "s", "A"), dimension, strict=True) if e]
    return " ".join(name if e == 1 else f"{name}^{e}" for name, e in powers)
