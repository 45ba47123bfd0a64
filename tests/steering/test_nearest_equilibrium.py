"""States in which a machine can stay, against statics by hand."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinolab.problem import PlanningTask
from kinolab.steering import nearest_equilibrium

Scenes = Callable[..., PlanningTask]


def state(problem: PlanningTask, **values: float) -> np.ndarray:
    """A state of the machine at rest but for what is named."""
    x = problem.model.rest()
    for name, value in values.items():
        x[problem.model.state_names.index(name)] = value
    return x


def held(problem: PlanningTask, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The equilibrium near a state, and its inputs, after the laws that every one obeys."""
    found = nearest_equilibrium(problem, x)
    assert found is not None
    y, u = found
    assert (np.abs(problem.model.f(y, u)) <= 1e-9 * problem.scales).all()
    assert np.abs(problem.model.velocity(y)).max() == 0.0
    lower, upper = problem.model.control_bounds.T
    assert ((lower <= u) & (u <= upper)).all()
    assert not list(problem.limit_violations(y))
    return y, u


@pytest.mark.parametrize("sway", [-0.2, 0.1, 0.3])
def test_a_crane_hangs_straight_down_and_its_hoist_carries_the_weight(
    scenes: Scenes, sway: float
) -> None:
    crane = scenes("crane")
    moving = state(crane, x=5, y=4, l=6, theta_x=sway, theta_y=-sway, x_dot=0.7, theta_x_dot=0.2)
    y, u = held(crane, moving)
    assert y[3:5] == pytest.approx([0, 0], abs=1e-9)
    assert u == pytest.approx([0, 0, 1000.0 * 9.81], abs=1e-5)  # [N]
    assert y[:3] == pytest.approx([5, 4, 6], abs=1e-6)  # the smallest change is that of the sway


@pytest.mark.parametrize("theta", [0.0, 0.4, -1.2, 1.5, 1.6, 2.2, 3.0, np.pi, -3.3])
def test_a_pendulum_stays_where_angle_and_torque_change_least(scenes: Scenes, theta: float) -> None:
    """The torque is m g l sin(angle), m = l = 1, 5 N m at most; the least is found by trying."""
    pendulum = scenes("pendulum")
    (angle, _), u = held(pendulum, state(pendulum, theta=theta, theta_dot=2.0))
    assert u[0] == pytest.approx(9.81 * np.sin(angle), abs=1e-8)
    tried = np.linspace(theta - 2, theta + 2, 400_001)
    torques = 9.81 * np.sin(tried)
    changes = np.where(np.abs(torques) < 5, (tried - theta) ** 2 + (torques / 5) ** 2, np.inf)
    assert angle == pytest.approx(tried[changes.argmin()], abs=1e-3)


@pytest.mark.parametrize("delta", [-0.55, 0.0, 0.3])
def test_a_car_stays_with_its_wheels_turned_as_they_are(scenes: Scenes, delta: float) -> None:
    car = scenes("car")
    x = state(car, x=1, y=-2, psi=2, delta=delta, phi_dot=3.0, delta_dot=0.1)
    y, u = held(car, x)
    assert y == pytest.approx(state(car, x=1, y=-2, psi=2, delta=delta), abs=1e-12)
    assert u == pytest.approx([0, 0], abs=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_a_submarine_rolls_upright_and_keeps_its_place_and_heading(
    scenes: Scenes, seed: int
) -> None:
    """No input rolls it; a pitch can be held by the moment of the weight, m g h sin(pitch)."""
    submarine, generator = scenes("submarine"), np.random.default_rng(seed)
    tilt = generator.uniform(-0.4, 0.4, 2)
    quaternion = np.array([tilt[0] / 2, tilt[1] / 2, 0.3, 1.0])
    x = submarine.model.rest()
    x[:3], x[3:7] = generator.uniform(-5, 5, 3), quaternion / np.linalg.norm(quaternion)
    y, u = held(submarine, x)
    assert y[:3] == pytest.approx(x[:3], abs=1e-9)
    assert np.linalg.norm(y[3:7]) == pytest.approx(1.0, abs=1e-12)
    turned = submarine.model.frames(y)[0].reshape(3, 4)[:, :3]
    assert turned[2, 1] == pytest.approx(0.0, abs=1e-9)  # its y axis is level
    m = 4 / 3 * np.pi * 1000 * 0.2**2  # [kg] of water, a = 1 m and b = 0.2 m
    assert u == pytest.approx([0, -m * 9.81 * 0.02 * turned[2, 0], 0], abs=1e-6)


def test_two_cranes_hang_straight_down_and_need_no_acceleration(scenes: Scenes) -> None:
    cranes = scenes("two_cranes")
    y, u = held(cranes, state(cranes, x_a=2, l_a=3, x_b=8, l_b=4, sway_a=0.3, sway_b=-0.2))
    assert [y[2], y[5]] == pytest.approx([0, 0], abs=1e-9)
    assert u == pytest.approx(np.zeros(4), abs=1e-9)


def test_a_lift_carries_its_weight_only_with_some_force_to_spare(scenes: Scenes) -> None:
    """10 N of weight: 20 N are enough, 10.1 N leave nothing to steer with."""
    lift = scenes("lift")
    _, u = held(lift, state(lift, x=1.0, z=2.0))
    assert u == pytest.approx([0, 10], abs=1e-9)
    weak = scenes("weak_lift")
    assert nearest_equilibrium(weak, state(weak, x=1.0, z=2.0)) is None


def test_a_stone_in_the_air_stays_nowhere(scenes: Scenes) -> None:
    stone = scenes("stone")
    assert nearest_equilibrium(stone, state(stone, z=3.0)) is None


def test_outside_the_limits_there_is_no_equilibrium(scenes: Scenes) -> None:
    crane = scenes("crane")
    assert nearest_equilibrium(crane, state(crane, x=5, y=4, l=8.5)) is None
    assert nearest_equilibrium(crane, state(crane, x=50, y=4, l=5)) is None


def test_what_is_given_is_not_changed(scenes: Scenes) -> None:
    crane = scenes("crane")
    x = state(crane, x=5, y=4, l=6, theta_x=0.2, x_dot=0.5)
    kept = x.copy()
    nearest_equilibrium(crane, x)
    assert (x == kept).all()
