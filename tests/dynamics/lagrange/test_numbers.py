"""One rule for numbers: a third is 1/3 wherever it is printed, as text and as LaTeX."""

from __future__ import annotations

import sympy

from kinolab.dynamics import WORLD, Body, Force, System, angle, length, move, rot_y
from kinolab.dynamics.lagrange.printing import as_latex, one_line


def test_a_half_and_a_third_are_fractions_and_a_tenth_is_a_decimal() -> None:
    x = length("x")
    assert one_line(0.5 * x) == "1/2 x"
    assert one_line(x / 3.0) == "1/3 x"
    assert one_line(0.1 * x) == "0.1 x"


def test_text_and_latex_write_a_number_alike() -> None:
    x, q = length("x"), angle("q")
    cart = Body("cart", move(x, 0, 0), mass=1.0)
    bob = Body("bob", move(x, 0, 0) @ rot_y(q) @ move(0, 0, -1 / 3), mass=1.0)
    push = Force("u", on=cart, along=WORLD.x, limit=1)
    equations = System("s", bodies=[cart, bob], inputs=[push]).equations()
    assert "1/3" in equations.text()
    assert "0.333" not in equations.text()
    assert r"\frac" in equations.latex()
    assert "0.333" not in equations.latex()


def test_latex_has_factors_in_the_order_of_the_text() -> None:
    x, y, z = sympy.symbols("x y z")
    written = {
        r"- \frac{1}{2} x": -x / 2,
        r"\frac{x y}{2 z}": x * y / (2 * z),
        r"- \frac{1}{2 z}": -1 / (2 * z),
        r"z \left(x + y\right)": (x + y) * z,
        r"3 x^{2} \sin {y}": 3 * x**2 * sympy.sin(y),
        r"9.81 x": 9.81 * x,
        r"\frac{1}{x^{2}}": x**-2,
    }
    assert [as_latex(expression) for expression in written.values()] == list(written)
