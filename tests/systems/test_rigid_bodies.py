"""OMPL.app's machines move as the equations in its headers say, which are typed in here."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import kinolab
from kinolab.dynamics import Model, System
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.dynamics.language.shapes import Box
from kinolab.numerics.arrays import Array
from kinolab.robots.omplapp import parts_of
from kinolab.robots.tree.kinematic_tree import PlacedShape, pose_of
from kinolab.systems import _rigid_bodies as machines

BAR = PlacedShape(Box(2.0, 1.0, 0.5), pose_of(np.array([0.3, 0.0, 0.1]), np.eye(3)))
HULL = parts_of([BAR])
G = 9.81  # [m/s^2], as in QuadrotorPlanning.cpp


def states(model: Model, count: int = 20) -> list[tuple[Array, Array]]:
    """Return random states and inputs, angles of steering below a right angle."""
    random = np.random.default_rng(3)
    found = []
    for _ in range(count):
        x, u = random.uniform(-1.0, 1.0, model.nx), random.uniform(-1.0, 1.0, model.nu)
        for first in model.attitudes.values():
            x[first : first + 4] /= np.linalg.norm(x[first : first + 4])
        found.append((x, u))
    return found


def kinematic_car(x: Array, u: Array) -> list[float]:
    _, _, theta = x
    v, phi = u
    return [v * np.cos(theta), v * np.sin(theta), v * np.tan(phi)]  # L = 1


def dynamic_car(x: Array, u: Array) -> list[float]:
    _, _, theta, phi, v = x
    a, steering = u
    return [v * np.cos(theta), v * np.sin(theta), v * np.tan(phi), steering, a]  # m = L = 1


def blimp(x: Array, u: Array) -> list[float]:
    theta, rates = x[3], x[4:]
    f, up, turn = u
    return [*rates, f * np.cos(theta), f * np.sin(theta), up, turn]


PUBLISHED: dict[str, tuple[Callable[..., System], Callable[[Array, Array], list[float]], str]] = {
    "kinematic_car": (machines.kinematic_car, kinematic_car, "x y theta"),
    "dynamic_car": (machines.dynamic_car, dynamic_car, "x y theta phi v"),
    "blimp": (machines.blimp, blimp, "x y z theta x_dot y_dot z_dot theta_dot"),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_machines_move_as_published(name: str) -> None:
    make, law, order = PUBLISHED[name]
    model = make(HULL).model()
    assert " ".join(model.state_names) == order
    for x, u in states(model):
        assert model.f(x, u) == pytest.approx(law(x, u), abs=1e-12)


def test_the_quadrotor_moves_as_published() -> None:
    """m p'' = -u0 n - beta p' - m g with n the body's z axis; its turn rates grow by u1 to u3."""
    model = machines.quadrotor(HULL).model()
    rates = "x_dot y_dot z_dot R_wx R_wy R_wz"
    assert " ".join(model.state_names) == f"x y z R_x R_y R_z R_w {rates}"
    for x, u in states(model):
        turn, speed, spin = Rotation.from_quat(x[3:7]), x[7:10], x[10:]
        found = model.f(x, u)
        assert found[:3] == pytest.approx(speed, abs=1e-12)
        n = turn.apply([0.0, 0.0, 1.0])
        assert found[7:10] == pytest.approx(-u[0] * n - speed - [0.0, 0.0, G], abs=1e-12)
        assert found[10:] == pytest.approx(u[1:], abs=1e-12)
        later = (turn * Rotation.from_rotvec(1e-6 * spin)).as_quat()
        later *= np.sign(later @ x[3:7])
        assert found[3:7] == pytest.approx((later - x[3:7]) / 1e-6, abs=1e-5)


def test_it_hovers_upside_down_alone() -> None:
    model = machines.quadrotor(HULL).model()
    x = np.zeros(model.nx)
    x[3] = 1.0  # half a turn about x
    assert model.f(x, np.array([G, 0.0, 0.0, 0.0])) == pytest.approx(np.zeros(13), abs=1e-12)


@pytest.mark.parametrize("make", [machines.planar_body, machines.free_body])
def test_velocities_of_free_bodies_are_inputs(make: Callable[..., System]) -> None:
    model = make(HULL, speed=4.0, turning=1.0).model()
    places = model.nu // 2 + 1 if model.nu == 3 else 3
    for x, u in states(model):
        found = model.f(x, u)
        assert found[:places] == pytest.approx(u[:places], abs=1e-12)
        if model.nu == 3:
            assert found[2] == pytest.approx(u[2], abs=1e-12)
            continue
        turn = Rotation.from_quat(x[3:7])
        later = (turn * Rotation.from_rotvec(1e-6 * u[3:])).as_quat()
        later *= np.sign(later @ x[3:7])
        assert found[3:7] == pytest.approx((later - x[3:7]) / 1e-6, abs=1e-5)


# Limits of setDefaultBounds: of inputs, and of rates in the order of the state.
LIMITS = {
    "kinematic_car": {"v": 5.0, "phi": np.deg2rad(30)},
    "dynamic_car": {"a": 0.5, "phi_rate": np.deg2rad(2)},
    "blimp": {"u_f": 1.0, "u_z": 1.0, "u_theta": 0.3},
    "quadrotor": {"u0": (5.0, 15.0), "u1": 1.0, "u2": 1.0, "u3": 1.0},
}


@pytest.mark.parametrize("name", LIMITS)
def test_inputs_have_the_published_limits(name: str) -> None:
    given = {one.name: bounds_of(one) for one in getattr(machines, name)(HULL).inputs}
    wanted = {
        key: one if isinstance(one, tuple) else (-one, one) for key, one in LIMITS[name].items()
    }
    assert given.keys() == wanted.keys()
    for key, limits in wanted.items():
        assert given[key] == pytest.approx(limits)


RATES = {
    "dynamic_car": [-1.0, 1.0],
    "blimp": [-1.0, 1.0, -1.0, 1.0, -1.0, 1.0, -0.2, 0.2],
    "quadrotor": [-1.0, 1.0] * 6,
}


@pytest.mark.parametrize("name", RATES)
def test_speeds_have_the_published_limits(name: str) -> None:
    """As a scenario has them, whose workspace is not limited by the machine."""
    bounds = {axis: [-9.0, 9.0] for axis in "xyz"[: 2 if name == "dynamic_car" else 3]}
    table = {"system": getattr(machines, name)(HULL), "bounds": bounds, "start": {}}
    problem = kinolab.load(table)
    first = list(problem.model.state_names).index("v" if name == "dynamic_car" else "x_dot")
    assert problem.bounds[first:].reshape(-1).tolist() == pytest.approx(RATES[name])


def test_shapes_are_where_the_solids_are() -> None:
    """One along the axes and one that is turned, which is a body of its own."""
    turn = Rotation.from_euler("z", 30, degrees=True).as_matrix()
    oblique = PlacedShape(Box(1.0, 0.2, 0.2), pose_of(np.array([1.0, 2.0, 0.0]), turn))
    system = machines.planar_body(parts_of([BAR, oblique]), speed=1.0, turning=1.0)
    first, second = system.bodies
    assert first.shapes == (Box(2.0, 1.0, 0.5, at=(0.3, 0.0, 0.1)),)
    model = system.model()
    frames = model.frames(np.array([5.0, 0.0, np.pi / 2])).reshape(2, 3, 4)
    assert frames[1, :, 3] == pytest.approx([3.0, 1.0, 0.0])  # (1, 2) turned to the left, and moved
    assert frames[1, :, 0] == pytest.approx([-0.5, np.sqrt(0.75), 0.0])
    assert second.name == "robot 2"
