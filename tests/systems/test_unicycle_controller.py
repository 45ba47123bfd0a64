"""The unicycle's controller: its gains against python-control, and the turns that it keeps."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

import kinolab
from kinolab import systems
from kinolab.dynamics import Model
from kinolab.systems import _balance as balance

Array = NDArray[np.float64]

R, STEP = 0.1, 0.02  # [m], [s]
SHAPE = ("theta", "alpha", "psi_dot", "theta_dot", "phi_dot", "alpha_dot")
OTHER = {"R": 0.12, "m_w": 0.5, "m_b": 2.0, "h": 0.2, "m_r": 0.5, "l": 0.3, "I_r": 2e-3}


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("unicycle").model()


def state(model: Model, **values: float) -> Array:
    return np.array([values.get(name, 0.0) for name in model.state_names])


def rows(model: Model, names: tuple[str, ...] = SHAPE) -> list[int]:
    return [model.state_names.index(name) for name in names]


def gains(model: Model, x: Array, r: Array, names: tuple[str, ...]) -> Array:
    """Differences of the inputs over small changes of some states, shape (2, names)."""
    nudges = 1e-4 * np.eye(model.nx)[rows(model, names)]  # within the limits of 1 N m
    columns = [(model.plant_inputs(x + d, r) - model.plant_inputs(x - d, r)) / 2e-4 for d in nudges]
    return np.transpose(columns)


@pytest.mark.parametrize("parameters", [{}, OTHER], ids=["as it is", "heavier"])
@pytest.mark.parametrize("speed", [0.0, 0.5, 1.2])
def test_gains_are_those_that_python_control_places_for_the_derived_machine(
    speed: float, parameters: dict[str, float]
) -> None:
    """Of both planes of the compiled machine riding straight, by Ackermann's formula."""
    control = pytest.importorskip("control")
    model = systems.get("unicycle", **parameters).model()
    x = state(model, phi_dot=speed / parameters.get("R", R))
    A, B = model.plant.jacobian(x)
    planes = {
        ("alpha", "phi_dot", "alpha_dot"): (0, [-balance.PITCHING] * 2 + [-balance.ROLLING]),
        ("theta", "theta_dot"): (1, [-balance.TIPPING] * 2),
    }
    for names, (motor, poles) in planes.items():
        own = rows(model, names)
        placed = control.acker(A[np.ix_(own, own)], B[np.ix_(own, [motor])], poles)
        found = gains(model, x, np.array([speed, 0.0]), names)
        np.testing.assert_allclose(-found[motor], np.ravel(placed), rtol=1e-6)
        np.testing.assert_allclose(found[1 - motor], 0.0, atol=1e-9)


def turning(model: Model, r: Array, turn: float) -> Array:
    """Return the state at a turn rate whose lean does not change, without pitch."""

    def falling(theta: float) -> float:
        x = state(model, theta=theta, psi_dot=turn, phi_dot=r[0] / R)
        return float(model.f(x, r)[model.state_names.index("theta_dot")])

    theta = brentq(falling, r[1] - 0.05, r[1] + 0.05, xtol=1e-15)
    return state(model, theta=theta, psi_dot=turn, phi_dot=r[0] / R)


TURNS = [(1.0, 0.1, -0.9), (1.0, -0.15, 1.2), (1.2, 0.1, -1.5), (0.9, -0.05, -0.3), (1.1, 0.0, 0.6)]


@pytest.mark.parametrize(("speed", "lean", "turn"), TURNS)
def test_a_turn_settles_but_for_its_rate(
    model: Model, speed: float, lean: float, turn: float
) -> None:
    """Any turn rate is steady at any lean, without drive; of six modes only this one is neutral.

    What both motors do not reach to first order they cannot hold; the plan has to see to it.
    """
    r, own = np.array([speed, lean]), rows(model)
    x = turning(model, r, turn)
    np.testing.assert_allclose(model.f(x, r)[own], 0.0, atol=1e-9)
    assert model.plant_inputs(x, r)[0] == pytest.approx(0.0, abs=1e-12)
    assert x[3] == pytest.approx(lean, abs=0.01)  # of third order in lean and turn rate
    modes = np.linalg.eigvals(model.jacobian(x, r)[0][np.ix_(own, own)])
    neutral, *others = sorted(modes, key=abs)
    assert abs(neutral) < 1e-6  # [1/s]
    assert max(mode.real for mode in others) < -0.4


@pytest.mark.parametrize("side", [-1, 1])
def test_a_push_into_a_turn_is_made_good_within_the_torques_limits(model: Model, side: int) -> None:
    """By 2 degrees of lean and 3 of pitch; its torques are held for 20 ms, as in plans.

    Its turn rate, which nothing holds, wanders with the reaction wheel's momentum.
    """
    r = np.array([1.0, side * 0.1])
    x = turning(model, r, -side * 0.9) + state(model, theta=0.035, alpha=0.05)
    for k in range(300):
        assert np.abs(model.plant_inputs(x, r)).max() < 1.0
        x = model.step(x, r, STEP)
        theta, _, turn, _, spin, _ = x[rows(model)]
        assert k < 50 or theta == pytest.approx(r[1], abs=0.01)
        assert spin == pytest.approx(10.0, rel=0.15)
        assert turn * side < -0.4  # into its lean


def test_at_one_speed_no_torque_keeps_a_lean(model: Model) -> None:
    """Where the turn that the wheel makes of a lean carries the weight: c K s^2 = W.

    Per lean: W of the weight, K s of the turn; psi_dot = -c s theta by the wheel's momentum.
    """
    heights, masses = np.array([0.1, 0.24, 0.36]), np.array([0.6, 1.0, 0.35])
    W, spin = 9.81 * masses @ heights, 0.6 * R**2 / 2
    K = R * masses @ heights + spin
    c = spin / (0.6 * R**2 / 4 + (0.09**2 + 0.07**2) / 12 + 1.5e-3 / 2)
    speed = R * np.sqrt(W / (c * K))
    assert speed == pytest.approx(1.0, rel=0.02)  # [m/s]
    slow, neutral, fast = (
        model.plant_inputs(
            state(model, theta=0.01, psi_dot=-c * v / R * 0.01, phi_dot=v / R),
            np.array([v, 0.01]),
        )[1]
        for v in (0.8 * speed, speed, 1.2 * speed)
    )
    assert abs(neutral) < 1e-5  # [N m], of 0.04 that the weight has
    assert slow > 0.01
    assert fast < -0.01


def test_the_course_has_no_straight_way() -> None:
    """Riding straight on from the start runs into the first barrier, and so at any heading."""
    problem = kinolab.load("unicycle_slalom")
    checker = problem.checker()
    for psi in np.linspace(-0.5, 0.5, 41):
        ways = [problem.start.copy() for _ in range(161)]
        for x, way in zip(ways, np.linspace(0.0, 6.4, 161), strict=True):
            x[:3] = x[0] + way * np.cos(psi), way * np.sin(psi), psi
        assert any(checker.collides(*problem.placement(x)) for x in ways)
