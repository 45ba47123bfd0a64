"""Expressions as trees of plain data: they come back equal, whatever they contain."""

import json

import pytest
import sympy as sp

from kinolab.dynamics.language.json.expression_tree import expression_to_tree, tree_to_expression
from kinolab.errors import InputError


@pytest.mark.parametrize(
    "text",
    [
        "x + y",
        "x*y/3",
        "sqrt(x)",
        "exp(-x)**2",
        "sin(x)**2/y",
        "Abs(x)",
        "sign(x)",
        "pi*x",
        "E**x",
        "x**-1.5",
        "0.1*x",
        "log(x+1)",
        "tanh(atan(x))",
        "tan(x)",
        "2**x",
        "-7",
    ],
)
def test_expressions_come_back_equal(text: str) -> None:
    names = {n: sp.Symbol(n, real=True) for n in "xy"}
    expression = sp.sympify(text, locals=names)
    tree = json.loads(json.dumps(expression_to_tree(expression)))
    assert tree_to_expression(tree, names) == expression


def test_a_function_that_cannot_be_compiled_cannot_be_written() -> None:
    with pytest.raises(InputError) as caught:
        expression_to_tree(sp.gamma(sp.Symbol("x")))
    assert str(caught.value) == (
        "gamma(x): gamma cannot be written to a machine file. Write it with sums, products, "
        "powers, max, sin, cos, tan, exp, log, tanh, atan, abs, sign."
    )
