"""Formulas on one line, as on paper."""

from typing import Any

import pytest
import sympy as sp

from kinolab.dynamics import (
    Body,
    System,
    acceleration,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    rot_z,
    toward,
)
from kinolab.dynamics.lagrange.printing import letter, one_line
from kinolab.dynamics.symbols.symbols import Acceleration

X, TH, PHI1 = length("x"), angle("theta"), angle("phi_1")
M, R = parameter("m", 1, "kg"), parameter("R", 1, "m")


@pytest.mark.parametrize(
    ("expression", "text"),
    [
        (M * R**2 / 4 * Acceleration(TH), "1/4 m R² θ̈"),
        (-M * X**2 / 2, "-1/2 m x²"),
        (sp.sin(TH) ** 2 * rate(X) ** 2, "sin²(θ) ẋ²"),
        (M * (X + R), "m (x + R)"),
        ((X + R) ** 2 / M, "(x + R)²/m"),
        (X / (2 * M * R), "1/2 x/(m R)"),
        (sp.sqrt(M * X), "sqrt(m x)"),
        (PHI1, "φ₁"),
        (sp.Integer(0), "0"),
        (-X, "-x"),
        (X - R, "x - R"),
        (X**12, "x¹²"),
    ],
)
def test_a_formula_reads_as_on_paper(expression: Any, text: str) -> None:
    import unicodedata

    printed = unicodedata.normalize("NFC", one_line(expression))
    assert printed == unicodedata.normalize("NFC", text)


def test_a_number_in_a_product_comes_first() -> None:
    """9.81 m x, not m x (9.81)."""
    assert one_line(sp.Float(9.81) * M * X) == "9.81 m x"
    assert one_line(sp.Float(-9.81) * M * X) == "-9.81 m x"


def test_a_reciprocal_has_no_superfluous_one() -> None:
    assert one_line(1 / M) == "1/m"
    assert one_line(-1 / M) == "-1/m"
    assert one_line(2 / M) == "2/m"
    assert one_line(1 / (2 * M)) == "1/(2 m)"


def test_an_indexed_rate_is_spelled_like_its_coordinate() -> None:
    assert one_line(rate(PHI1)).replace("\u0307", "") == one_line(PHI1)


def test_names_become_letters() -> None:
    spelled = [letter(n) for n in ("lambda_1", "psi", "Omega", "x_left", "q_12", "F")]
    assert spelled == ["λ₁", "ψ", "Ω", "x_left", "q₁₂", "F"]


@pytest.mark.parametrize(
    ("name", "first", "second"),
    [
        ("left", "left_dot", "left_ddot"),  # a dot is one letter's
        ("hip_left", "hip_left_dot", "hip_left_ddot"),
        ("q1", "q\u03071", "q\u03081"),
        ("x", "x\u0307", "x\u0308"),
        ("theta1", "θ\u03071", "θ\u03081"),
        ("phi_l", "φ\u0307_l", "φ\u0308_l"),
    ],
)
def test_dots_stand_over_single_letters_and_words_are_called_as_in_tables(
    name: str, first: str, second: str
) -> None:
    q = angle(name)
    assert one_line(rate(q)) == first
    assert one_line(rate(q) ** 2) == f"{first}²"
    assert one_line(acceleration(q)) == second


def test_equations_write_a_number_and_its_double_one_way_and_leave_constants_out() -> None:
    """A ball of mass m that rolls on a shelf at H; 7/10 is the half of 7/5, 0.15 that of 0.3."""
    x, phi, psi = length("x"), angle("phi"), angle("psi")
    m, R, H = parameter("m", 1.0, "kg"), parameter("R", 0.1, "m"), parameter("H", 2.0, "m")
    ball = Body("ball", move(R * phi, 0, H) @ rot_y(phi), mass=m, inertia=2 * m * R**2 / 5)
    top = Body("top", move(x) @ rot_z(psi), mass=1.0, inertia=0.3)
    text = System("ball", bodies=[ball, top], gravity=toward("-z", 9.81)).equations().text()
    assert "7/10 m R² φ\u0307²" in text
    assert "7/5 m R² φ\u0308" in text
    assert "0.15 ψ\u0307²" in text
    assert "0.3 ψ\u0308" in text
    assert "H" not in text
