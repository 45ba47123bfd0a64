"""SymPy expressions on the tape against SymPy's own evaluation."""

from typing import Any

import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from kinolab.dynamics.derivation.expression_graph import ExpressionGraph
from kinolab.dynamics.derivation.lowering import Lowering
from kinolab.errors import InputError

X, Y = sp.symbols("x y", real=True)
NUMBERS = (
    sp.Integer(2),
    sp.Rational(-3, 7),
    sp.Float(0.3),
    sp.pi,
    sp.E,
    sp.sqrt(2),
    sp.Integer(-1),
)

leaves = st.sampled_from((X, Y)) | st.sampled_from(NUMBERS)


def positive(e: Any) -> Any:
    return 1 + e**2


def branches(inner: Any) -> Any:
    pair = st.tuples(inner, inner)
    return (
        pair.map(lambda p: p[0] + p[1])
        | pair.map(lambda p: p[0] * p[1])
        | pair.map(lambda p: p[0] / positive(p[1]))
        | pair.map(lambda p: positive(p[0]) ** sp.tanh(p[1]))
        | pair.map(lambda p: 1 / (1 / positive(p[0]) + 1 / positive(p[1])))
        | inner.map(lambda e: positive(e) ** sp.Rational(-2, 3))
        | inner.map(lambda e: positive(e) ** sp.Rational(5, 2))
        | inner.map(lambda e: sp.sqrt(positive(e)) ** -3)
        | inner.map(sp.sin)
        | inner.map(sp.cos)
        | inner.map(sp.atan)
        | inner.map(sp.tanh)
        | inner.map(sp.Abs)
        | inner.map(lambda e: sp.exp(-(e**2)))
        | inner.map(lambda e: sp.log(positive(e)))
    )


def lowered(expression: Any, x: float, y: float) -> float:
    tape = ExpressionGraph()
    lower = Lowering(tape, {X: tape.variable("x"), Y: tape.variable("y")})
    return tape.evaluate([lower(expression)], {"x": x, "y": y})[0]


@given(st.recursive(leaves, branches, max_leaves=7), st.floats(-2, 2), st.floats(-2, 2))
@settings(max_examples=120, deadline=None)
def test_a_lowered_expression_has_sympys_value(expression: Any, x: float, y: float) -> None:
    x, y = round(x, 3), round(y, 3)
    exact = sp.N(sp.sympify(expression).subs({X: sp.Rational(str(x)), Y: sp.Rational(str(y))}), 30)
    if not exact.is_real or abs(exact) > 1e12:
        return
    # Subtractions inside may cancel six of the sixteen digits of the largest number, about 100.
    assert lowered(sp.sympify(expression), x, y) == pytest.approx(float(exact), rel=1e-8, abs=1e-8)


@pytest.mark.parametrize(
    "expression",
    [
        X ** sp.Rational(1, 3),
        X ** sp.Rational(-7, 2),
        X**-1,
        X**sp.pi,
        2**X,
        sp.Float(2.5) ** (-X),
        X**Y,
        X**-Y,
        (X / Y) / (Y / X / (X + Y)),
        1 / (1 / (1 / (1 + X) + Y)),
        sp.exp(-X) / Y**2,
        sp.exp(X) ** -Y,
        sp.exp(2),
        3 * sp.exp(-1) * X,
        sp.Mul(X, sp.Pow(X, -1, evaluate=False), evaluate=False),
        sp.Rational(2, 3) * X / (sp.Rational(5, 7) * Y),
        sp.tan(X) / sp.cos(X) ** 2,
        sp.log(X * Y) / sp.log(2),
        -(X - Y) / -(Y + X),
        sp.Abs(-X * Y) ** sp.Rational(3, 2),
        X - X * (1 + sp.Float(1e-3)),
    ],
    ids=str,
)
def test_powers_and_quotients_of_every_kind(expression: Any) -> None:
    for x, y in ((0.3, 1.7), (2.5, 0.4)):
        expected = float(sp.N(expression.subs({X: sp.Float(x, 30), Y: sp.Float(y, 30)}), 30))
        assert lowered(expression, x, y) == pytest.approx(expected, rel=1e-12)


def test_an_undeclared_symbol_is_an_error() -> None:
    tape = ExpressionGraph()
    with pytest.raises(InputError) as caught:
        Lowering(tape, {X: tape.variable("x")})(sp.sin(X) + Y)
    assert str(caught.value) == (
        "the symbol y is not declared. "
        "Make it with length, angle, parameter or rate, and use it in the machine."
    )


def test_a_symbol_of_the_same_name_is_another_symbol() -> None:
    tape = ExpressionGraph()
    with pytest.raises(InputError):
        Lowering(tape, {X: tape.variable("x")})(sp.Symbol("x"))


def test_an_unknown_function_is_an_error_that_lists_the_known_ones() -> None:
    tape = ExpressionGraph()
    with pytest.raises(InputError) as caught:
        Lowering(tape, {X: tape.variable("x")})(sp.gamma(X))
    assert str(caught.value) == (
        "gamma cannot be compiled. "
        "Known functions: Abs, Max, atan, cos, exp, log, sign, sin, tan, tanh, sqrt and powers."
    )


@pytest.mark.parametrize("number", [sp.sqrt(-1), sp.zoo], ids=["imaginary", "complex infinity"])
def test_a_number_that_is_not_real_is_an_input_error(number: Any) -> None:
    tape = ExpressionGraph()
    with pytest.raises(InputError):
        Lowering(tape, {X: tape.variable("x")})(X + number)


def test_a_logarithm_of_a_negative_number_is_an_input_error() -> None:
    """(-2)**x has no real value for most x; SymPy keeps it as a power."""
    tape = ExpressionGraph()
    with pytest.raises(InputError):
        Lowering(tape, {X: tape.variable("x")})(sp.Integer(-2) ** X)
