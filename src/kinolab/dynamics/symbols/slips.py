"""Slips of those who know NumPy and SymPy: what they meant, and how it is written here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NoReturn

import numpy as np

from kinolab.errors import InputError, Mistake

FUNCTIONS = "Write from sympy import cos, sin, sqrt, … instead."
CHOICES = "Write sympy.Max(q, 0), or sympy.Piecewise((first, q > 0), (second, True))."
DERIVATIVES = {
    **dict.fromkeys(("dot", "dt", "deriv", "derivative", "velocity", "vel"), "rate({})"),
    **dict.fromkeys(("ddot", "dotdot", "acceleration", "acc"), "acceleration({})"),
}


class SlipError(InputError, TypeError, AttributeError):
    """A slip of this kind; it is also what Python raises for it, as those expect who try."""


def slipped(where: str, what: str, remedy: str) -> NoReturn:
    """Raise a slip.

    Raises:
        SlipError: That says where, what, and what would work.
    """
    raise SlipError([Mistake(where, what, remedy)])


def no_number(symbol: object, *_: object) -> NoReturn:
    """Refuse to give the number for which a function of math or NumPy asks.

    Raises:
        SlipError: That says which function would work.
    """
    slipped(str(symbol), "it is a symbol, and math and NumPy know numbers alone.", FUNCTIONS)


def attribute(symbol: object, name: str) -> Callable[..., Any]:
    """Return what an attribute that symbols do not have would be, for NumPy; raise for others.

    Raises:
        SlipError: If it is how time derivatives are written elsewhere.
        AttributeError: If it is anything else.
    """
    if isinstance(getattr(np, name, None), np.ufunc):
        return lambda *arguments: no_number(symbol, *arguments)
    if name in DERIVATIVES:
        slipped(f"{symbol}.{name}", "symbols have no such attribute.", written(symbol, name))
    raise AttributeError(f"{type(symbol).__name__!r} object has no attribute {name!r}")


def written(symbol: object, name: str = "dot") -> str:
    """Say how a time derivative of a coordinate is written."""
    return f"Write {DERIVATIVES[name].format(symbol)} for its time derivative."


def remedy_for(error: BaseException) -> str:
    """Say what would work in place of a call that numbers were needed for; empty where unknown.

    Expressions of symbols are SymPy's own, whose errors do not name what was meant.
    """
    told = str(error)
    if not isinstance(error, TypeError):
        return ""
    if "truth value of Relational" in told:
        return f"The machine decides this as it moves, and not when it is described. {CHOICES}"
    numeric = ("convert expression to float", "loop of ufunc", "Cannot round symbolic")
    known = any(one in told for one in numeric)
    return f"math and NumPy know numbers alone. {FUNCTIONS}" if known else ""
