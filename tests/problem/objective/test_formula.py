"""Formulas as text: what they mean, and that text is never run."""

import pytest
import sympy

from kinolab.dynamics import Body, Force, System, length, move, parameter, rot_z
from kinolab.dynamics.symbols.symbols import rate
from kinolab.errors import InputError
from kinolab.problem.objective.formula import formula

X, M = length("x"), parameter("m", 2.0, "kg")
CART = Body("cart", move(3 * X, 0, 0) @ rot_z(0), mass=M)
PUSHED = System(
    "pushed", bodies=[CART], inputs=[Force("push", on=CART, along=CART.frame.x, limit=1)]
)


@pytest.mark.parametrize(
    ("text", "meant"),
    [
        ("x**2 + 0.5 * push**2", X**2 + 0.5 * sympy.Symbol("push") ** 2),
        ("abs(-m) * sqrt(x_dot**2)", sympy.Abs(M) * sympy.sqrt(rate(X) ** 2)),
        ("cart.x + cart.vx", 3 * X + 3 * rate(X)),
        ("max(x, 1, 2) - sin(pi / 6)", sympy.Max(X, 2) - 0.5),
        ("2 ** 3 ** 2", sympy.Float(512)),
    ],
)
def test_a_formula_means_what_it_says(text: str, meant: sympy.Expr) -> None:
    values = {"x": 0.7, "x_dot": -0.3, "push": 0.4, "m": 2.0}

    def number(expression: sympy.Expr) -> float:
        return float(expression.subs({s: values[str(s)] for s in expression.free_symbols}))

    assert number(formula(text, PUSHED, "here")) == pytest.approx(number(meant), rel=1e-12)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("xx + 1", "no name is called 'xx'. Did you mean 'x'?"),
        ("cart.up", "a body has x, y, z, vx, vy and vz, and not 'up'"),
        ("crate.x", "no name is called 'crate'. Did you mean 'cart'?"),
        ("__import__('os').system('true')", "is none of what may be written"),
        ("x if m else 1", "is none of what may be written"),
        ("sin(x, 1)", "sin takes one argument"),
        ("x +", "it cannot be read"),
        ("9 ** 9 ** 9 ** 9", "it cannot be read"),
        ("(" * 500 + "x" + ")" * 500, "it cannot be read"),
        ("x +" * 1000 + "x", "it has more than 2000 characters"),
    ],
)
def test_what_is_no_formula_is_refused(text: str, told: str) -> None:
    with pytest.raises(InputError, match=r"here: .*") as refused:
        formula(text, PUSHED, "here")
    assert told in str(refused.value)
