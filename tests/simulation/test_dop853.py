"""The compiled DOP853 makes the steps of SciPy's, to rounding, whatever the machine."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.special import ellipj

import kinolab
from kinolab.dynamics import Body, Potential, System, length, move
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import (
    ATOL,
    RTOL,
    DivergedError,
    OdeMotion,
    follow,
    follow_each,
    reference_motion,
)

Array = NDArray[np.float64]

INTERVALS = 60
# A pendulum; a car; attitudes; a rope; feedback; a closed loop that is projected.
SCENARIOS = (
    "pendulum_swingup", "vehicle_parking", "satellite_pointing", "crane_factory",
    "falling_disk_slalom", "five_bar_table",
)  # fmt: skip


def inputs_of(problem: PlanningTask) -> tuple[Array, Array]:
    """Times of knots, and inputs at random within a third of their limits."""
    lower, upper = problem.model.control_bounds.T
    drawn = np.random.default_rng(1).uniform(lower, upper, (INTERVALS, len(lower)))
    t = problem.step * np.arange(INTERVALS + 1.0)
    return t, (lower + upper) / 2 + (drawn - (lower + upper) / 2) / 3


@pytest.mark.parametrize("name", SCENARIOS)
def test_steps_states_and_dense_output_are_those_of_scipy(name: str) -> None:
    problem = kinolab.load(name)
    model, (t, u) = problem.model, inputs_of(problem)
    motion = reference_motion(problem, problem.start, t, u)
    assert isinstance(motion, OdeMotion)
    knots, begin, end = motion.steps
    for k in range(INTERVALS):
        rate = model.plant.rate_under(model.plant_inputs(motion.x[k], u[k]))
        found = solve_ivp(
            rate, (t[k], t[k + 1]), motion.x[k], method="DOP853", rtol=RTOL,
            atol=ATOL * problem.scales, dense_output=True,
        )  # fmt: skip
        # Where the error is rounding, the length of the next step is that of noise.
        ours = [*begin[knots == k], *end[knots == k][-1:]]
        assert len(ours) == len(found.t)
        np.testing.assert_allclose(ours, found.t, rtol=0, atol=1e-3 * problem.step)
        times = np.linspace(t[k], t[k + 1], 9)
        apart = (motion.between(k, times) - found.sol(times).T) / problem.scales
        assert np.abs(apart).max() < 1e-9
    each = follow_each(model, motion.x[:-1], t, u, problem.scales)
    assert np.abs((each - motion.x[1:]) / problem.scales).max() < 1e-9  # the latter projected


def test_a_pendulum_swings_as_elliptic_functions_say() -> None:
    """theta(t) = 2 asin(k cd(w t | k^2)), released at theta0, k = sin(theta0 / 2), w^2 = g / l."""
    model, t = kinolab.systems.get("pendulum", g=9.81, l=1.0).model(), np.linspace(0.0, 6.0, 13)
    motion = follow(model, np.array([2.0, 0.0]), t, np.zeros((12, 1)), np.ones(2))
    k = np.sin(1.0)
    _, cn, dn, _ = ellipj(np.sqrt(9.81) * t, k**2)
    np.testing.assert_allclose(motion.x[:, 0], 2 * np.arcsin(k * cn / dn), atol=1e-7)


def test_a_motion_that_runs_away_is_told_with_its_time() -> None:
    """A spring of negative, growing stiffness: x_ddot = 2 x (1 + x^2), x = tan(t) until pi/2."""
    x = length("x")
    body = Body("mass", move(x), mass=1.0)
    growing = Potential(-(x**2) - x**4 / 2)
    model = System("runaway", bodies=[body], efforts=[growing]).model()
    t = np.array([0.0, 1.0, 2.0])
    near = follow(model, np.array([0.0, 1.0]), t[:2], np.zeros((1, 0)), np.ones(2))
    np.testing.assert_allclose(near.x[-1], [np.tan(1.0), 1 / np.cos(1.0) ** 2], rtol=1e-8)
    with pytest.raises(DivergedError) as caught:
        follow(model, np.array([0.0, 1.0]), t, np.zeros((2, 0)), np.ones(2))
    assert caught.value.time == pytest.approx(np.pi / 2, abs=1e-3)


def test_an_interval_of_a_billion_swings_is_told_and_not_followed() -> None:
    """Thirty years of a pendulum: compiled code, that nothing interrupts, would take hours."""
    model = kinolab.systems.get("pendulum").model()
    with pytest.raises(DivergedError, match="more than 200000 steps for one interval") as caught:
        follow(model, np.array([1.0, 0.0]), np.array([0.0, 1e9]), np.zeros((1, 1)), np.ones(2))
    assert caught.value.time > 1000.0  # of the pendulum's 2 s periods there are thousands


def test_many_steps_do_not_fit_the_first_table() -> None:
    """One interval of many periods: rows are added, and the dense output goes on."""
    model = kinolab.systems.get("pendulum").model()
    start, times = np.array([0.5, 0.0]), np.linspace(0.0, 200.0, 1001)
    motion = follow(model, start, times[[0, -1]], np.zeros((1, 1)), np.ones(2))
    knots, begin, end = motion.steps
    assert len(knots) > 300
    np.testing.assert_array_equal(begin[1:], end[:-1])
    parts = follow(model, start, times, np.zeros((1000, 1)), np.ones(2))
    np.testing.assert_allclose(motion.between(0, times), parts.x, atol=1e-5)
