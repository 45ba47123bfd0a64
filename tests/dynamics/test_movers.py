"""Paths of obstacles that move: polylines, angles of rotations, corners that suffice."""

import numpy as np
import pytest
import sympy
from scipy.spatial.transform import Rotation

from kinolab.dynamics import Box, Cylinder, Sphere
from kinolab.dynamics.movers import (
    corners_of,
    fastest_between,
    parametric_polyline,
    polyline,
    polyline_values,
    roll_pitch_yaw,
    t,
)

CORNERS = np.array(
    [
        [1.0, 0.0, 2.0, 0.5, 0.0, 0.0, 0.0],
        [2.0, 3.0, 2.0, 0.5, 0.0, 0.0, 1.0],
        [2.5, 3.0, 1.0, 0.5, 0.2, 0.0, 1.0],
        [4.0, 0.0, 2.0, 0.5, 0.0, 0.3, -1.0],
    ]
)
TIMES = np.linspace(0.0, 6.0, 61)


def expected(entry: int) -> np.ndarray:
    return np.interp(TIMES, CORNERS[:, 0], CORNERS[:, 1 + entry])


def test_a_polyline_is_linear_between_its_corners() -> None:
    for entry, made in enumerate(polyline(CORNERS)):
        found = np.broadcast_to(sympy.lambdify(t, made, "numpy")(TIMES), TIMES.shape)
        np.testing.assert_allclose(found, expected(entry), atol=1e-12)


def test_a_polyline_of_parameters_is_the_same() -> None:
    values = polyline_values("m", 8, CORNERS)
    for entry, made in enumerate(parametric_polyline("m", 8)):
        given = made.subs({symbol: values[str(symbol)] for symbol in made.free_symbols - {t}})
        found = np.broadcast_to(sympy.lambdify(t, given, "numpy")(TIMES), TIMES.shape)
        np.testing.assert_allclose(found, expected(entry), atol=1e-9)


def test_angles_of_rotations_go_on_where_one_spins() -> None:
    """A wheel about its axle y: its roll and its yaw stay, its pitch is past a quarter turn."""
    spin = np.linspace(0.0, 9.0, 50)
    turns = Rotation.from_euler("ZY", np.column_stack([np.full(50, 0.4), spin])).as_matrix()
    found = roll_pitch_yaw(turns)
    np.testing.assert_allclose(found[:, 1], spin, atol=1e-9)
    np.testing.assert_allclose(found[:, 2], 0.4, atol=1e-9)


def test_angles_make_the_rotations_again() -> None:
    turns = Rotation.random(200, random_state=0).as_matrix()
    roll, pitch, yaw = roll_pitch_yaw(turns).T
    again = Rotation.from_euler("ZYX", np.column_stack([yaw, pitch, roll])).as_matrix()
    np.testing.assert_allclose(again, turns, atol=1e-9)


@pytest.mark.parametrize(
    "shape", [Box(0.4, 0.2, 0.6), Cylinder(0.3, 0.1, axis="y"), Cylinder(0.2, 0.5), Sphere(0.3)]
)
def test_few_corners_keep_all_points_near(shape: Box | Cylinder | Sphere) -> None:
    times = np.linspace(0.0, 4.0, 400)
    place = np.column_stack([np.sin(times), np.cos(0.7 * times), 0.1 * times])
    turns = Rotation.from_euler("ZYX", np.column_stack([times, 0.4 * np.sin(times), 0.2 * times]))
    poses = np.concatenate([turns.as_matrix(), place[:, :, None]], axis=2)
    corners = corners_of([shape], times, poses, 0.01)
    assert len(corners) < 80
    kept = np.array([np.interp(times, corners[:, 0], values) for values in corners[:, 1:].T]).T
    again = Rotation.from_euler("ZYX", kept[:, [5, 4, 3]])
    way = np.random.default_rng(0).normal(size=(40, 3))
    for k in range(0, 400, 7):  # how far the solid reaches along a direction of the world
        for n in way / np.linalg.norm(way, axis=1)[:, None]:
            true = reach(shape, turns[k].as_matrix().T @ n) + place[k] @ n
            found = reach(shape, again[k].as_matrix().T @ n) + kept[k, :3] @ n
            assert abs(true - found) < 0.011


def reach(shape: object, n: np.ndarray) -> float:
    """The support function, from its definition."""
    if isinstance(shape, Sphere):
        return 0.3
    if isinstance(shape, Box):
        return float(np.abs(n) @ (0.2, 0.1, 0.3))
    axis = "xyz".index(shape.axis)
    along = abs(n[axis])
    return float(shape.radius) * np.sqrt(max(0.0, 1 - along**2)) + float(shape.length) / 2 * along


def test_the_fastest_point() -> None:
    assert fastest_between(CORNERS[:, 0], CORNERS[:, 1:]) == pytest.approx(
        np.hypot(3.0, 0.0) + 1.0, rel=1e-12
    )
