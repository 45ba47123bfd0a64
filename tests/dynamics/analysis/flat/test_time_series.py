"""Series in time and their derivatives, against SymPy's series of the same functions."""

from __future__ import annotations

import numpy as np
import pytest
import sympy

from kinolab.dynamics.analysis.flat.time_series import series_of
from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.dynamics.derivation.lowering import Lowering

t, s, a, b = sympy.symbols("t s a b")
ORDERS = 5
# functions of time, with a parameter s at 0 by which they are differentiated
GIVEN = {a: sympy.Rational(2, 5) + t / 3 - t**2 / 7 + s * (1 + t), b: 2 - t + t**3 + s * t}


@pytest.mark.parametrize(
    "function",
    [
        *(a * b, a / b, a - b / 3, 1 / (a + b), sympy.sin(a) * sympy.cos(b), sympy.tan(a)),
        *(sympy.exp(a * b), sympy.sqrt(b) + sympy.log(b), sympy.tanh(a), sympy.atan(a / b)),
    ],
    ids=str,
)
def test_series_and_their_derivatives_are_those_of_sympy(function: sympy.Expr) -> None:
    tape = ExpressionGraph()
    node = Lowering(tape, {one: tape.variable(one.name) for one in GIVEN})(function)
    (found,) = series_of(tape, [node], {one.name: table(given) for one, given in GIVEN.items()})
    expected = table(function.subs(GIVEN))
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-11)


def table(function: sympy.Expr) -> np.ndarray:
    """Return Taylor coefficients in t at s = 0 and their derivatives by s, shape (ORDERS, 2)."""
    columns = []
    for part in (function, function.diff(s)):
        values = [part.diff(t, k).subs({t: 0, s: 0}) / sympy.factorial(k) for k in range(ORDERS)]
        columns.append([float(value) for value in values])
    return np.array(columns).T
