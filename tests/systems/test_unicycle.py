"""The unicycle against the plane machines it becomes, and against the coin it rolls on."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

from kinolab import systems
from kinolab.dynamics import Coordinate, Model, System, rate, zero

Array = NDArray[np.float64]

M_W, R, M_B, H, M_R, L, I_R, G = 0.6, 0.1, 1.0, 0.14, 0.35, 0.26, 1.5e-3, 9.81  # SI
EDGES = (0.09, 0.07, 0.06)  # [m] of the body, a homogeneous cuboid
I_X, I_Y = (M_B * (a**2 + b**2) / 12 for a, b in ((EDGES[1], EDGES[2]), (EDGES[0], EDGES[2])))
NAMES = ("x", "y", "psi", "theta", "phi", "alpha", "gamma")
FREE = ("psi", "theta", "phi", "alpha", "gamma")
STATES = (*NAMES, *(f"{name}_dot" for name in FREE))


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("unicycle").model().plant


def state(**values: float) -> Array:
    return np.array([values.get(name, 0.0) for name in STATES])


def accelerations(model: Model, x: Array, u: Array) -> dict[str, float]:
    return dict(zip(FREE, model.f(x, u)[7:], strict=True))


def random(*shape: int) -> Array:
    return np.random.default_rng(2010).uniform(-1, 1, shape)


def test_states_and_controls_carry_the_authors_names(model: Model) -> None:
    assert model.state_names == STATES
    assert model.control_names == ("drive", "react")


# The coin


def held(machine: System) -> System:
    """The same bodies without motors, whose pendulum and reaction wheel do not move."""
    named = {c.name: c for c in machine.coordinates if isinstance(c, Coordinate)}
    still = [zero(rate(named[name]), f"{name} is held") for name in ("alpha", "gamma")]
    return System(
        "held_unicycle",
        bodies=machine.bodies,
        constraints=[*machine.constraints, *still],
        gravity=machine.gravity,
        velocities=[named[name] for name in ("psi", "theta", "phi")],
    )


def test_without_body_and_reaction_wheel_it_is_the_coin_that_falls() -> None:
    """At any pitch that is held: what has no mass cannot matter. Accelerations reach 100."""
    without = held(systems.get("unicycle")).model()
    coin = systems.get("falling_disk", m=M_W, R=R).model().plant
    x = 2 * random(50, 10)
    x[:, 3] /= 2
    shared = [0, 1, 2, 3, 4, 7, 8, 9]
    found = without.f(x, m_b=0.0, m_r=0.0, I_r=0.0)[:, shared]
    np.testing.assert_allclose(found, coin.f(x[:, shared]), rtol=1e-11, atol=1e-11)


# The planes


@pytest.mark.parametrize("draw", range(10))
def test_ahead_it_is_a_pendulum_on_a_wheel(model: Model, draw: int) -> None:
    """[[I_w + m R^2, S R cos a], [., J]] (phi_ddot, alpha_ddot) with S and J about the axle.

    The wheel's rotation is that against the plane, so that the motor's torque drives it as it is.
    """
    psi, phi, alpha, phi_dot, alpha_dot, drive = random(10, 6)[draw]
    rates = {"phi_dot": 10 * phi_dot, "alpha_dot": 3 * alpha_dot}
    x = state(psi=psi, phi=phi, alpha=alpha, **rates)
    S = M_B * H + M_R * L
    J = I_Y + M_B * H**2 + I_R / 2 + M_R * L**2
    rolling = M_W * R**2 / 2 + (M_W + M_B + M_R) * R**2
    masses = np.array([[rolling, S * R * np.cos(alpha)], [S * R * np.cos(alpha), J]])
    swing = S * R * np.sin(alpha) * rates["alpha_dot"] ** 2
    expected = np.linalg.solve(masses, [drive + swing, S * G * np.sin(alpha) - drive])
    found = accelerations(model, x, np.array([drive, 0.0]))
    np.testing.assert_allclose([found["phi"], found["alpha"]], expected, rtol=1e-11, atol=1e-11)
    aside = [found[name] for name in ("psi", "theta", "gamma")]
    np.testing.assert_allclose(aside, 0.0, atol=1e-10)  # [rad/s^2], of 1000


@pytest.mark.parametrize("draw", range(10))
def test_aside_it_is_the_reaction_wheel_pendulum(model: Model, draw: int) -> None:
    """I_1 theta_ddot = W sin(theta) - tau, I_2 (theta_ddot + gamma_ddot) = tau, about the contact.

    I_1 counts the reaction wheel as a point; the pendulum turns about where the wheel touches.

    Source: Spong, Corke, Lozano, Nonlinear control of the reaction wheel pendulum, Automatica
    37(11), 2001, with I_1 and I_2 as there.
    """
    psi, theta, gamma, theta_dot, gamma_dot, react = random(10, 6)[draw]
    rates = {"theta_dot": 3 * theta_dot, "gamma_dot": 200 * gamma_dot}
    x = state(psi=psi, theta=theta, gamma=gamma, **rates)
    heights = np.array([R, R + H, R + L])
    masses = np.array([M_W, M_B, M_R])
    I_1 = M_W * R**2 / 4 + I_X + masses @ heights**2
    theta_ddot = (G * masses @ heights * np.sin(theta) - react) / I_1
    found = accelerations(model, x, np.array([0.0, react]))
    expected = [theta_ddot, react / I_R - theta_ddot]
    np.testing.assert_allclose([found["theta"], found["gamma"]], expected, rtol=1e-11, atol=1e-11)
    ahead = [found[name] for name in ("psi", "phi", "alpha")]
    np.testing.assert_allclose(ahead, 0.0, atol=1e-10)  # [rad/s^2], of 1000


# Linear controllability

POSTURE = ("theta", "alpha", "theta_dot", "phi_dot", "alpha_dot", "gamma_dot")


HEADING = ("psi", "psi_dot")


def reached(model: Model, x: Array, kept: tuple[str, ...]) -> int:
    """Dimension of what the inputs reach in the linearisation: the span of B, A B, A^2 B, ...

    New directions are made orthogonal to the old ones one power at a time, for powers of A as they
    are point all the same way. A direction shorter than 1e-9 of the largest is rounding.
    """
    A, B = model.jacobian(x)
    rows = [STATES.index(name) for name in kept]
    A, B = A[np.ix_(rows, rows)], B[rows]
    span, new = np.zeros((len(rows), 0)), B / np.abs(B).max(axis=0)
    while new.shape[1]:
        rest = new - span @ (span.T @ new)
        directions, sizes, _ = np.linalg.svd(rest, full_matrices=False)
        fresh = directions[:, sizes > 1e-9 * np.abs(A).max()]
        span, new = np.hstack([span, fresh]), A @ fresh
    return span.shape[1]


@pytest.mark.parametrize("speed", [0.0, 5.0])
def test_pitch_and_lean_can_be_held(model: Model, speed: float) -> None:
    """At a standstill and while it rolls, together with the speeds of both wheels."""
    assert reached(model, state(phi_dot=speed), POSTURE) == len(POSTURE)


def test_at_a_standstill_nothing_turns_the_heading_to_first_order(model: Model) -> None:
    A, B = model.jacobian(state())
    row = STATES.index("psi_dot")
    np.testing.assert_allclose(A[row], 0.0, atol=1e-12)
    np.testing.assert_allclose(B[row], 0.0, atol=1e-12)
    assert reached(model, state(), (*POSTURE, *HEADING)) == len(POSTURE)


def test_leaning_turns_the_heading_while_it_rolls(model: Model) -> None:
    """psi_ddot is the lean's rate times the wheel's momentum, so that psi_dot follows the lean.

    What the lean's weight turns the heading by, the reaction wheel gains in momentum: of the
    heading, its rate and the reaction wheel's speed only one more can be chosen.
    """
    rolling = state(phi_dot=5.0)
    A, _ = model.jacobian(rolling)
    moments = M_W * R**2 / 4 + M_B * (EDGES[0] ** 2 + EDGES[1] ** 2) / 12 + I_R / 2
    expected = -M_W * R**2 / 2 * 5.0 / moments
    assert A[STATES.index("psi_dot"), STATES.index("theta_dot")] == pytest.approx(expected)
    assert reached(model, rolling, (*POSTURE, *HEADING)) == len(POSTURE)
    assert reached(model, rolling, (*POSTURE[:-1], *HEADING)) == len(POSTURE)
    assert reached(model, state(), (*POSTURE[:-1], *HEADING)) == len(POSTURE) - 1


def turning(model: Model, speed: float, turn: float) -> Array:
    """A steady turn without inputs: of the lean alone, at rates in [rad/s] of wheel and heading."""

    def unsteady(lean: float) -> float:
        x = state(theta=lean, psi_dot=turn, phi_dot=speed)
        return accelerations(model, x, np.zeros(2))["theta"]

    return state(theta=brentq(unsteady, -0.6, 0.6, xtol=1e-15), psi_dot=turn, phi_dot=speed)


@pytest.mark.parametrize(("speed", "turn"), [(5.0, 1.0), (8.0, -1.5), (12.0, 0.4)])
def test_a_steady_turn_needs_no_torque_and_is_balanced_by_its_lean(
    model: Model, speed: float, turn: float
) -> None:
    """Weight against centrifugal force and the wheel's momentum, by moments about the contact.

    About the track's direction, with everything turned by the turn rate W about the vertical: what
    weighs m at the height h in the plane pulls by m g h sin(theta) and by m a h cos(theta), where
    a = W (v + W h sin(theta)). Spinning and leaning bodies add W times the level part of their
    angular momentum; the body and the reaction wheel have moments of their own across the axle.
    """
    x = turning(model, speed, turn)
    found = np.array(list(accelerations(model, x, np.zeros(2)).values()))
    np.testing.assert_allclose(found, 0.0, atol=1e-9)
    sin, cos = np.sin(x[3]), np.cos(x[3])
    heights, masses = np.array([R, R + H, R + L]), np.array([M_W, M_B, M_R])
    outward = turn * (R * speed + turn * heights * sin)
    pull = G * masses @ heights * sin + masses * outward @ heights * cos
    I_Z = M_B * (EDGES[0] ** 2 + EDGES[1] ** 2) / 12
    along_axle = M_W * R**2 / 2 * (speed + turn * sin) + (I_Y + I_R / 2) * turn * sin
    along_mast = (M_W * R**2 / 4 + I_Z + I_R / 2) * turn * cos
    gyroscopes = turn * (along_axle * cos - along_mast * sin)
    assert pull + gyroscopes == pytest.approx(0.0, abs=1e-10)  # [N m]


def test_while_it_turns_all_of_it_can_be_steered(model: Model) -> None:
    """Where straight riding leaves two directions to higher order, a turn leaves none."""
    everything = (*POSTURE, *HEADING)
    assert reached(model, turning(model, 5.0, 1.0), everything) == len(everything)
