"""The derived car against two hand derivations, and against the shortest paths of a car."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from kinolab import systems
from kinolab.trajectory import Trajectory
from tests.conftest import Solver
from tests.oracles import vehicles as oracle
from tests.oracles.vehicles import Car

Array = NDArray[np.float64]
Length = Callable[[oracle.Pose, oracle.Pose, float], float]

CAR = Car()
OTHER = Car(m=4.1, L=0.33, R=0.055, I_z=0.05, a=0.16, I_w=3e-4, J_s=2e-3, c_d=0.01, c_s=0.02)
FREE = replace(CAR, c_d=0.0, c_s=0.0)
LOCK = 0.6  # [rad]: the largest steering angle
TIGHTEST = CAR.L / np.tan(LOCK)  # [m]: the smallest turning circle of the rear axle


@pytest.fixture(scope="module")
def model() -> Any:
    return systems.get("car").model()


@pytest.fixture(scope="module")
def samples() -> tuple[Array, Array]:
    """One hundred random states (100, 7), steered by at most 0.6 rad, and inputs (100, 2)."""
    rng = np.random.default_rng(1990)
    x = rng.uniform(-3, 3, (100, 7))
    x[:, 3] = rng.uniform(-LOCK, LOCK, 100)
    return x, rng.uniform(-1, 1, (100, 2))


def ordered(model: Any, x: Array) -> Array:
    """States in the oracle's order as the model wants them."""
    return x[..., [oracle.CAR_STATES.index(name) for name in model.state_names]]


def restored(model: Any, x: Array) -> Array:
    """States, or their derivatives, of the model in the oracle's order."""
    return x[..., [model.state_names.index(name) for name in oracle.CAR_STATES]]


def derivative(model: Any, x: Array, u: Array, car: Car) -> Array:
    """Return the model's x_dot for a state in the oracle's order, in that order."""
    return restored(model, np.asarray(model.f(ordered(model, x), u, **asdict(car))))


def strong(u: Array, car: Car) -> Array:
    """Inputs of unit size as torques in [N m] that matter to a car of this size."""
    return u * np.array([car.m * car.R, car.J_s + 0.01 * car.I_z])


def test_states_and_controls_carry_the_authors_names(model: Any) -> None:
    assert sorted(model.state_names) == sorted(oracle.CAR_STATES)
    assert tuple(model.control_names) == oracle.CAR_CONTROLS


# The equations of motion


@pytest.mark.parametrize("car", [CAR, OTHER])
def test_multipliers_agree_with_partial_velocities(samples: tuple[Array, Array], car: Car) -> None:
    """The two oracles, derived apart from each other."""
    for x, unit in zip(*samples, strict=True):
        u = strong(unit, car)
        expected = oracle.car_derivative(x, u, car)[5:]
        found = oracle.car_by_multipliers(x, u, car)
        assert np.abs(found - expected).max() < 1e-10 * np.abs(expected).max()


@pytest.mark.parametrize("car", [CAR, OTHER, FREE])
def test_derived_motion_equals_the_hand_derivation(
    model: Any, samples: tuple[Array, Array], car: Car
) -> None:
    for x, unit in zip(*samples, strict=True):
        u = strong(unit, car)
        expected = oracle.car_derivative(x, u, car)
        found = derivative(model, x, u, car)
        assert np.abs(found - expected).max() < 1e-12 * np.abs(expected).max()


def test_the_front_axle_sets_the_turn(model: Any, samples: tuple[Array, Array]) -> None:
    """x_dot = v cos psi, y_dot = v sin psi, psi_dot = v tan(delta) / L with v = R phi_dot."""
    for x, u in zip(*samples, strict=True):
        psi, delta, delta_dot, phi_dot = x[[2, 3, 5, 6]]
        v = CAR.R * phi_dot
        expected = [v * np.cos(psi), v * np.sin(psi), v * np.tan(delta) / CAR.L, delta_dot, phi_dot]
        found = derivative(model, x, u, CAR)[:5]
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("car", [CAR, OTHER])
def test_energy_is_that_of_chassis_steering_and_axle(
    model: Any, samples: tuple[Array, Array], car: Car
) -> None:
    for x in samples[0]:
        kinetic, _ = model.energy(ordered(model, x), **asdict(car))
        assert float(kinetic) == pytest.approx(oracle.car_energy(x, car), rel=1e-12)


def steered(t: float) -> Array:
    """Smooth torques in [N m]: back and forth, and the wheel to both sides."""
    return np.array([500 * np.sin(t), 12 * np.cos(1.5 * t)])


def test_energy_changes_by_the_work_of_motor_steering_and_drags(model: Any) -> None:
    def slope(t: float, both: Array) -> Array:
        x, u = both[:7], steered(t)
        power = (u - np.array([CAR.c_d, CAR.c_s]) * x[[6, 5]]) @ x[[6, 5]]
        return np.append(derivative(model, x, u, CAR), power)

    start = np.array([0.0, 0.0, 0.3, 0.1, 0.0, 0.2, 4.0, 0.0])
    run = solve_ivp(slope, (0, 8), start, "DOP853", rtol=1e-11, atol=1e-11)
    kinetic = np.asarray(model.energy(ordered(model, run.y[:7].T), **asdict(CAR))[0])
    assert np.ptp(run.y[3]) > 0.5  # [rad]: it steers
    assert np.ptp(run.y[7]) > 0.3 * kinetic.max()  # the work matters
    assert np.abs(kinetic - kinetic[0] - run.y[7]).max() < 1e-9 * kinetic.max()


@pytest.mark.parametrize("delta", [-0.6, -0.2, 0.1, 0.6])
@pytest.mark.parametrize("phi_dot", [-3.0, 5.0])
def test_a_coasting_car_rolls_on_its_turning_circle(
    model: Any, delta: float, phi_dot: float
) -> None:
    """Radius L / tan(delta) about a point in line with the rear axle, at constant speed."""
    radius, speed = FREE.L / np.tan(delta), FREE.R * phi_dot
    start, t = np.array([1.0, 2.0, 0.4, delta, 0.0, 0.0, phi_dot]), np.linspace(0.0, 10.0, 41)
    path = simulate(model, start, t)
    heading = 0.4 + speed / radius * t
    centre = start[:2] + radius * np.array([-np.sin(0.4), np.cos(0.4)])
    expected = centre + radius * np.stack([np.sin(heading), -np.cos(heading)], axis=-1)
    np.testing.assert_allclose(path[:, :2], expected, rtol=0, atol=1e-9)  # [m]
    np.testing.assert_allclose(path[:, 2], heading, rtol=0, atol=1e-9)


def simulate(model: Any, start: Array, t: Array) -> Array:
    """States of a coasting car without drag at times ``t``, shape (len(t), 7), by DOP853."""
    run = solve_ivp(
        lambda _, x: derivative(model, x, np.zeros(2), FREE),
        (float(t[0]), float(t[-1])),
        start,
        "DOP853",
        t_eval=t,
        rtol=1e-12,
        atol=1e-12,
    )
    return np.asarray(run.y.T, dtype=np.float64)


# Flatness


def winding(car: Car) -> Callable[[float], Array]:
    """Motion of a car of any size along a winding path, at varying speed."""
    t = sp.Symbol("t")
    path = [1.2 * t + 0.3 * sp.sin(0.7 * t), 0.8 * sp.sin(0.9 * t) + 0.03 * t**2]
    return oracle.flat_car([car.L * p for p in path], t, car)


@pytest.mark.parametrize("car", [CAR, OTHER, FREE])
def test_torques_of_the_flat_output_steer_the_rear_axle_along_its_path(
    model: Any, car: Car
) -> None:
    """Open loop for 10 s; rtol 1e-12 of metres and radians, over the steering's own integral."""
    motion, times = winding(car), np.linspace(0.0, 10.0, 101)
    planned = np.array([motion(time) for time in times])
    start = np.array([*planned[0, :4], 0.0, *planned[0, 4:6]])
    run = solve_ivp(
        lambda s, x: derivative(model, x, motion(s)[6:], car),
        (0.0, 10.0),
        start,
        "DOP853",
        t_eval=times,
        rtol=1e-12,
        atol=1e-12,
    )
    driven = run.y.T[:, [0, 1, 2, 3, 5, 6]]
    driven[:, 2] -= 2 * np.pi * np.round((driven[:, 2] - planned[:, 2]) / (2 * np.pi))
    np.testing.assert_allclose(driven, planned[:, :6], rtol=0, atol=1e-6)
    assert np.ptp(planned[:, 2]) > 1.0  # [rad]: the path does wind
    assert np.ptp(planned[:, 3]) > 0.5  # [rad]: to both sides
    assert np.abs(planned[:, 3]).max() < LOCK


# The oracle of shortest paths


def poses(seed: int, count: int = 1000) -> list[tuple[Array, Array]]:
    """Pairs of poses, some far apart and some within a turning circle of 1.7 m."""
    rng = np.random.default_rng(seed)
    reach = rng.choice([0.5, 3.0, 15.0], (count, 1, 1)) * np.array([1, 1, 0]) + [0, 0, np.pi]
    return [(pair[0], pair[1]) for pair in rng.uniform(-1, 1, (count, 2, 3)) * reach]


@pytest.mark.parametrize("kind", ["Dubins", "ReedsShepp"])
def test_shortest_lengths_equal_those_of_ompl(kind: str) -> None:
    base: Any = pytest.importorskip("ompl.base", reason="OMPL is not installed")
    space = getattr(base, f"{kind}StateSpace")(1.7)
    length = {"Dubins": oracle.dubins_length, "ReedsShepp": oracle.reeds_shepp_length}[kind]
    for start, goal in poses(1957):
        expected = space.distance(in_ompl(space, start), in_ompl(space, goal))
        assert length(start, goal, 1.7) == pytest.approx(expected, abs=1e-9)  # [m]


def in_ompl(space: Any, pose: Array) -> Any:
    state = space.allocState()
    state.setX(pose[0])
    state.setY(pose[1])
    state.setYaw(pose[2])
    return state


@pytest.mark.parametrize("word_of", [oracle.dubins_word, oracle.reeds_shepp_word])
def test_a_shortest_path_ends_at_its_goal(word_of: Callable[..., oracle.Word]) -> None:
    for start, goal in poses(1, 200):
        word = word_of(start, goal, 1.7)
        place, heading = oracle.follow(word, complex(*start[:2]) / 1.7, float(start[2]))
        assert abs(1.7 * place - complex(*goal[:2])) < 1e-8  # [m]
        assert abs(np.exp(1j * heading) - np.exp(1j * goal[2])) < 1e-8
        assert all(piece.length >= 0 for piece in word)


def test_shortest_paths_are_as_long_backwards_as_forwards() -> None:
    """And a car that may reverse is never behind one that may not."""
    for start, goal in poses(2, 200):
        both = oracle.reeds_shepp_length(start, goal, 1.7)
        assert both == pytest.approx(oracle.reeds_shepp_length(goal, start, 1.7), abs=1e-8)
        assert np.hypot(*(goal - start)[:2]) - 1e-9 < both
        assert both < oracle.dubins_length(start, goal, 1.7) + 1e-9


@pytest.mark.parametrize(
    ("length", "goal", "expected"),
    [
        (oracle.dubins_length, (0, 0, 0), 0.0),
        (oracle.dubins_length, (7, 0, 0), 7.0),
        (oracle.dubins_length, (0, 4, np.pi), 2 * np.pi),  # half a circle of radius 2
        (oracle.dubins_length, (2, 2, np.pi / 2), np.pi),
        (oracle.dubins_length, (2, -6, -np.pi / 2), np.pi + 4),  # a quarter, then straight
        (oracle.dubins_length, (0, 0, np.pi), 14 * np.pi / 3),  # thirds: 60, 300, 60 degrees
        (oracle.reeds_shepp_length, (0, 0, 0), 0.0),
        (oracle.reeds_shepp_length, (-7, 0, 0), 7.0),
        (oracle.reeds_shepp_length, (-2, 2, -np.pi / 2), np.pi),  # a quarter backwards
        (oracle.reeds_shepp_length, (0, 0, np.pi), 2 * np.pi),  # three turns of 60 degrees
        (oracle.reeds_shepp_length, (0, 0, -np.pi), 2 * np.pi),
    ],
)
def test_shortest_lengths_of_plain_manoeuvres(
    length: Length, goal: oracle.Pose, expected: float
) -> None:
    """With circles of 2 m, known from geometry."""
    assert length((0, 0, 0), goal, 2.0) == pytest.approx(expected, abs=1e-8)
    turned = (1.0 - goal[1], -3.0 + goal[0], goal[2] + np.pi / 2)  # the same, elsewhere
    assert length((1, -3, np.pi / 2), turned, 2.0) == pytest.approx(expected, abs=1e-8)


# Driven motions are no shorter


def driven(model: Any, seed: int, phi_dot: float, torque: float) -> Trajectory:
    """Drive for 12 s in steps of 0.01 s: random torques, and a steering that follows random angles.

    Args:
        phi_dot: Rate of the axle at the start in [rad/s].
        torque: Largest torque on the axle in [N m].
    """
    rng = np.random.default_rng(seed)
    x = ordered(model, np.array([0.0, 0.0, rng.uniform(-3, 3), 0.0, 0.0, 0.0, phi_dot]))
    states, inputs = [x], []
    for k in range(1200):
        if k % 150 == 0:
            drive, angle = (
                rng.uniform(-torque, torque),
                rng.choice([-1, 1]) * rng.uniform(0.3, 0.58),
            )
        delta, rate = restored(model, states[-1])[[3, 5]]
        inputs.append(np.array([drive, 40 * (angle - delta) - 40 * rate]))
        states.append(np.asarray(model.step(states[-1], inputs[-1], 0.01, **asdict(CAR))))
    t = 0.01 * np.arange(1201)
    return Trajectory(t, np.array(states), np.array(inputs), model.state_names, model.control_names)


def ends(motion: Trajectory) -> tuple[Array, Array]:
    """First and last pose (x, y, heading)."""
    columns = [motion.state_names.index(name) for name in ("x", "y", "psi")]
    return motion.x[0, columns], motion.x[-1, columns]


def column(motion: Trajectory, name: str) -> Array:
    return motion.x[:, motion.state_names.index(name)]


@pytest.mark.parametrize("seed", range(10))
def test_no_driven_path_is_shorter_than_that_of_reeds_and_shepp(model: Any, seed: int) -> None:
    motion = driven(model, seed, phi_dot=0.0, torque=700.0)
    assert np.abs(column(motion, "delta")).max() < LOCK
    length = oracle.path_length(motion)
    assert length > 1.0  # [m]
    for part in (300, 600, 1200):
        piece = replace(motion, t=motion.t[: part + 1], x=motion.x[: part + 1], u=motion.u[:part])
        bound = oracle.reeds_shepp_length(*ends(piece), TIGHTEST)
        assert oracle.path_length(piece) >= bound - 1e-6  # [m]


def test_the_driven_paths_go_both_ways(model: Any) -> None:
    rates = np.concatenate(
        [column(driven(model, seed, phi_dot=0.0, torque=700.0), "phi_dot") for seed in range(3)]
    )
    assert rates.min() < -1.0 < 1.0 < rates.max()


@pytest.mark.parametrize("seed", range(10))
def test_no_path_driven_forwards_is_shorter_than_that_of_dubins(model: Any, seed: int) -> None:
    motion = driven(model, seed, phi_dot=6.0, torque=50.0)
    assert np.abs(column(motion, "delta")).max() < LOCK
    assert column(motion, "phi_dot").min() > 0
    for part in (300, 600, 1200):
        piece = replace(motion, t=motion.t[: part + 1], x=motion.x[: part + 1], u=motion.u[:part])
        bound = oracle.dubins_length(*ends(piece), TIGHTEST)
        assert oracle.path_length(piece) >= bound - 1e-6  # [m]


@pytest.mark.parametrize(("phi_dot", "bound"), [(5.0, "both"), (5.0, "forwards"), (-5.0, "both")])
def test_coasting_on_the_tightest_circle_is_shortest(
    model: Any, phi_dot: float, bound: str
) -> None:
    """A quarter of a turn: the bound is met, not only kept."""
    time = np.pi / 2 * TIGHTEST / (FREE.R * abs(phi_dot))
    t = np.linspace(0.0, time, 60)
    states = simulate(model, np.array([0.0, 0.0, 0.0, LOCK, 0.0, 0.0, phi_dot]), t)
    x, u = ordered(model, states), np.zeros((59, 2))
    motion = Trajectory(t, x, u, model.state_names, model.control_names)
    shortest = {"both": oracle.reeds_shepp_length, "forwards": oracle.dubins_length}[bound]
    length = oracle.path_length(motion)
    assert length == pytest.approx(np.pi / 2 * TIGHTEST, abs=1e-9)
    assert length == pytest.approx(shortest(*ends(motion), TIGHTEST), abs=1e-8)  # [m]


def test_the_length_of_a_path_is_the_distance_rolled(model: Any) -> None:
    """Forwards, R times the change of phi; arcs of 0.02 m miss it by their length to the fifth."""
    motion = driven(model, 0, phi_dot=6.0, torque=50.0)
    rolled = CAR.R * float(np.ptp(column(motion, "phi")))
    assert oracle.path_length(motion) == pytest.approx(rolled, abs=1e-9)  # [m] of 20


def test_the_plan_into_the_bay_is_no_shorter_than_the_path_of_reeds_and_shepp(
    solved: Solver,
) -> None:
    """Obstacles, torques and rates can only lengthen it."""
    plan = solved("vehicle_parking").trajectory
    assert oracle.path_length(plan) >= oracle.reeds_shepp_length(*ends(plan), TIGHTEST) - 1e-6
