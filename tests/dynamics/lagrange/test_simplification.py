"""Formulas in their shortest form, and that they are still what they were."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np
import pytest
import sympy as sp

from kinolab.dynamics import angle, length, parameter, rate, rotation
from kinolab.dynamics.lagrange.simplification import grouped, simplified

A, B = angle("a"), angle("b")
X, ROPE = length("x"), length("l", 1.5, 8.0)
M, J, R = parameter("m", 1, "kg"), parameter("J", 1, "kg m^2"), parameter("R", 1, "m")
Q = rotation("Q")
sin, cos, tan = sp.sin, sp.cos, sp.tan
HALF = sp.Rational(1, 2)


def tidy(expression: Any) -> sp.Expr:
    return simplified(sp.sympify(expression), time.thread_time() + 60)


@pytest.mark.parametrize(
    ("expression", "short"),
    [
        (M * sin(A) ** 2 + M * cos(A) ** 2, M),
        (sin(A) ** 2 * cos(B) ** 2 + cos(A) ** 2 * cos(B) ** 2 + sin(B) ** 2, 1),
        (1 - cos(A) ** 2, sin(A) ** 2),
        (1 / cos(A) ** 2 - 1, tan(A) ** 2),
        (HALF * (sin(A + B) - sin(A - B)), cos(A) * sin(B)),
        (sin(A + B) * cos(A) - cos(A + B) * sin(A), sin(B)),
        (sin(A) * cos(B) + cos(A) * sin(B), sin(A + B)),
        (M * cos(A) * cos(B) - M * sin(A) * sin(B), M * cos(A + B)),
        (M * cos(A) * cos(B) + M * sin(A) * sin(B), M * cos(A - B)),
        (cos(A + B), cos(A + B)),
        (cos(A) ** 4 - sin(A) ** 4 - cos(2 * A), 0),
        (sin(A) / cos(A), tan(A)),
        (ROPE / sp.sqrt(ROPE**2 * sin(A) ** 2 + ROPE**2 * cos(A) ** 2), 1),
        (ROPE / sp.Abs(ROPE), 1),
        (sp.sqrt(X**2), sp.Abs(X)),  # it may be negative
        (1.0 * M, M),
        (0.5 * M * X**2, M * X**2 / 2),
        (0.25 * M, M / 4),
        (2.0 * M, 2 * M),
        (sp.tanh(10.0 * X), sp.tanh(10 * X)),
        (sum(entry**2 for entry in Q.quaternion), 1),
    ],
)
def test_what_collects_is_collected(expression: Any, short: Any) -> None:
    assert tidy(expression) == sp.sympify(short)


@pytest.mark.parametrize("measured", [0.04, 9.81, 0.1, 0.0016, 0.167551608191456])
def test_measured_numbers_stay_decimals(measured: float) -> None:
    (number,) = tidy(measured * X).atoms(sp.Float)
    assert float(number) == measured


def test_the_kinetic_energy_of_a_turned_body_forgets_how_it_is_turned() -> None:
    """|R^T v|^2 = |v|^2 for every attitude."""
    from kinolab.dynamics.language.frames import attitude_matrix

    v = sp.Matrix([X, R, M])
    turned = attitude_matrix(Q).T * v
    assert tidy(turned.dot(turned)) == X**2 + R**2 + M**2


@pytest.mark.parametrize("seed", range(20))
def test_a_short_form_has_the_value_of_the_long_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    waves = [sin(A), cos(A), sin(B), cos(B), sin(A + B), cos(A - B), cos(2 * A), tan(B), X, ROPE, M]
    terms = []
    for _ in range(12):
        picked = rng.choice(len(waves), 4)
        factor = float(rng.choice([0.5, -1.0, 2.0, 0.04, -0.25, 1.5]))
        terms.append(factor * sp.Mul(*(waves[k] for k in picked)))
    expression = sp.Add(*terms)
    short = tidy(expression)
    brackets = grouped(short)
    symbols = [A, B, X, ROPE, M]
    for _ in range(5):
        point = dict(zip(symbols, rng.uniform(0.3, 1.2, 5), strict=True))
        value = float(expression.xreplace(point))
        scale = sum(abs(float(term.xreplace(point))) for term in terms)
        for form in (short, brackets):
            assert float(form.xreplace(point)) == pytest.approx(value, abs=1e-13 * scale)


def test_a_form_that_would_be_long_stays_as_it_is() -> None:
    """(a + b + …)^12 has more terms than anybody reads; it is given back unchanged."""
    symbols = [parameter(f"p{k}", 1.0) for k in range(8)]
    power = sp.Add(*symbols) ** 12
    assert tidy(power) == power


def test_time_that_is_over_leaves_a_formula_as_it_is() -> None:
    assert simplified(M * sin(A) ** 2 + 0.5 * M, -math.inf) == M * sin(A) ** 2 + M / 2


def test_what_is_multiplied_by_the_same_acceleration_stands_in_one_bracket() -> None:
    spun = (J + M * R**2) * rate(A) ** 2 / 2 + M * R * sin(B) * rate(A) + J * tan(B) ** 2 * rate(X)
    bracketed = grouped(sp.expand(spun))
    assert bracketed.has((J + M * R**2) * rate(A) ** 2 / 2)
    assert sp.expand(bracketed - spun) == 0
    assert sp.expand(grouped(M * X + M) - (M * X + M)) == 0
