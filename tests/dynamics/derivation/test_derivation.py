"""Derived equations of random machines against point masses, and the laws of mechanics."""

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

from kinolab.dynamics import (
    WORLD,
    Body,
    Force,
    Gravity,
    System,
    Torque,
    angle,
    length,
    move,
    rot_x,
    rot_y,
    rot_z,
    toward,
)
from tests.dynamics.machines import compiled_random, reference_of

Array = NDArray[np.float64]
SEEDS = range(40)
ROUNDING = 1e-10  # relative: 1e-16 times the condition of the mass matrix, at most 1e4, and sums


def sample(seed: int, count: int = 2) -> list[tuple[Array, Array]]:
    model, rng = compiled_random(seed), np.random.default_rng([seed, 1])
    return [(rng.uniform(-1.5, 1.5, model.nx), rng.uniform(-2, 2, model.nu)) for _ in range(count)]


@pytest.mark.parametrize("seed", SEEDS)
def test_accelerations_are_those_of_point_masses(seed: int) -> None:
    model = compiled_random(seed)
    reference = reference_of(seed)
    for x, u in sample(seed):
        q, v = x[: model.nq], x[model.nq :]
        q_ddot, _ = reference.multiplier_form(q, v, u)
        f = model.f(x, u)
        np.testing.assert_array_equal(f[: model.nq], v)
        scale = 1 + np.abs(q_ddot).max()
        np.testing.assert_allclose(f[model.nq :], q_ddot, rtol=0, atol=ROUNDING * scale)


@pytest.mark.parametrize("seed", SEEDS)
def test_mass_matrix_energy_and_frames_are_those_of_point_masses(seed: int) -> None:
    model = compiled_random(seed)
    reference = reference_of(seed)
    for x, _ in sample(seed):
        q, v = x[: model.nq], x[model.nq :]
        M = model.mass_matrix(q)
        np.testing.assert_array_equal(M, M.T)
        np.testing.assert_array_equal(M, model.mass_matrix(x))
        assert np.linalg.eigvalsh(M)[0] > 0
        np.testing.assert_allclose(M, reference.mass_matrix(q), atol=ROUNDING * np.abs(M).max())
        kinetic, potential = model.energy(x)
        assert (kinetic, potential) == pytest.approx(
            reference.energy(q, v), rel=ROUNDING, abs=ROUNDING
        )
        assert kinetic == pytest.approx(v @ M @ v / 2, rel=ROUNDING)
        for body, row in zip(model.system.bodies, model.frames(x), strict=True):
            R, p = reference.pose(body.frame, q)
            made = row.reshape(3, 4)
            np.testing.assert_allclose(made[:, :3], R.real, atol=1e-13)
            np.testing.assert_allclose(made[:, 3], p.real, atol=1e-13)


@pytest.mark.parametrize("seed", SEEDS)
def test_energy_changes_by_the_power_of_the_inputs(seed: int) -> None:
    """G2 at a point: dE/dt along f, by central differences, is u . (B^T q_dot)."""
    model = compiled_random(seed)
    reference = reference_of(seed)
    for x, u in sample(seed):
        f, h = model.f(x, u), 1e-5
        ends = [sum(model.energy(x + s * f)) for s in (-h, h, -2 * h, 2 * h)]
        change = (8 * (ends[1] - ends[0]) - (ends[3] - ends[2])) / (12 * h)
        power = float(u @ reference.unit_powers(x[: model.nq], x[model.nq :])) if model.nu else 0.0
        # Rounding of E (about 100 J) over h = 1e-5 s is 1e-9 W; h^4 f^4 adds less.
        assert change == pytest.approx(power, rel=1e-6, abs=1e-6 * (1 + np.abs(f).max()))


@pytest.mark.parametrize("seed", [0, 3, 5, 8, 11, 14])
def test_energy_is_the_work_done_along_a_run(seed: int) -> None:
    """G2 along DOP853: E(t) - E(0) is the integral of the inputs' power."""
    model = compiled_random(seed)
    reference = reference_of(seed)
    x, u = sample(seed, 1)[0]

    def rates(_: float, both: Array) -> Array:
        q, v = both[: model.nq], both[model.nq : -1]
        power = u @ reference.unit_powers(q, v) if model.nu else 0.0
        return np.append(model.f(both[:-1], u), power)

    run = solve_ivp(rates, (0, 0.4), np.append(x, 0.0), "DOP853", rtol=1e-9, atol=1e-10)
    assert run.success
    change = sum(model.energy(run.y[:-1, -1])) - sum(model.energy(x))
    size = abs(model.energy(run.y[:-1, -1])[0]) + 1.0
    assert change == pytest.approx(run.y[-1, -1], abs=1e-7 * size)  # 100 times the solver's rtol


@pytest.mark.parametrize("seed", SEEDS)
def test_velocity_terms_are_quadratic(seed: int) -> None:
    """G3: c(q, 2 v) = 4 c(q, v); gravity is what is left at rest."""
    model = compiled_random(seed)
    n = model.nq
    for x, u in sample(seed):
        at = [model.f(np.concatenate([x[:n], s * x[n:]]), u)[n:] for s in (0, 1, 2, -1)]
        scale = 1 + max(np.abs(a).max() for a in at)
        np.testing.assert_allclose(at[2] - at[0], 4 * (at[1] - at[0]), atol=ROUNDING * scale)
        np.testing.assert_allclose(at[3], at[1], atol=ROUNDING * scale)


@pytest.mark.parametrize("seed", range(12))
def test_forces_enter_linearly_and_with_the_inverse_of_the_mass(seed: int) -> None:
    model = compiled_random(seed)
    B = reference_of(seed).input_matrix
    for x, u in sample(seed):
        change = model.f(x, u)[model.nq :] - model.f(x)[model.nq :]
        expected = B(x[: model.nq]) @ u
        M = model.mass_matrix(x)
        np.testing.assert_allclose(M @ change, expected, atol=1e-9 * (1 + np.abs(M).max()))


def free_body() -> System:
    """One rigid body in space, ZYX Euler angles, gravity along -z."""
    x, y, z = length("x"), length("y"), length("z")
    yaw, pitch, roll = angle("yaw"), angle("pitch"), angle("roll")
    frame = move(x, y, z) @ rot_z(yaw) @ rot_y(pitch) @ rot_x(roll)
    body = Body("b", frame, mass=2.0, inertia=(0.3, 0.5, 0.7))
    return System("free", bodies=[body], gravity=toward("-z", 9.81))


def test_a_free_body_falls_and_keeps_its_angular_momentum() -> None:
    """Euler's equations, by the conserved R I omega."""
    model = free_body().model()
    x0 = np.array([0.1, 0.2, 3.0, 0.3, 0.2, -0.4, 1.0, -2.0, 0.5, 0.7, -0.4, 1.1])
    run = solve_ivp(
        lambda _, x: model.f(x), (0, 1.0), x0, "DOP853", rtol=1e-11, atol=1e-12, t_eval=[0, 0.5, 1]
    )
    moments = []
    for t, x in zip(run.t, run.y.T, strict=True):
        fallen = x0[:3] + x0[6:9] * t - [0, 0, 9.81 * t**2 / 2]
        np.testing.assert_allclose(x[:3], fallen, atol=1e-9)  # [m], the solver's rtol times 10
        h = 1e-5
        ends = [model.frames(x + s * model.f(x)).reshape(3, 4)[:, :3] for s in (h, -h)]
        R = model.frames(x).reshape(3, 4)[:, :3]
        hat = R.T @ (ends[0] - ends[1]) / (2 * h)
        moments.append(R @ ([0.3, 0.5, 0.7] * np.array([hat[2, 1], hat[0, 2], hat[1, 0]])))
    for moment in moments[1:]:
        np.testing.assert_allclose(moment, moments[0], atol=1e-8)  # [kg m^2/s], differences' error


def test_moving_and_yawing_a_free_body_moves_and_yaws_its_motion() -> None:
    """G5."""
    model, rng = free_body().model(), np.random.default_rng(4)
    for _ in range(5):
        x, turn = rng.uniform(-1, 1, 12), rng.uniform(-3, 3)
        c, s = np.cos(turn), np.sin(turn)
        R = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
        moved = x.copy()
        moved[:3], moved[6:9], moved[3] = R @ x[:3] + [1, 2, 3], R @ x[6:9], x[3] + turn
        f, g = model.f(x), model.f(moved)
        f[:3], f[6:9] = R @ f[:3], R @ f[6:9]
        np.testing.assert_allclose(g, f, atol=1e-12)


def test_reacting_forces_and_torques_leave_the_total_momentum() -> None:
    """A force and its reaction on the same line cancel in the sums of m a and r x m a + I alpha."""
    x1, y1, a1 = length("x1"), length("y1"), angle("a1")
    x2, y2, a2 = length("x2"), length("y2"), angle("a2")
    one = Body("one", move(x1, y1) @ rot_z(a1), mass=1.0, inertia=0.1)
    two = Body("two", move(x2, y2) @ rot_z(a2), mass=3.0, inertia=0.4)
    system = System(
        "pair",
        bodies=[one, two],
        inputs=[
            Force("F", on=one, along=two.frame.x, reacts_on=two, limit=1),
            Torque("T", on=one, about=WORLD.z, reacts_on=two, limit=1),
        ],
    )
    model = system.model()
    x = np.array([0.1, 0.2, 0.3, -1, 2, 0.9, *np.zeros(6)])
    acceleration = model.f(x, [2.0, 0.5])[6:]
    along = 2.0 * np.array([np.cos(0.9), np.sin(0.9)])
    np.testing.assert_allclose(acceleration[:2], along / 1.0, atol=1e-14)
    np.testing.assert_allclose(acceleration[3:5], -along / 3.0, atol=1e-14)
    arm = np.array([0.1 - (-1), 0.2 - 2])  # from two's centre to where the reaction acts
    moment = -0.5 - (arm[0] * along[1] - arm[1] * along[0])
    assert acceleration[[2, 5]] == pytest.approx([0.5 / 0.1, moment / 0.4])
    masses, places = np.array([1.0, 3.0]), x[[0, 1, 3, 4]].reshape(2, 2)
    pushes = masses[:, None] * acceleration[[0, 1, 3, 4]].reshape(2, 2)
    orbital = places[:, 0] * pushes[:, 1] - places[:, 1] * pushes[:, 0]
    total = orbital.sum() + 0.1 * acceleration[2] + 0.4 * acceleration[5]
    assert total == pytest.approx(0.0, abs=1e-13)  # [kg m^2/s^2], of about 6


def test_a_spherical_pendulum_on_a_cart_is_lagranges() -> None:
    """SymPy's LagrangesMethod on energies written by hand; three coordinates."""
    x, th, ph = length("x"), angle("th"), angle("ph")
    rod = move(x) @ rot_z(ph) @ rot_y(th)
    cart_body = Body("cart", move(x), mass=2.0)
    bob = Body("bob", rod @ move(0, 0, -0.7), mass=0.5)
    push = Force("F", on=cart_body, along=WORLD.x, limit=1)
    system = System("s", bodies=[cart_body, bob], inputs=[push], gravity=toward("-z", 9.81))
    model = system.model()

    X, T, P = dynamicsymbols("X T P")
    F = sp.Symbol("F")
    t = dynamicsymbols._t
    place = sp.Matrix(
        [X - 0.7 * sp.cos(P) * sp.sin(T), -0.7 * sp.sin(P) * sp.sin(T), -0.7 * sp.cos(T)]
    )
    speed = place.diff(t)
    L = X.diff(t) ** 2 + 0.25 * speed.dot(speed) - 0.5 * 9.81 * place[2]
    method = LagrangesMethod(L, [X, T, P])
    method.form_lagranges_equations()
    speeds = [s.diff(t) for s in (X, T, P)]
    symbols = [*sp.symbols("q:3"), *sp.symbols("v:3")]
    named = dict(zip([*speeds, X, T, P], [*symbols[3:], *symbols[:3]], strict=True))
    M = sp.lambdify(symbols, method.mass_matrix.subs(named))
    force = sp.lambdify([*symbols, F], (method.forcing + sp.Matrix([F, 0, 0])).subs(named))
    for row in np.random.default_rng(0).uniform(0.2, 1.5, (5, 6)):
        values = [
            row[list(model.state_names).index(n)]
            for n in ("x", "th", "ph", "x_dot", "th_dot", "ph_dot")
        ]
        expected = np.linalg.solve(M(*values), force(*values, 0.8)).ravel()
        order = [("x", "th", "ph").index(n) for n in model.coordinate_names]
        np.testing.assert_allclose(model.f(row, [0.8])[3:], expected[order], atol=1e-11)


def test_gravity_acts_in_the_direction_that_is_down() -> None:
    x, y, z = length("x"), length("y"), length("z")
    field = Gravity((0.48, -0.6, 0.64), sp.Integer(5))
    model = System("ball", bodies=[Body("b", move(x, y, z), mass=3)], gravity=field).model()
    np.testing.assert_allclose(model.f(np.zeros(6))[3:], [2.4, -3.0, 3.2], atol=1e-15)


@pytest.mark.parametrize("expression", ["sqrt", "log", "reciprocal root"])
def test_a_frame_may_be_undefined_outside_a_coordinates_limits(expression: str) -> None:
    """Checks made while deriving must look at states inside the limits alone."""
    cable = length("cable", 0.1, 0.2)
    place = {
        "sqrt": sp.sqrt(cable),
        "log": sp.log(cable),
        "reciprocal root": 1 / sp.sqrt(cable),
    }[expression]
    model = System("s", bodies=[Body("b", move(place), mass=2.0)]).model()
    slope = sp.lambdify(cable, sp.diff(place, cable))(0.15)
    assert model.mass_matrix([0.15])[0, 0] == pytest.approx(2.0 * slope**2, rel=1e-12)


def test_a_light_part_on_a_heavy_machine_has_mass() -> None:
    """A 20 t bridge and a 1 g knob of 2 mm radius: light is not massless."""
    x, turn = length("x"), angle("turn")
    bridge = Body("bridge", move(x), mass=20000.0)
    knob = Body("knob", move(x) @ rot_z(turn), mass=0.001, inertia=2e-9)
    model = System("s", bodies=[bridge, knob]).model()
    assert model.mass_matrix([0.0, 0.0])[1, 1] == pytest.approx(2e-9)
