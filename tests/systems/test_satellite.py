"""The derived satellites: momentum, Euler's top, eigenaxis turns, and what two wheels can do."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_are
from scipy.spatial.transform import Rotation

import kinolab
from kinolab import systems
from kinolab.dynamics import Model
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.trajopt.multistart.multiple_shooting import Multistart
from tests.oracles.rigid_body import Top, polhode_frequency

Array: TypeAlias = NDArray[np.float64]
Inputs: TypeAlias = Callable[[float], Array]

QUATERNION, TURNS = ("R_x", "R_y", "R_z", "R_w"), ("R_wx", "R_wy", "R_wz")
J, IW, TAU = np.array([10.0, 12.0, 8.0]), 0.01, 0.1  # [kg m^2], [N m]; from the description
FRICTION = {"c": 2e-5, "tau_c": 2e-3}
AXES = {"satellite": (0, 1, 2), "satellite_two_wheels": (0, 1)}

on_both = pytest.mark.parametrize("name", AXES)


@pytest.fixture(scope="module")
def models() -> dict[str, Model]:
    return {name: systems.get(name).model() for name in AXES}


def wheels(name: str) -> list[str]:
    return [f"wheel_{'xyz'[i]}_dot" for i in AXES[name]]


def pick(model: Model, x: Array, *names: str) -> Array:
    return np.asarray(x[..., [model.state_names.index(name) for name in names]])


def state(model: Model, **values: float) -> Array:
    x = model.rest()
    for name, value in values.items():
        x[model.state_names.index(name)] = value
    return x


def run(model: Model, x: Array, u: Inputs, t: Array, **parameters: float) -> Array:
    done = solve_ivp(
        lambda s, at: model.f(at, u(s), **parameters),
        (float(t[0]), float(t[-1])),
        x,
        "DOP853",
        t_eval=t,
        rtol=1e-13,
        atol=1e-13,
    )
    return np.asarray(done.y.T)


def momentum(model: Model, x: Array) -> Array:
    """H = R (J omega + I_w wheel rates) of states (n, nx), shape (n, 3); in [N m s]."""
    carried = pick(model, x, *TURNS) * J
    for i in AXES[model.system.name]:
        carried[..., i] += IW * pick(model, x, f"wheel_{'xyz'[i]}_dot")[..., 0]
    return Rotation.from_quat(pick(model, x, *QUATERNION)).apply(carried)


@on_both
@pytest.mark.parametrize("parameters", [{}, FRICTION])
def test_momentum_stays_whatever_wheels_and_friction_do(
    models: dict[str, Model], name: str, parameters: dict[str, float]
) -> None:
    model, t = models[name], np.linspace(0.0, 40.0, 41)
    x = state(model, R_wx=0.02, R_wy=-0.03, R_wz=0.015, wheel_x_dot=100.0, wheel_y_dot=-60.0)

    def u(s: float) -> Array:
        return TAU * np.sin(0.3 * s + np.arange(model.nu))

    H = momentum(model, run(model, x, u, t, **parameters))
    np.testing.assert_allclose(H, np.broadcast_to(H[0], H.shape), rtol=0, atol=1e-9)
    assert np.linalg.norm(H[0]) > 0.5


@on_both
def test_friction_brakes_wheels_by_their_own_speed(models: dict[str, Model], name: str) -> None:
    """c nu + tau_c at nu far above the smoothing: the torque that holds a wheel's speed."""
    model, nu = models[name], 200.0
    x = state(model, **dict.fromkeys(wheels(name), nu))
    u = np.full(model.nu, FRICTION["c"] * nu + FRICTION["tau_c"])
    np.testing.assert_allclose(
        pick(model, model.f(x, u, **FRICTION), *TURNS, *wheels(name)), 0.0, rtol=0, atol=1e-12
    )
    loose = pick(model, model.f(x, 0 * u, **FRICTION), wheels(name)[0])[0]
    assert loose < -u[0] / IW / 1.01  # the bus is a thousand times heavier


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_turn_about_an_axis_takes_as_long_as_bang_bang(
    models: dict[str, Model], axis: int
) -> None:
    """T = 2 sqrt(J theta / tau) at full torque one way and back; the wheel is at rest again.

    J is without the wheel's own moment, which the torque does not turn along.
    """
    model, theta = models["satellite"], 1.2
    T = 2 * np.sqrt((J[axis] - IW) * theta / TAU)
    x = model.rest()
    for sign in (-1.0, 1.0):
        x = run(model, x, lambda _, s=sign: s * TAU * np.eye(3)[axis], np.array([0.0, T / 2]))[-1]
    turned = Rotation.from_quat(pick(model, x, *QUATERNION)).as_rotvec()
    np.testing.assert_allclose(turned, theta * np.eye(3)[axis], rtol=0, atol=1e-10)
    np.testing.assert_allclose(pick(model, x, *TURNS), 0.0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(pick(model, x, *wheels("satellite")), 0.0, rtol=0, atol=1e-9)


@on_both
def test_wheels_are_at_rest_whenever_a_satellite_without_momentum_is(
    models: dict[str, Model], name: str
) -> None:
    """J omega + I_w nu = 0 at every moment of any manoeuvre that begins at rest."""
    model, t = models[name], np.linspace(0.0, 30.0, 31)
    path = run(model, model.rest(), lambda s: TAU * np.cos(0.4 * s + np.arange(model.nu)), t)
    axes = list(AXES[name])
    expected = -J[axes] * pick(model, path, *TURNS)[:, axes] / IW
    found = pick(model, path, *wheels(name))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9)  # [rad/s]
    assert np.abs(found).max() > 10.0


def free_state(model: Model, rates: Array) -> Array:
    """Wheels that do not turn in space along their axes, so that they take no part."""
    values = dict(zip(TURNS, rates, strict=True))
    return state(model, **values, **dict(zip(wheels("satellite"), -rates, strict=True)))


def test_with_free_wheels_it_is_a_free_top(models: dict[str, Model]) -> None:
    """Euler's equations with J - I_w by Jacobi's functions; z, x, y from small to large."""
    model, top = models["satellite"], Top((J - IW)[[2, 0, 1]], np.array([0.05, 0.0, 0.12]))
    t = np.linspace(0.0, 1.5 * top.period, 31)
    path = run(model, free_state(model, np.array([0.0, 0.12, 0.05])), lambda _: np.zeros(3), t)
    rates = pick(model, path, *TURNS)[:, [2, 0, 1]]
    np.testing.assert_allclose(rates, top.rates(t), rtol=0, atol=1e-11)


def test_a_symmetric_one_nutates_at_the_polhode_frequency(models: dict[str, Model]) -> None:
    model, J1, J3 = models["satellite"], 11.0, 8.0
    expected = polhode_frequency(J1 - IW, J3 - IW, 0.2)
    t = np.linspace(0.0, 60.0, 61)
    start = free_state(model, np.array([0.05, 0.0, 0.2]))
    path = run(model, start, lambda _: np.zeros(3), t, J_x=J1, J_y=J1, J_z=J3)
    rates = pick(model, path, *TURNS)
    around = np.unwrap(np.arctan2(rates[:, 1], rates[:, 0]))
    np.testing.assert_allclose(around, expected * t, rtol=0, atol=1e-9)


# Two wheels


def test_two_wheels_leave_the_momentum_along_the_third_axis_alone(
    models: dict[str, Model],
) -> None:
    """J_z omega_z = e_z . R^T H: nothing that the wheels do enters."""
    model, t = models["satellite_two_wheels"], np.linspace(0.0, 40.0, 41)
    x = state(model, R_wx=0.05, R_wz=0.02, wheel_x_dot=150.0)
    path = run(model, x, lambda s: TAU * np.array([np.sin(0.2 * s), np.cos(0.3 * s)]), t)
    R = Rotation.from_quat(pick(model, path, *QUATERNION))
    along = R.inv().apply(momentum(model, x[None])[0])[:, 2]
    np.testing.assert_allclose(J[2] * pick(model, path, "R_wz")[:, 0], along, rtol=0, atol=1e-10)
    assert np.ptp(along) > 0.1


def test_two_wheels_turn_it_about_the_third_axis_by_going_back_and_forth(
    models: dict[str, Model],
) -> None:
    """The commutator of turns about x and y is, for small ones, a turn about z by their product."""
    model, x, theta = models["satellite_two_wheels"], models["satellite_two_wheels"].rest(), 0.1
    expected = Rotation.identity()
    for axis, sign in ((0, 1.0), (1, 1.0), (0, -1.0), (1, -1.0)):
        expected *= Rotation.from_rotvec(sign * theta * np.eye(3)[axis])
        half = np.sqrt((J[axis] - IW) * theta / TAU)
        for way in (-sign, sign):
            push = way * TAU * np.eye(2)[axis]
            x = run(model, x, lambda _, push=push: push, np.array([0.0, half]))[-1]
    turned = Rotation.from_quat(pick(model, x, *QUATERNION))
    assert (turned.inv() * expected).magnitude() < 1e-10
    assert turned.as_rotvec()[2] == pytest.approx(theta**2, rel=0.1)
    np.testing.assert_allclose(pick(model, x, *wheels(model.system.name)), 0.0, rtol=0, atol=1e-9)


# Pointing


@pytest.fixture(scope="module")
def planned() -> tuple[PlanningTask, Trajectory]:
    """The scenario, and the plan of the first seed: the same one however fast the machine is."""
    problem = kinolab.load("satellite_pointing")
    plan = problem.solve(seed=1, improve=2.0)  # by then it takes 32 s; the first motion, minutes
    assert plan.exit_code == 0
    assert plan.trajectory is not None
    return problem, plan.trajectory


def test_it_turns_to_its_target_past_the_sun(planned: tuple[PlanningTask, Trajectory]) -> None:
    """As the scenario says, judged from the quaternions of the plan alone."""
    problem, trajectory = planned
    path = pick(problem.model, trajectory.x, *QUATERNION)
    looks = Rotation.from_quat(path).apply([1.0, 0.0, 0.0])
    (sun,), (target,) = problem.keep_outs, problem.goal.directions
    assert angle(looks, sun.direction).min() > sun.half_angle - 1e-3  # [rad] between two rows
    assert angle(looks[-1:], target.target)[0] < target.tolerance
    straight = Rotation.align_vectors([target.target], [[1.0, 0.0, 0.0]])[0].as_rotvec()
    direct = Rotation.from_rotvec(np.outer(np.linspace(0.0, 1.0, 50), straight))
    through = angle(direct.apply([1.0, 0.0, 0.0]), sun.direction).min()
    assert through < sun.half_angle / 3  # there is something to pass


def test_a_plan_gets_close_and_feedback_holds_the_target_under_friction(
    planned: tuple[PlanningTask, Trajectory],
) -> None:
    """Dry friction of 2 mN m: alone the plan misses by degrees, with LQR by less than 0.1."""
    (target,) = planned[0].goal.directions
    alone, led = (followed(*planned, gain) for gain in (np.zeros((3, 6)), lqr(planned[0].model)))
    off = np.degrees(angle(alone[-1:], target.target))[0]
    assert 0.5 < off < 30.0
    held = np.degrees(angle(led[-600:], target.target))  # a minute
    assert held.max() < 0.1


def lqr(model: Model) -> Array:
    """Gains (3, 6) on turn and turn rate in body axes, of the double integrators at rest."""
    B = np.vstack([np.zeros((3, 3)), pick(model, model.jacobian(model.rest())[1].T, *TURNS).T])
    A = np.eye(6, k=3)
    Q = np.diag([1 / np.radians(0.02) ** 2] * 3 + [1 / 0.002**2] * 3)
    return np.asarray(B.T @ solve_continuous_are(A, B, Q, np.eye(3) / TAU**2) * TAU**2)


def followed(problem: PlanningTask, trajectory: Trajectory, gain: Array) -> Array:
    """Where the telescope looks every 0.1 s along a plan under friction and a minute after it."""
    model, t, h = problem.model, trajectory.t, 0.1
    x, looks = problem.start, []
    for time in np.arange(0.0, t[-1] + 60.0, h):
        k = min(int(np.searchsorted(t, time, side="right")) - 1, len(t) - 1)
        wanted, u = trajectory.x[k], trajectory.u[k] if k < len(trajectory.u) else np.zeros(3)
        if k < len(trajectory.u):
            wanted = model.step(wanted, u, time - t[k]) if time > t[k] else wanted
        turns = [Rotation.from_quat(pick(model, at, *QUATERNION)) for at in (wanted, x)]
        rates = pick(model, x, *TURNS) - pick(model, wanted, *TURNS)
        error = np.append((turns[0].inv() * turns[1]).as_rotvec(), rates)
        x = model.step(x, np.clip(u - gain @ error, -TAU, TAU), h, substeps=4, **FRICTION)
        looks.append(turns[1].apply([1.0, 0.0, 0.0]))
    return np.array(looks)


def test_of_the_first_guesses_some_become_motions_past_the_sun() -> None:
    """Their first trust regions are far too wide for long steps; that says nothing of a guess."""
    shots = Multistart(kinolab.load("satellite_pointing"), 80, 1, lambda: False)
    assert any(shots.next() is not None for _ in range(4))


def angle(a: Array, b: ArrayLike) -> Array:
    """Angles in [rad] between unit vectors (n, 3) and one (3,), good where they are small too."""
    return np.asarray(2 * np.arcsin(np.linalg.norm(a - np.asarray(b), axis=1) / 2))
