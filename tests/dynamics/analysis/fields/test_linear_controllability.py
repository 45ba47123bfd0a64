"""Linear controllability of machines that are known, and against Kalman's matrix in rationals."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from kinolab import systems
from kinolab.dynamics import (
    Body,
    Control,
    Model,
    Potential,
    System,
    Torque,
    Viscous,
    Wrench,
    angle,
    linear_controllability,
    move,
    rate,
    rot_x,
    rot_y,
    rot_z,
    toward,
)
from kinolab.dynamics.analysis.fields.linear_controllability import reachable_subspace
from kinolab.errors import InputError, UnknownNameError
from tests.machines import four_bar, kinematic_car, wheeled_hull

# --- the reachable subspace ---


@pytest.mark.parametrize("seed", range(20))
def test_the_reachable_subspace_is_that_of_kalmans_matrix(seed: int) -> None:
    """Small integers, many of them 0: Kalman's matrix and its rank are exact in SymPy."""
    rng = np.random.default_rng(seed)
    A = rng.integers(-2, 3, (5, 5)) * rng.integers(0, 2, (5, 5))
    B = rng.integers(-1, 2, (5, 2)) * rng.integers(0, 2, (5, 2))
    exact_A, block, columns = sp.Matrix(A), sp.Matrix(B), sp.Matrix(B)
    for _ in range(4):
        block = exact_A * block
        columns = columns.row_join(block)
    basis = reachable_subspace(A, B)
    assert basis.shape[1] == columns.rank()
    kalman = np.array(columns, dtype=float)
    np.testing.assert_allclose(
        basis @ (basis.T @ kalman), kalman, atol=1e-8 * np.abs(kalman).max(initial=1)
    )


def test_a_chain_of_twelve_integrators_is_reached_to_its_end() -> None:
    """Kalman's matrix would do; of a stiff chain, with 1e-2 to 1e2 between, it would not."""
    A = np.diag(np.logspace(-2, 2, 11), -1)
    B = np.eye(12)[:, :1]
    assert reachable_subspace(A, B).shape[1] == 12


# --- machines ---


def reaction_wheel_pendulum() -> System:
    """A rod with a wheel at its end: only a motor between them (Spong, Corke, Lozano, 2001)."""
    th, phi = angle("th"), angle("phi")
    rod = rot_z(th)
    arm = Body("arm", rod @ move(0.1), mass=0.2, inertia=(0, 1e-3, 1e-3))
    wheel = Body("wheel", rod @ move(0.2) @ rot_z(phi), mass=0.3, inertia=(1e-3, 1e-3, 2e-3))
    motor = Torque("motor", on=wheel, about=rod.z, reacts_on=arm, limit=1.0)
    return System("reaction_wheel", bodies=[arm, wheel], gravity=toward("+x"), inputs=[motor])


@pytest.mark.parametrize("th", [0.0, np.pi])
def test_a_reaction_wheel_pendulum_is_controllable_hanging_and_upright(th: float) -> None:
    """Four states, the wheel's angle among them; Spong, Corke, Lozano, Automatica 37(11), 2001."""
    found = linear_controllability(reaction_wheel_pendulum().model(), [th, 0, 0, 0])
    assert (found.rank, found.dimension, found.controllable) == (4, 4, True)
    assert found.directions == ()
    assert found.stabilisable


def two_pendulums(ratio: float) -> System:
    """Two pendulums hung from one hub, which a motor pushes against both alike."""
    a, b = angle("a"), angle("b")
    one = Body("one", rot_z(a) @ move(1.0), mass=1.0, inertia=(0.01, 0.01, 0.01))
    two = Body("two", rot_z(b) @ move(ratio), mass=1.0, inertia=(0.01, 0.01, 0.01))
    u = Control("u", limit=1.0, unit="N m")
    pushes = [Wrench(on=body, torque=(0, 0, u.symbol)) for body in (one, two)]
    return System("pair", bodies=[one, two], gravity=toward("+x"), inputs=[u], efforts=pushes)


def test_two_equal_pendulums_with_one_input_swing_apart_uncontrolled() -> None:
    """Their difference d obeys d_ddot = -w^2 d, w^2 = m g l / (m l^2 + I)."""
    found = linear_controllability(two_pendulums(1.0).model(), [0, 0, 0, 0])
    assert (found.rank, found.dimension) == (2, 4)
    assert found.directions == ("a - b", "a_dot - b_dot")
    frequency = np.sqrt(9.81 / 1.01)
    np.testing.assert_allclose(sorted(m.imag for m in found.modes), [-frequency, frequency])
    np.testing.assert_allclose([m.real for m in found.modes], 0, atol=1e-9)
    assert not found.stabilisable


def test_two_different_pendulums_with_one_input_are_controllable() -> None:
    assert linear_controllability(two_pendulums(0.5).model(), [0, 0, 0, 0]).controllable


def test_a_car_does_not_move_aside_to_first_order() -> None:
    found = linear_controllability(kinematic_car().model(), [0, 0, 0, 0])
    assert (found.rank, found.directions) == (2, ("y", "psi"))


def test_a_satellites_momentum_moves_nothing() -> None:
    """J w + I Omega stays; the norm of the quaternion is no state."""
    found = linear_controllability(wheeled_hull().model(), wheeled_hull().model().rest())
    assert (found.rank, found.dimension) == (6, 12)
    assert len(found.directions) == 6
    assert not any("R_w " in f"{direction} " for direction in found.directions)


def test_a_loop_has_two_states() -> None:
    """The crank's angle and rate; what closes the loop is no freedom."""
    model = four_bar().model()
    x, u = _four_bar_at_rest(model)
    found = linear_controllability(model, x, u)
    assert (found.rank, found.dimension) == (2, 2)


def _four_bar_at_rest(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Hold a crank at a place: the acceleration is linear in the torque."""
    x = np.array([1.2, -0.8, 1.6, 0.0])
    for _ in range(20):
        x = model.project(x)
    base, slope = model.f(x, [0.0])[3], model.f(x, [1.0])[3] - model.f(x, [0.0])[3]
    return x, np.array([-base / slope])


def test_a_damped_wheel_that_no_motor_drives_is_still_stabilisable() -> None:
    a, b = angle("a"), angle("b")
    driven = Body("driven", rot_x(a), inertia=(1, 1, 1))
    idle = Body("idle", rot_y(b), inertia=(1, 1, 1))
    spring = Potential(2 * b**2)
    system = System(
        "idler",
        bodies=[driven, idle],
        inputs=[Torque("motor", on=driven, about=driven.frame.x, limit=1.0)],
        efforts=[Viscous(rate(b), 0.5), spring],
    )
    found = linear_controllability(system.model(), np.zeros(4))
    assert (found.rank, found.directions) == (2, ("b", "b_dot"))
    assert found.stabilisable
    assert not found.controllable


def test_a_coin_that_rolls_is_steered_aside() -> None:
    """At rest turning moves it nowhere; rolling at w, y_dot = R w psi."""
    model = systems.get("rolling_disk").model()
    rest = linear_controllability(model, np.zeros(6), without=("x", "phi"))
    assert (rest.rank, rest.dimension, rest.directions) == (3, 4, ("y",))
    rolling = linear_controllability(model, [0, 0, 0, 0, 0, 2.0], without=("x", "phi"))
    assert (rolling.rank, rolling.dimension, rolling.directions) == (4, 4, ())


def test_what_others_depend_on_cannot_be_left_out() -> None:
    model = systems.get("rolling_disk").model()
    with pytest.raises(InputError, match="y depends on a state that is left out"):
        linear_controllability(model, [0, 0, 0, 0, 0, 2.0], without=("x", "phi", "psi"))
    with pytest.raises(UnknownNameError, match="no state is called 'fi'"):
        linear_controllability(model, np.zeros(6), without=("fi",))


def test_modes_that_no_input_moves_are_those_of_popov_belevitch_and_hautus() -> None:
    """[lambda I - A, B] loses rank at the found modes, and at no other eigenvalue."""
    model = two_pendulums(1.0).model()
    found = linear_controllability(model, np.zeros(4))
    A, B = model.jacobian(np.zeros(4), [0.0])
    assert len(found.modes) == 2
    for mode in found.modes:
        assert np.linalg.matrix_rank(np.hstack([mode * np.eye(4) - A, B]), tol=1e-6) < 4
    other = two_pendulums(0.5).model()
    A, B = other.jacobian(np.zeros(4), [0.0])
    for mode in np.linalg.eigvals(A):
        assert np.linalg.matrix_rank(np.hstack([mode * np.eye(4) - A, B]), tol=1e-6) == 4


def test_a_state_that_moves_has_no_linearisation_here() -> None:
    with pytest.raises(InputError, match="it does not stay there: theta_dot changes"):
        linear_controllability(systems.get("pendulum").model(), [1.0, 0.0])
