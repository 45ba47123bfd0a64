"""point_speed bounds how fast a body's shapes move as sets, and is not absurdly loose."""

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp

import kinolab.systems
from kinolab.dynamics import (
    Body,
    Box,
    Capsule,
    Cylinder,
    Disk,
    Model,
    Sphere,
    System,
    angle,
    length,
    move,
    parameter,
    rot_x,
    rot_y,
    rot_z,
)
from kinolab.dynamics.language.shapes import AxisName
from kinolab.dynamics.language.shapes.bounding_radius import bounding_radius

Array = Any  # NumPy arrays of float64
CENTRES = [(0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, -0.2, 0.0), (0.1, 0.2, -0.3), (0.0, 0.0, 0.5)]
NAMES: tuple[AxisName, ...] = ("x", "y", "z")
SHAPES: list[Any] = [
    shape
    for at in CENTRES
    for shape in (
        Box(0.3, 0.5, 0.2, at),
        Sphere(0.25, at),
        *(Cylinder(0.2, 0.6, axis, at) for axis in NAMES),
        *(Capsule(0.15, 0.5, axis, at) for axis in NAMES),
        *(Disk(0.3, 0.04, axis, at) for axis in NAMES),
    )
]


def radial(shape: Any, local: Array) -> tuple[Array, Array]:
    """Distance from the shape's axis and height along it."""
    i = "xyz".index(shape.axis)
    return np.linalg.norm(np.delete(local, i, axis=-1), axis=-1), np.abs(local[..., i])


def distance(shape: Any, points: Array) -> Array:
    """Distance of points in the body's frame from the solid, 0 inside; shape (n,)."""
    local = points - np.array(shape.at, float)
    if isinstance(shape, Box):
        outside = np.abs(local) - np.array([shape.x, shape.y, shape.z]) / 2
        return np.linalg.norm(np.maximum(outside, 0.0), axis=-1)
    if isinstance(shape, Sphere):
        return np.maximum(np.linalg.norm(local, axis=-1) - shape.radius, 0.0)
    r, h = radial(shape, local)
    if isinstance(shape, Capsule):
        beyond = np.maximum(h - shape.length / 2, 0.0)
        return np.maximum(np.hypot(r, beyond) - shape.radius, 0.0)
    half = (shape.length if isinstance(shape, Cylinder) else shape.thickness) / 2
    return np.hypot(np.maximum(r - shape.radius, 0.0), np.maximum(h - half, 0.0))


def surface(shape: Any, rng: Any) -> Array:
    """Points of the solid's surface with all its corners, rims and poles, shape (n, 3)."""
    directions = rng.normal(size=(400, 3))
    directions = np.concatenate([directions, np.eye(3), -np.eye(3)])
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    if isinstance(shape, Box):
        corners = np.array(np.meshgrid(*[(-1, 1)] * 3)).reshape(3, -1).T
        faces = directions / np.abs(directions).max(axis=1)[:, None]
        unit = np.concatenate([corners, faces])
        return unit * np.array([shape.x, shape.y, shape.z]) / 2 + np.array(shape.at)
    if isinstance(shape, Sphere):
        return directions * shape.radius + np.array(shape.at)
    i = "xyz".index(shape.axis)
    if isinstance(shape, Capsule):
        local = directions * shape.radius
        local[:, i] += np.sign(directions[:, i]) * shape.length / 2
        return local + np.array(shape.at)
    half = (shape.length if isinstance(shape, Cylinder) else shape.thickness) / 2
    around = rng.uniform(0, 2 * np.pi, 200)
    local = np.empty((400, 3))
    local[:, (i + 1) % 3] = shape.radius * np.cos(np.tile(around, 2))
    local[:, (i + 2) % 3] = shape.radius * np.sin(np.tile(around, 2))
    local[:, i] = np.repeat([-half, half], 200)
    return local + np.array(shape.at)


@cache
def body_with(*shapes: Any) -> Model:
    """One rigid body in space whose parts have these shapes, each part a body of its own.

    The parts share one frame, so that one machine shows what becomes of each shape; the first
    weighs, and with equal moments of inertia it keeps turning however it is turned.
    """
    x, y, z = length("x"), length("y"), length("z")
    a, b, c = angle("a"), angle("b"), angle("c")
    frame = move(x, y, z) @ rot_z(a) @ rot_y(b) @ rot_x(c)
    parts = [
        Body(f"part {k}", frame, mass=float(not k), inertia=float(not k), shape=shape)
        for k, shape in enumerate(shapes)
    ]
    return System("s", bodies=parts).model()


def set_speeds(model: Model, shapes: Sequence[Any], x: Array, rng: Any) -> Array:
    """How fast the farthest point leaves the set that each part was, in [m/s]."""
    h = 1e-5
    now, later = (model.frames(x + s * model.f(x)).reshape(-1, 3, 4) for s in (0.0, h))
    speeds = []
    for shape, before, after in zip(shapes, now, later, strict=True):
        world = surface(shape, rng) @ after[:, :3].T + after[:, 3]
        back = (world - before[:, 3]) @ before[:, :3]
        speeds.append(distance(shape, back).max() / h)
    return np.array(speeds)


def test_no_point_leaves_its_body_faster_than_the_bound() -> None:
    model, rng = body_with(*SHAPES), np.random.default_rng(1)
    loosest = np.zeros(len(SHAPES))
    for k in range(6):
        x = rng.uniform(-1, 1, 12)
        if k % 2:
            x[6:9] = 0.0  # turning alone
        speeds, bounds = set_speeds(model, SHAPES, x, rng), model.point_speed(x)
        # h times the accelerations, 1e-5 s * 10 m/s^2
        faster = [str(SHAPES[i]) for i in np.flatnonzero(speeds > bounds * (1 + 1e-4) + 1e-4)]
        assert faster == []
        shares = np.divide(speeds, bounds, out=np.zeros_like(speeds), where=bounds > 0)
        loosest = np.maximum(loosest, shares)
    for shape, share in zip(SHAPES, loosest, strict=True):
        central = isinstance(shape, Sphere) and not any(shape.at)
        # A central ball's bound is exact, here up to the 400 sampled points; others are a fair
        # share.
        assert share > (0.98 if central else 0.4), shape


def test_the_reach_is_a_ball_that_contains_the_shape() -> None:
    for shape in SHAPES:
        radius = float(bounding_radius(shape).radius)
        farthest = np.linalg.norm(surface(shape, np.random.default_rng(0)), axis=1).max()
        assert farthest <= radius * (1 + 1e-12), shape
        # centre and half diagonal added up, at worst at right angles
        assert radius <= 1.8 * farthest, shape


def test_spin_that_leaves_the_shape_in_place_is_the_only_one_that_does_not_count() -> None:
    model, rng = body_with(*SHAPES), np.random.default_rng(2)
    for i, axis in enumerate("xyz"):
        x = np.zeros(12)
        x[6 + 3 + (2 - i)] = 2.0  # a, b, c turn about z, y, x
        moves = set_speeds(model, SHAPES, x, rng) > 1e-3
        counted = model.point_speed(x) > 1e-3
        for k, shape in enumerate(SHAPES):
            assert counted[k] or not moves[k], f"spin about {axis} moves {shape} unseen"
            assert counted[k] == (axis not in bounding_radius(shape).symmetric_about), shape


def test_a_disk_that_spins_about_its_axle_stands_still() -> None:
    model = body_with(Disk(0.3, 0.05, "y"))
    assert model.point_speed([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 5.0, 0]) == pytest.approx([0.0])


def test_a_body_of_several_shapes_is_as_fast_as_the_fastest() -> None:
    small, large = Sphere(0.1, at=(0.0, 0.1, 0.0)), Sphere(0.1, at=(0.0, 0.9, 0.0))
    model = body_with((large, small))
    x = np.zeros(12)
    x[9] = 2.0
    bound = float(model.point_speed(x)[0])
    assert 2.0 * 0.9 <= bound <= 2.0 * 1.0 + 1e-12


def test_a_body_without_shape_is_as_fast_as_its_centre() -> None:
    model = System("s", bodies=[Body("b", move(length("x")), mass=1)]).model()
    assert model.point_speed([0.0, -3.0]) == pytest.approx([3.0])


def test_dimensions_may_be_parameters_given_at_run_time() -> None:
    R, th = parameter("R", 0.5, "m"), angle("th")
    rod = Body("b", rot_z(th), mass=1, inertia=1, shape=Box(2 * R, 1e-9, 1e-9))
    model = System("s", bodies=[rod]).model()
    assert model.point_speed([0, 3.0]) == pytest.approx([1.5])
    assert model.point_speed([0, 3.0], R=2.0) == pytest.approx([6.0])


def test_the_rolling_coin_moves_as_fast_as_it_rolls() -> None:
    model = kinolab.systems.get("rolling_disk").model()
    x = [0, 0, 0.3, 0.2, 0.0, 4.0]
    assert model.point_speed(x) == pytest.approx([0.25 * 4.0], rel=1e-12)


def test_a_squared_radius_is_no_larger_reach_than_the_shape() -> None:
    assert bounding_radius(Box(3.0, 4.0, 12.0)).radius == pytest.approx(6.5)
    assert bounding_radius(Cylinder(3.0, 8.0)).radius == pytest.approx(5.0)
    assert bounding_radius(Capsule(1.0, 8.0)).radius == pytest.approx(5.0)
    assert (
        sp.simplify(bounding_radius(Sphere(parameter("R", 1.0))).radius - parameter("R", 1.0)) == 0
    )
