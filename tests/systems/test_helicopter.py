"""The derived helicopter against the paper's wrench, Euler's top and the planar machine."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from kinolab import systems
from kinolab.dynamics import Model
from tests.conftest import Solver
from tests.oracles import helicopter as oracle
from tests.oracles.rigid_body import Top

Array: TypeAlias = NDArray[np.float64]

QUATERNION = ("R_x", "R_y", "R_z", "R_w")
SPEEDS, TURNS = ("x_dot", "y_dot", "z_dot"), ("R_wx", "R_wy", "R_wz")
POWERLESS = {"C": 0.0, "D": 0.0}  # rotors that nothing resists
HEAVY = {"m": 9.1, "Ixx": 0.2, "Iyy": 0.33, "Izz": 0.29, "h": 0.3, "K": 40.0, "l_t": 0.8}
TOP_AXES = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])  # rows: x, z, -y, from small to large


@pytest.fixture(scope="module")
def model() -> Model:
    return systems.get("helicopter").model()


def pick(model: Model, x: Array, *names: str) -> Array:
    return np.asarray(x[..., [model.state_names.index(name) for name in names]])


def state(model: Model, attitude: Rotation | None = None, **values: float) -> Array:
    """At rest and level, but for what is said."""
    x = model.rest()
    if attitude is not None:
        values |= dict(zip(QUATERNION, attitude.as_quat(), strict=True))
    for name, value in values.items():
        x[model.state_names.index(name)] = value
    return x


def run(model: Model, x: Array, u: Array, t: Array, **parameters: float) -> Array:
    done = solve_ivp(
        lambda _, at: model.f(at, u, **parameters),
        (float(t[0]), float(t[-1])),
        x,
        "DOP853",
        t_eval=t,
        rtol=1e-13,
        atol=1e-13,
    )
    return np.asarray(done.y.T)


def test_accelerations_are_those_of_the_papers_wrench(model: Model) -> None:
    p, rng = model.system.parameter_values, np.random.default_rng(1998)
    lower, upper = model.control_bounds.T
    for _ in range(50):
        attitude = Rotation.from_quat(rng.normal(size=4))
        rates, u = rng.uniform(-3, 3, 3), rng.uniform(lower, upper)
        x = state(model, attitude, **dict(zip(TURNS, rates, strict=True)))
        found = pick(model, model.f(x, u), *SPEEDS, *TURNS)
        expected = oracle.accelerations(attitude, rates, u, p)
        np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("changes", [{}, HEAVY])
def test_trim_holds_the_helicopter_where_it_is(model: Model, changes: dict[str, float]) -> None:
    """Six equations that are solved apart from the machine leave no acceleration of any kind."""
    trim = oracle.hover(model.system.parameter_values | changes)
    x = state(model, trim.attitude)
    np.testing.assert_allclose(model.f(x, trim.u, **changes), 0.0, rtol=0, atol=1e-12)
    lower, upper = model.control_bounds.T
    assert (lower < trim.u).all()
    assert (trim.u < upper).all()


def test_hover_leans_to_the_right_against_the_tail_rotor(model: Model) -> None:
    """m g sin(roll) cos(pitch) = T_t - T sin(b), and T_t l_t is the main rotor's drag."""
    p = model.system.parameter_values
    trim = oracle.hover(p)
    T, T_t, a, b = trim.u
    left = trim.attitude.apply([0.0, 1.0, 0.0])
    assert left[2] > 0  # the left side is up
    assert p["m"] * p["g"] * left[2] == pytest.approx(T_t - T * np.sin(b), rel=1e-12)
    drag = p["C"] * T**1.5 + p["D"]
    assert p["l_t"] * T_t == pytest.approx(drag * np.cos(a) * np.cos(b), rel=1e-12)
    assert np.degrees(trim.roll) == pytest.approx(3.0, abs=1.0)


def test_every_input_turns_or_lifts_the_way_its_name_says(model: Model) -> None:
    """From hover: more thrust climbs, more tail turns the nose right, tilts turn the body."""
    trim = oracle.hover(model.system.parameter_values)
    x = state(model, trim.attitude)

    def change(which: int, by: float, name: str) -> float:
        u = trim.u.copy()
        u[which] += by
        return float(pick(model, model.f(x, u), name)[0])

    assert change(0, 5.0, "z_dot") > 0.5  # [m/s^2]
    assert change(1, 1.0, "R_wz") < -1.0  # [rad/s^2]
    assert change(2, 0.01, "R_wy") < -1.0  # the nose rises
    assert change(3, 0.01, "R_wx") > 1.0  # the right side falls


# Free fall


def test_without_thrust_it_falls_as_a_stone_and_turns_as_a_free_top(model: Model) -> None:
    """Parabola, and Euler's equations by Jacobi's functions, about the axes x, z, -y."""
    p = model.system.parameter_values
    moments = np.array([p["Ixx"], p["Izz"], p["Iyy"]])
    top = Top(moments, np.array([0.5, 0.0, 1.5]))
    start, t = TOP_AXES.T @ np.array([0.5, 0.0, 1.5]), np.linspace(0.0, 1.2 * top.period, 41)
    x = state(model, Rotation.from_rotvec([0.3, -0.8, 0.5]), x_dot=2.0, y_dot=-1.0, z_dot=3.0)
    for name, value in zip(TURNS, start, strict=True):
        x[model.state_names.index(name)] = value
    path = run(model, x, np.zeros(4), t, **POWERLESS)
    fall = np.outer(t, [2.0, -1.0, 3.0]) - np.outer(t**2 / 2, [0.0, 0.0, p["g"]])
    np.testing.assert_allclose(pick(model, path, "x", "y", "z"), fall, rtol=0, atol=1e-9)
    rates = top.rates(t) @ TOP_AXES
    np.testing.assert_allclose(pick(model, path, *TURNS), rates, rtol=0, atol=1e-10)


def test_a_free_top_keeps_its_momentum_and_its_energy(model: Model) -> None:
    p = model.system.parameter_values
    moments = np.array([p["Ixx"], p["Iyy"], p["Izz"]])
    x = state(model, Rotation.from_rotvec([0.3, -0.8, 0.5]), R_wx=1.0, R_wy=-0.7, R_wz=1.3)
    path = run(model, x, np.zeros(4), np.linspace(0.0, 20.0, 41), **POWERLESS)
    rates = pick(model, path, *TURNS)
    H = Rotation.from_quat(pick(model, path, *QUATERNION)).apply(moments * rates)
    np.testing.assert_allclose(H, np.broadcast_to(H[0], H.shape), rtol=0, atol=1e-10)
    energy = rates**2 @ moments / 2
    np.testing.assert_allclose(energy, energy[0], rtol=1e-10)


def test_spin_about_the_middle_axis_flips_after_half_a_period(model: Model) -> None:
    """Dzhanibekov's nut: the rate about z changes its sign, again and again."""
    p = model.system.parameter_values
    moments = np.array([p["Ixx"], p["Izz"], p["Iyy"]])
    almost = np.array([np.sqrt(moments[2] * (moments[2] - moments[1])), 0.0, 0.0])
    almost[2] = np.sqrt(moments[0] * (moments[1] - moments[0])) * (1 + 1e-4)  # near the separatrix
    top = Top(moments, 5.0 * almost)
    begin = top.rates(np.array([top.period / 4]))[0]  # all spin is about the middle axis
    assert abs(begin[1]) > 20 * abs(begin[2])
    x = state(model)
    for name, value in zip(TURNS, begin @ TOP_AXES, strict=True):
        x[model.state_names.index(name)] = value
    t = np.array([0.0, 0.25, 0.5, 1.0]) * top.period
    middle = pick(model, run(model, x, np.zeros(4), t, **POWERLESS), "R_wz")[:, 0]
    np.testing.assert_allclose(middle / begin[1], [1.0, 0.0, -1.0, 1.0], rtol=0, atol=1e-6)


# In a plane


@pytest.mark.parametrize("tilt", [-0.15, 0.02, 0.1])
def test_in_its_plane_it_is_the_planar_vertical_take_off_machine(model: Model, tilt: float) -> None:
    """Without drag, tail and spring the centre of oscillation feels no force across the mast.

    It lies Iyy / (m h) below the centre of mass.

    Source: Martin, Devasia, Paden, A different look at output tracking: control of a VTOL aircraft,
    Automatica 32(1), 1996.
    """
    p = model.system.parameter_values
    pitch, rate, T = 0.4, 0.9, 70.0
    R = Rotation.from_rotvec([0.0, pitch, 0.0])
    x = state(model, R, R_wy=rate, x_dot=1.0)
    slope = model.f(x, [T, 0.0, tilt, 0.0], **POWERLESS, K=0.0)
    np.testing.assert_allclose(pick(model, slope, "y_dot", "R_wx", "R_wz"), 0.0, atol=1e-14)
    turning = pick(model, slope, "R_wy")[0]
    assert turning == pytest.approx(-p["h"] * T * np.sin(tilt) / p["Iyy"], rel=1e-12)
    arm = np.array([0.0, 0.0, -p["Iyy"] / (p["m"] * p["h"])])
    carried = np.cross([0.0, turning, 0.0], arm) - rate**2 * arm
    upward = np.array([0.0, 0.0, p["g"]])
    felt = R.inv().apply(pick(model, slope, *SPEEDS) + upward) + carried
    assert felt[0] == pytest.approx(0.0, abs=1e-12)
    assert felt[2] == pytest.approx(T * np.cos(tilt) / p["m"] - rate**2 * arm[2], rel=1e-12)


# Through the canyon


def test_it_flies_over_the_sill_and_under_the_bridge(solved: Solver) -> None:
    """Heights where the script of the canyon puts both; it ends in hover."""
    found = solved("helicopter_canyon")
    assert found.plan.exit_code == 0
    model, path = found.problem.model, found.trajectory.x
    places = pick(model, path, "x", "y", "z")
    for (x, y), low, high in (((10.1, 1.6), 1.3, 5.6), ((21.4, 6.9), 0.0, 2.75)):
        near = places[np.linalg.norm(places[:, :2] - [x, y], axis=1) < 2.0]
        over = near[np.linalg.norm(near[:, :2] - [x, y], axis=1).argmin(), 2]
        assert low + 0.24 < over < high - 0.24  # [m] from the skids, and to the hub
    np.testing.assert_allclose(pick(model, path[-1], *SPEEDS, *TURNS), 0.0, rtol=0, atol=0.3)
