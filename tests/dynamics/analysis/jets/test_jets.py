"""Jets are the Taylor polynomials that SymPy finds."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from kinolab.dynamics.analysis.jets.jet_evaluation import jets_of
from kinolab.dynamics.analysis.jets.jets import jet_space, size_of, work_of
from kinolab.dynamics.analysis.jets.scalars import Floats, Rationals, Turn, rational
from kinolab.dynamics.analysis.jets.taylor_series import taylor
from kinolab.dynamics.derivation.expression_graph import UNARY, ExpressionGraph
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.errors import InputError

x, y, h = sp.symbols("x y h", real=True)
FUNCTIONS = {
    **{name: getattr(sp, name) for name in ("sin", "cos", "tan", "exp", "log", "sqrt", "tanh")},
    "atan": sp.atan,
    "fabs": sp.Abs,
    "sign": sp.sign,
}


def test_every_function_of_a_tape_has_a_series() -> None:
    assert set(FUNCTIONS) == set(UNARY)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("at", [0.7, 1.3])
def test_series_are_those_of_sympy(name: str, at: float) -> None:
    found = taylor(name, at, 5, lambda f, value: UNARY[f](value))
    function = FUNCTIONS[name](h)
    derivatives = [sp.diff(function, h, k) if k else function for k in range(6)]
    expected = [
        float(d.subs(h, at).doit()) / float(sp.factorial(k)) for k, d in enumerate(derivatives)
    ]
    np.testing.assert_allclose(found, expected, rtol=1e-13, atol=1e-15)


def test_absolute_values_have_the_slope_of_their_side() -> None:
    assert taylor("fabs", -2.0, 2, lambda f, value: UNARY[f](value)) == [2.0, -1.0, 0.0]


def test_sizes_are_those_of_the_tables() -> None:
    space = jet_space(3, 4)
    assert space.size == 35 == size_of(3, 4)
    assert len(space.left) == work_of(3, 4)


def expanded(expression: sp.Expr, at: tuple[float, float], order: int) -> np.ndarray:
    tape = ExpressionGraph()
    nodes = {symbol: tape.variable(symbol.name) for symbol in (x, y)}
    node = Lowering(tape, nodes)(expression)
    values = {"x": at[0], "y": at[1]}
    return jets_of(tape, [node], tuple(nodes.values()), values, order, Floats())[0]


@pytest.mark.parametrize(
    "expression",
    [
        sp.sin(x * y) / (2 + sp.cos(y)),
        sp.exp(x - y) * sp.sqrt(1 + x**2) - 3 * y / x,
        sp.atan(x / y) + sp.log(x + y**2),
    ],
)
def test_jets_are_taylor_polynomials(expression: sp.Expr) -> None:
    """Coefficients are derivatives over factorials: 1, x, y, xx, xy, yy, …"""
    at = (0.6, 1.1)
    powers = [(i, d - i) for d in range(4) for i in range(d, -1, -1)]
    expected = [
        float(sp.diff(expression, x, i, y, j).subs({x: at[0], y: at[1]}))
        / float(sp.factorial(i) * sp.factorial(j))
        for i, j in powers
    ]
    np.testing.assert_allclose(expanded(expression, at, 3), expected, rtol=1e-12, atol=1e-13)


def test_gradients_of_jets_are_jets_of_gradients() -> None:
    expression = sp.sin(x) * sp.exp(x * y)
    at = (0.3, -0.8)
    found = jet_space(2, 3).gradient(expanded(expression, at, 3))
    for k, variable in enumerate((x, y)):
        expected = expanded(sp.diff(expression, variable), at, 2)
        np.testing.assert_allclose(found[k], expected, rtol=1e-12, atol=1e-13)


def test_division_by_zero_at_the_point_is_told() -> None:
    with pytest.raises(ZeroDivisionError, match="divides by zero"):
        expanded(1 / x, (0.0, 1.0), 1)


def test_rational_jets_round_nothing() -> None:
    """sin(x) / (1 + y) at cos x = 3/5, y = 1/3: slopes 3/5 * 3/4 and -4/5 * 9/16."""
    tape = ExpressionGraph()
    nodes = {symbol: tape.variable(symbol.name) for symbol in (x, y)}
    node = Lowering(tape, nodes)(sp.sin(x) / (1 + y))
    values = {"x": Turn(Fraction(3, 5), Fraction(4, 5)), "y": Fraction(1, 3)}
    jet = jets_of(tape, [node], tuple(nodes.values()), values, 1, Rationals())[0]
    assert list(jet) == [Fraction(3, 5), Fraction(9, 20), Fraction(-9, 20)]


def test_angles_add_up_exactly() -> None:
    quarter, third = Turn(Fraction(0), Fraction(1)), Turn(Fraction(3, 5), Fraction(4, 5))
    assert quarter + third == Turn(Fraction(-4, 5), Fraction(3, 5))
    assert quarter * 2 == Turn(Fraction(-1), Fraction(0)) == -2 * quarter
    assert third - third == Turn(Fraction(1), Fraction(0))


def test_points_of_the_circle_are_recognised() -> None:
    assert rational("psi", sp.pi / 2) == Turn(Fraction(0), Fraction(1))
    assert rational("psi", sp.atan(sp.Rational(3, 4))) == Turn(Fraction(4, 5), Fraction(3, 5))
    assert rational("x", 0.1) == Fraction(1, 10)


def test_an_angle_without_rational_sine_is_refused_with_what_would_work() -> None:
    with pytest.raises(InputError, match=r"variable 'psi': pi/3 is no rational number.*pi / 2"):
        rational("psi", sp.pi / 3)
    with pytest.raises(InputError, match=r"sin\(1/2\) is not rational\. Give angles as"):
        Rationals().function("sin", Fraction(1, 2))
