"""Formulas on one line, as on paper."""

from typing import Any

import pytest
import sympy as sp

from kinolab.dynamics import angle, length, parameter, rate
from kinolab.dynamics.lagrange.printing import letter, one_line
from kinolab.dynamics.language.symbols import Acceleration

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
