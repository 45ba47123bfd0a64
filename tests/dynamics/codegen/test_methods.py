"""Methods of integration: what their coefficients say of them, against closed forms."""

from __future__ import annotations

import math

import pytest
from scipy.integrate._ivp import dop853_coefficients as scipys

from kinolab.dynamics.codegen.methods import EULER, METHODS, RK4, ROSENBROCK, Method
from kinolab.errors import InputError
from kinolab.simulation.dop853_coefficients import DOP853


def test_growth_is_the_stability_function() -> None:
    """Of an explicit method of order s with s stages: exp to its order (IV.2, theorem 2.2)."""
    for z in (-2.5, -0.3, 0.4, 1j, -1 + 2j):
        assert EULER.growth(z) == pytest.approx(1 + z)
        assert RK4.growth(z) == pytest.approx(sum(z**k / math.factorial(k) for k in range(5)))
        gamma = 1 - 1 / math.sqrt(2)
        expected = (1 + (1 - 2 * gamma) * z + (0.5 - 2 * gamma + gamma**2) * z**2) / (
            (1 - gamma * z) ** 2
        )
        assert ROSENBROCK.growth(z) == pytest.approx(expected)


def test_it_is_stable_as_far_as_textbooks_say() -> None:
    """Runge's and Kutta's: the root of the cubic 1 + z/2 + z^2/6 + z^3/24 = 0."""
    r = RK4.stability
    assert r == pytest.approx(2.785293563405282, abs=1e-9)
    assert 1 - r / 2 + r**2 / 6 - r**3 / 24 == pytest.approx(0.0, abs=1e-9)
    assert EULER.stability == pytest.approx(2.0, abs=1e-9)
    assert ROSENBROCK.stability == math.inf
    assert abs(ROSENBROCK.growth(-1e12)) < 1e-9  # L-stable


def test_those_of_order_eight_are_scipys() -> None:
    assert DOP853.b == tuple(scipys.B.tolist())
    assert DOP853.a == tuple(tuple(scipys.A[i, :i].tolist()) for i in range(12))
    assert DOP853.stages == scipys.N_STAGES
    assert DOP853 not in METHODS.values()


@pytest.mark.parametrize("order", [3, 4])
def test_an_order_that_is_wrong_is_refused(order: int) -> None:
    with pytest.raises(InputError, match=f"not of order {order}"):
        Method("midpoint", order, b=(0.0, 1.0), a=((), (0.5,)))
