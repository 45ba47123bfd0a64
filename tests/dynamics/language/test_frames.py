"""Frames and body velocities against matrices and their differences."""

from functools import partial

import numpy as np
import pytest
import sympy as sp

from kinolab.dynamics import (
    WORLD,
    Body,
    System,
    Torque,
    angle,
    hat,
    homogeneous,
    length,
    move,
    rate,
    rot_x,
    rot_y,
    rot_z,
    unhat,
    velocity,
)
from kinolab.dynamics.language.frames import Frame, pose, time_derivative
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from tests.dynamics.machines import random_machine
from tests.dynamics.reference import Array, Reference, taylor

SEEDS = range(8)
ROUNDING = 1e-11  # SI; values are of order 10


@pytest.mark.parametrize("seed", SEEDS)
def test_the_symbolic_velocity_is_the_derivative_of_the_pose(seed: int) -> None:
    """unhat(g^-1 g_dot), from the poses alone."""
    reference = Reference(random_machine(seed))
    rng = np.random.default_rng(seed)
    n = reference.size
    q, q_dot = rng.uniform(-1, 1, n), rng.uniform(-2, 2, n)

    def part(index: int, frame: Frame, at: Array) -> Array:
        return reference.pose(frame, at)[index]

    for body in reference.system.bodies:
        R, R_dot, _ = taylor(partial(part, 0, body.frame), q, q_dot)
        p_dot = taylor(partial(part, 1, body.frame), q, q_dot)[1]
        hat = R.T @ R_dot
        V = velocity(body.frame)
        made = [
            reference._function(c, rates=True)(np.concatenate([q, q_dot])).real
            for c in (V.x, V.y, V.z, V.wx, V.wy, V.wz)
        ]
        np.testing.assert_allclose(made[:3], R.T @ p_dot, atol=ROUNDING)
        np.testing.assert_allclose(made[3:], [hat[2, 1], hat[0, 2], hat[1, 0]], atol=ROUNDING)
        np.testing.assert_allclose(hat + hat.T, 0, atol=ROUNDING)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_symbolic_pose_is_the_product_of_the_motions(seed: int) -> None:
    reference = Reference(random_machine(seed))
    q = np.random.default_rng(seed).uniform(-1, 1, reference.size)
    for body in reference.system.bodies:
        R, p = pose(body.frame)
        made = np.array([[reference._function(e)(q).real for e in R.row(i)] for i in range(3)])
        place = np.array([reference._function(e)(q).real for e in p])
        expected = reference.pose(body.frame, q)
        np.testing.assert_allclose(made, expected[0].real, atol=ROUNDING)
        np.testing.assert_allclose(place, expected[1].real, atol=ROUNDING)


@pytest.mark.parametrize("name", ["x", "y", "z"])
def test_the_negative_of_an_axis_points_the_other_way(name: str) -> None:
    """A pendulum that a torque turns about it accelerates the other way, from its file as well."""
    theta = angle("theta")
    turn = {"x": rot_x, "y": rot_y, "z": rot_z}[name](theta)
    wheel = Body("wheel", turn, inertia=0.5)
    axis = getattr(WORLD, name)
    for about, slope in ((axis, 6.0), (-axis, -6.0)):
        motor = Torque("motor", on=wheel, about=about, limit=5.0)
        machine = System("wheel", bodies=[wheel], inputs=[motor])
        kept = System.of(machine_from_json(machine_to_json(machine)))
        for one in (machine, kept):
            assert one.model().f([0.3, 0.0], [3.0]) == pytest.approx([0.0, slope])


def test_a_quarter_turn_is_right_handed() -> None:
    turn = sp.pi / 2
    for frame, before, after in (
        (rot_x(turn), (0, 1, 0), (0, 0, 1)),
        (rot_y(turn), (0, 0, 1), (1, 0, 0)),
        (rot_z(turn), (1, 0, 0), (0, 1, 0)),
    ):
        assert tuple(pose(frame)[0] * sp.Matrix(before)) == after


def test_a_move_goes_along_the_axes_it_is_multiplied_to() -> None:
    assert tuple(pose(rot_z(sp.pi / 2) @ move(2))[1]) == (0, 2, 0)
    assert tuple(pose(move(2) @ rot_z(sp.pi / 2))[1]) == (2, 0, 0)
    assert tuple(pose(WORLD @ move(1, 2, 3) @ WORLD)[1]) == (1, 2, 3)


def test_products_of_frames_are_associative() -> None:
    x, th = length("x"), angle("th")
    a, b, c = move(x), rot_y(th), move(0, x, 1)
    assert (a @ b) @ c == a @ (b @ c)


def test_the_time_derivative_is_the_chain_rule() -> None:
    x, th = length("x"), angle("th")
    made = time_derivative(x**2 * sp.sin(th))
    expected = 2 * x * sp.sin(th) * rate(x) + x**2 * sp.cos(th) * rate(th)
    assert sp.expand(made - expected) == 0


def test_a_body_velocity_is_also_two_columns() -> None:
    x, th = length("x"), angle("th")
    V = velocity(move(x) @ rot_z(th))
    assert tuple(V.linear) == (V.x, V.y, V.z)
    assert tuple(V.angular) == (0, 0, rate(th))
    assert sp.simplify(V.x - sp.cos(th) * rate(x)) == 0
    assert sp.simplify(V.y + sp.sin(th) * rate(x)) == 0


@pytest.mark.parametrize("name", ["Abs"])
def test_a_velocity_can_be_compiled_where_its_frame_can(name: str) -> None:
    """|x| moves a frame; its velocity then stands in a constraint."""
    from kinolab.dynamics import Body, System, zero

    x, y = length("x"), length("y")
    frame = move(getattr(sp, name)(x), y)
    body = Body("b", frame, mass=1)
    V = velocity(frame)
    system = System("s", bodies=[body], constraints=[zero(V.y - 2 * V.x, "slope")], velocities=[x])
    model = system.model()
    np.testing.assert_allclose(model.velocity([-1.0, 0.0, 3.0]), [3.0, -6.0], atol=ROUNDING)


def test_body_velocity_is_unhat_of_the_inverse_frame_times_its_rate() -> None:
    """By definition, g^-1 g_dot; the library never forms it but follows the motions outward."""
    x, y, th, q = length("x"), length("y"), angle("th"), angle("q")
    frame = move(x, y, 0.2) @ rot_z(th) @ move(0.3, 0, sp.sin(q)) @ rot_x(q) @ rot_y(2 * th)
    g = homogeneous(frame)
    g_dot = g.applyfunc(time_derivative)
    found = velocity(frame)
    generator = np.random.default_rng(0)
    symbols = sorted(g.free_symbols | {rate(c) for c in (x, y, th, q)}, key=str)
    for _ in range(5):
        point = dict(zip(symbols, generator.normal(size=len(symbols)), strict=True))
        expected = unhat(g.xreplace(point).inv() * g_dot.xreplace(point))
        for name in ("x", "y", "z", "wx", "wy", "wz"):
            difference = getattr(expected, name) - getattr(found, name)
            assert abs(float(difference.subs(point))) < 1e-12


def test_hat_and_unhat_undo_each_other() -> None:
    twist = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    back = unhat(hat(twist))
    assert (back.x, back.y, back.z, back.wx, back.wy, back.wz) == twist
    arm = sp.Matrix([0.3, -0.2, 0.5])
    spin = sp.Matrix(twist[3:])
    assert (hat(twist)[:3, :3] * arm - spin.cross(arm)).norm() < 1e-15
