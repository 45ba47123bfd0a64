"""Orders of methods, beside published tables and the number of rooted trees."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate._ivp import dop853_coefficients, rk

from kinolab.dynamics.codegen.methods import METHODS, Method
from kinolab.dynamics.codegen.order_conditions import order_of
from kinolab.errors import InputError

ROOT = 1 / math.sqrt(2)


def rows(table: Any) -> tuple[tuple[float, ...], ...]:
    """Return the part of a square table below its diagonal."""
    return tuple(tuple(row[:i]) for i, row in enumerate(np.asarray(table, dtype=float).tolist()))


# SciPy's tables: Bogacki and Shampine 1989; Dormand and Prince 1980; Hairer's DOP853.
TABLES = {
    "RK23": (3, rk.RK23.B, rk.RK23.A),
    "RK45": (5, rk.RK45.B, rk.RK45.A),
    "DOP853": (8, dop853_coefficients.B, dop853_coefficients.A[:12, :12]),
}


@pytest.mark.parametrize("name", TABLES)
def test_published_methods_have_their_orders_and_no_higher_ones(name: str) -> None:
    order, b, a = TABLES[name]
    assert order_of(b.tolist(), rows(a), (), 0.0, order + 1) == order
    assert Method(name, order, b.tolist(), rows(a)).stages == len(b)


@pytest.mark.parametrize("gamma", [1 - ROOT, 1 + ROOT, 0.3])
def test_the_rosenbrock_method_is_of_order_two_with_any_gamma(gamma: float) -> None:
    """Verwer and others 1999, below equation (3.1)."""
    b, a, c = (1.5, 0.5), ((), (1.0,)), ((), (-2.0,))
    assert order_of(b, a, c, gamma, 3) == 2
    assert Method("own", 2, b, a, c, gamma).implicit


def test_shampines_rosenbrock_method_is_of_order_four() -> None:
    """Shampine, ACM TOMS 8(2), 1982, in the form of Press and others, Numerical Recipes, 16.6.

    There (1 / (gamma h) - J) g_i = f(x + sum a_ij g_j) + sum c_ij g_j / h; with g_i = h k_i / 2 and
    gamma = 1 / 2 this is the form here, for weights half as large and (gamma c) for c.
    """
    a = np.array([[0, 0, 0, 0], [2, 0, 0, 0], [48 / 25, 6 / 25, 0, 0], [48 / 25, 6 / 25, 0, 0]])
    c = np.zeros((4, 4))
    c[1, 0], c[2, :2], c[3, :3] = -8, (372 / 25, 12 / 5), (-112 / 125, -54 / 125, -2 / 5)
    b = np.array([19 / 9, 1 / 2, 25 / 108, 125 / 108])
    assert order_of((b / 2).tolist(), rows(a / 2), rows(c / 2), 0.5, 5) == 4


@pytest.mark.parametrize(
    ("a", "b", "order"),
    [
        (((), (0.66,)), (0.25, 0.75), 1),  # 2/3 of Ralston's, in two digits
        (((), (0.6667,)), (0.25, 0.75), 1),
        (((), (2 / 3,)), (0.25, 0.75), 2),
        (((), (0.666666666667,)), (0.25, 0.75), 2),
        (((), (0.5,), (1 - 1 / 0.3, 1 / 0.3)), (0.1, 0.8, 0.1), 2),  # of order 3 where f is linear
        (((), (0.5,), (-1.0, 2.0)), (1 / 6, 2 / 3, 1 / 6), 3),  # Kutta's
        (((), (1.0,)), (0.5, 0.4), 0),
        (((), (1.0,)), (1e10, 0.5 - 1e10), 0),
        (((), (1e300,), (1e300, 1e300)), (0.5, 0.25, 0.25), 1),
        (((), (0.0,)), (1e308, 1e308), 0),
    ],
)
def test_orders_are_those_of_nonlinear_equations(a: Any, b: Any, order: int) -> None:
    assert order_of(b, a, (), 0.0, 4) == order
    with pytest.raises(InputError, match=f"it is not of order {order + 1}, but of order {order}"):
        Method("own", order + 1, b, a)


def test_all_registered_methods_have_exactly_their_orders() -> None:
    for method in METHODS.values():
        found = order_of(method.b, method.a, method.c, method.gamma, method.order + 1)
        assert found == method.order


def test_errors_of_a_nonlinear_equation_fall_as_the_order_says() -> None:
    """x' = -x^2 from 1 has the solution 1 / (1 + t)."""
    order, b, a = TABLES["RK23"]

    def error(h: float) -> float:
        k: list[float] = []
        for row in rows(a):
            k.append(-((1.0 + h * sum(w * each for w, each in zip(row, k, strict=False))) ** 2))
        return abs(1.0 + h * float(np.dot(b, k)) - 1.0 / (1.0 + h))

    errors = [error(0.2 / 2**n) for n in range(4)]
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(2 ** (order + 1), rel=0.25)


WRONG: dict[str, dict[str, Any]] = {
    "its order is 0. Give a whole number from 1 to 14.": {"order": 0},
    "its order is -1. Give a whole number": {"order": -1},
    "order: it is 2.0. Give a whole number.": {"order": 2.0},
    "order: it is '2'. Give a whole number.": {"order": "2"},
    "c entry 1: it is 0. Give a list, each entry a number.": {"c": (0, 1)},
    "a entry 2: it is 0.667. Give a list": {"a": ((), 0.667)},
    "its name is not an identifier. Use letters, digits and underscores.": {"name": "for"},
    "it has 2 weights b, 1 rows a and 0 rows c. Give a row for each": {"a": ((),)},
    "a coefficient is not finite": {"gamma": math.nan},
}


@pytest.mark.parametrize("said", WRONG)
def test_what_is_no_method_is_refused(said: str) -> None:
    given = {"name": "own", "order": 2, "b": (0.5, 0.5), "a": ((), (1.0,))}
    with pytest.raises(InputError) as caught:
        Method(**given | WRONG[said])  # type: ignore[arg-type]
    assert said in str(caught.value)


def test_lists_are_taken_as_tuples() -> None:
    assert Method("own", 2, [0.5, 0.5], [[], [1]]) == Method("own", 2, (0.5, 0.5), ((), (1.0,)))


def test_a_method_in_hairers_form_is_that_of_the_pages_formula() -> None:
    """ROS3P, of order 3: Lang, Verwer, BIT Numerical Mathematics 41(4), 2001, table 1."""
    gamma = 0.5 + math.sqrt(3) / 6
    alpha = np.array([[0, 0, 0], [1, 0, 0], [1, 0, 0]], dtype=float)
    beside = np.array([[gamma, 0, 0], [-1, gamma, 0], [-gamma, 0.5 - 2 * gamma, gamma]])
    weights, scaled = np.array([2 / 3, 0, 1 / 3]), gamma * np.linalg.inv(beside)
    b, a, c = weights @ scaled, alpha @ scaled, np.eye(3) - scaled
    assert order_of(b.tolist(), rows(a), rows(c), gamma, 4) == 3
