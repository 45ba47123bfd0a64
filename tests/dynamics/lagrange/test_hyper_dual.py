"""Hyper-dual numbers against derivatives worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from kinolab.dynamics.lagrange.hyper_dual import FUNCTIONS, Evaluation, HyperDual, Instruction

X, Y = np.array([0.3, -1.2, 2.0]), np.array([0.7, 0.4, -0.9])


def known() -> dict[str, HyperDual]:
    """Two variables x and y; second derivatives are taken by x, and by x and y."""
    one, zero = np.ones(3), np.zeros(3)
    return {
        "x": HyperDual(X, np.stack([one, zero], axis=1)),
        "y": HyperDual(Y, np.stack([zero, one], axis=1)),
    }


def test_a_product_of_powers() -> None:
    # f = 3 x^2 y + y: f_x = 6 x y, f_y = 3 x^2 + 1, f_xx = 6 y, f_xy = 6 x
    f = [
        Instruction("variable", label="x"),
        Instruction("variable", label="y"),
        Instruction("number", number=3.0),
        Instruction("power", (0,), 2.0),
        Instruction("mul", (2, 3, 1)),
        Instruction("add", (4, 1)),
    ]
    found = Evaluation(f, known(), 1)(5)
    assert found.slope is not None
    assert found.bend is not None
    assert_allclose(found.value, 3 * X**2 * Y + Y, rtol=1e-14)
    assert_allclose(found.slope, np.stack([6 * X * Y, 3 * X**2 + 1], axis=1), rtol=1e-14)
    assert_allclose(found.bend[:, 0], np.stack([6 * Y, 6 * X], axis=1), rtol=1e-14)


def test_the_larger_of_two_has_its_own_derivatives() -> None:
    f = [
        Instruction("variable", label="x"),
        Instruction("power", (0,), 2.0),
        Instruction("max", (0, 1)),  # x where 0 < x < 1, x^2 elsewhere
    ]
    found = Evaluation(f, known(), 1)(2)
    assert found.slope is not None
    assert found.bend is not None
    assert_allclose(found.value, [0.3, 1.44, 4.0], rtol=1e-14)
    assert_allclose(found.slope[:, 0], [1.0, -2.4, 4.0], rtol=1e-14)
    assert_allclose(found.bend[:, 0, 0], [0.0, 2.0, 2.0], rtol=1e-14)


@pytest.mark.parametrize("name", sorted(set(FUNCTIONS) - {"Heaviside", "DiracDelta"}))
def test_derivatives_of_functions_are_those_of_sympy(name: str) -> None:
    s = sympy.Symbol("s", real=True)
    stated = getattr(sympy, name)(s)
    point = np.array([0.3, 0.7, 1.4])
    for found, order in zip(FUNCTIONS[name](point), range(3), strict=True):
        wanted = [float(sympy.diff(stated, s, order).subs(s, value).doit()) for value in point]
        assert_allclose(found, wanted, rtol=1e-13, atol=1e-15)
