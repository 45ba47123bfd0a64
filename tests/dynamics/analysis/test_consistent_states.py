"""The nearest state at which all constraints hold, against closed forms and all closed linkages."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.linalg import null_space
from scipy.optimize import minimize_scalar

from kinolab.dynamics import (
    Model,
    angle,
    closed,
    length,
    move,
    parameter,
    rot_z,
    velocity,
    zero,
)
from kinolab.dynamics.analysis.consistent_states import (
    constraint_violations,
    nearest_consistent_state,
)
from kinolab.dynamics.analysis.constraint_units import position_unit, velocity_unit
from tests import loops
from tests.machines import four_bar_by_multipliers, rope_pendulum

Array = NDArray[np.float64]


def unlimited(model: Model) -> Array:
    return np.tile([-np.inf, np.inf], (model.nx, 1))


@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_velocities_are_the_projection_onto_those_without_slip(seed: int) -> None:
    """By a basis of the velocities that a drawing allows, in units of the scales."""
    model, rng = loops.roller_racer().model(), np.random.default_rng(seed)
    x = rng.uniform(-1, 1, 8)
    near = nearest_consistent_state(model, x, unlimited(model))
    assert near is not None
    sizes = model.state_scales[4:]
    allowed = null_space(loops.rows_of_racer(x[2], x[3]) * sizes)
    expected = sizes * (allowed @ (allowed.T @ (x[4:] / sizes)))
    np.testing.assert_array_equal(near[:4], x[:4])
    np.testing.assert_allclose(near[4:], expected, rtol=0, atol=1e-12)  # [m/s], [rad/s]


@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_place_of_a_weight_on_a_rope_is_along_the_rope(seed: int) -> None:
    """The foot of the perpendicular onto a circle, and the part of a velocity along it."""
    model, rng = rope_pendulum().model(), np.random.default_rng(seed)
    x = rng.uniform(-2, 2, 4)
    near = nearest_consistent_state(model, x, unlimited(model))
    assert near is not None
    along = x[:2] / np.linalg.norm(x[:2])
    across = np.array([-along[1], along[0]])
    np.testing.assert_allclose(near[:2], along, rtol=0, atol=1e-6)  # [m], of a flat minimum
    np.testing.assert_allclose(near[2:], across * (across @ x[2:]), rtol=0, atol=1e-5)
    assert np.hypot(*near[:2]) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_no_closed_four_bar_is_nearer_than_the_one_proposed(seed: int) -> None:
    """All of them are known: the crank turns once around on each of two sides."""
    model, rng = loops.four_bar().model(), np.random.default_rng(seed)
    x = np.append(rng.uniform(-2, 2, 3), 0.7)
    near = nearest_consistent_state(model, x, unlimited(model))
    assert near is not None
    assert near[3] == 0.7  # the crank's rate is free

    def away(a: float, side: float) -> float:
        q = side * loops.four_bar_state(side * a)[:3]  # the mirror image has all angles reversed
        return float(np.linalg.norm((q - x[:3] + np.pi) % (2 * np.pi) - np.pi))

    best = min(
        minimize_scalar(lambda a, s=side: away(a, s), (a, a + 0.05), options={"xtol": 1e-10}).fun
        for side in (1.0, -1.0)
        for a in np.linspace(-np.pi, np.pi, 60)
    )
    scale = set(model.state_scales[:3])
    assert len(scale) == 1  # so that units do not matter
    assert np.linalg.norm(near[:3] - x[:3]) == pytest.approx(best, abs=1e-8)
    assert abs(loops.freudenstein(near[0], near[2])) < 1e-12


def test_the_nearest_start_keeps_the_limits() -> None:
    model = loops.four_bar().model()
    limits = unlimited(model)
    limits[2] = 1.9, 2.2  # [rad] the rocker, which is at 1.5 nearby
    near = nearest_consistent_state(model, np.array([1.0, -0.5, 1.5, 0.0]), limits)
    assert near is not None
    assert near[2] == pytest.approx(1.9, abs=1e-9)
    assert constraint_violations(model, near) == ()


def test_constraints_that_repeat_others_do_not_confuse() -> None:
    model = four_bar_by_multipliers().model()
    near = nearest_consistent_state(model, model.rest() + 0.3, unlimited(model))
    assert near is not None
    assert np.abs(model.constraint_residual(near)).max() < 1e-12


def test_units_follow_from_what_a_constraint_is_made_of() -> None:
    x, a, b = length("x"), angle("a"), angle("b")
    R = parameter("R", 0.2, "m")
    along = velocity(move(x) @ rot_z(a) @ move(R)).y
    assert position_unit(closed(x - R * a, "rack")) == "m"
    assert position_unit(closed((x**2 + R**2) ** 0.5 - 1, "rod")) == "m"
    assert position_unit(closed(a - 2 * b, "gears")) == "rad"
    assert position_unit(closed(x**2 - R**2, "square")) == "m^2"
    assert velocity_unit(closed(a - 2 * b, "gears")) == "rad/s"
    assert velocity_unit(zero(along, "slip")) == "m/s"
    assert position_unit(loops.four_bar().constraints[0]) == "m or rad"  # type: ignore[arg-type]
