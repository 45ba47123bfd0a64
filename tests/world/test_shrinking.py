"""Slimmer machines: exact sizes, walls that stay walls, and a ground that stays below."""

from __future__ import annotations

import numpy as np
import pytest

from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Disk, Shape, Sphere
from kinolab.world import (
    BodyGeometry,
    CableGeometry,
    CollisionChecker,
    World,
    box_obstacle,
    feature_points,
)

GAP = 2e-5  # [m]: twice the 1e-5 m by which bodies are inflated

WALL = World((box_obstacle("wall", (1.0, 10.0, 10.0), (0.5, 0.0, 0.0)),))  # its face is at x = 0

# A shape whose farthest point along x is 0.5 m from its centre, and how that is slimmed.
WIDE: dict[str, Shape] = {
    "box": Box(1.0, 0.2, 0.2),
    "sphere": Sphere(0.5),
    "cylinder": Cylinder(0.5, 0.2),
    "lying cylinder": Cylinder(0.1, 1.0, axis="x"),
    "capsule": Capsule(0.2, 0.6, axis="x"),
    "disk": Disk(0.5, 0.05),
}


def pose(x: float, z: float = 0.0) -> np.ndarray:
    return np.array([[1.0, 0, 0, x, 0, 1.0, 0, 0, 0, 0, 1.0, z]])


@pytest.mark.parametrize("name", WIDE)
@pytest.mark.parametrize("by", [0.0, 0.005, 0.08])  # [m]
def test_a_shrunk_machine_comes_nearer_by_exactly_that_much(name: str, by: float) -> None:
    checker = CollisionChecker([BodyGeometry("body", (WIDE[name],))], WALL).slimmer(by)
    touching = -0.5 + by  # [m]
    assert checker.collides(pose(touching + GAP))
    assert not checker.collides(pose(touching - GAP))
    assert bool(checker.contacts(pose(touching + GAP)))
    assert checker.clearance(pose(touching - 0.1)) == pytest.approx(0.1, abs=GAP)


@pytest.mark.parametrize("name", WIDE)
def test_nothing_is_so_slim_that_it_passes_through_walls(name: str) -> None:
    checker = CollisionChecker([BodyGeometry("body", (WIDE[name],))], WALL).slimmer(10.0)
    assert checker.collides(pose(0.0))
    assert checker.collides(pose(0.5))


def test_a_cable_is_shrunk_about_its_line() -> None:
    cable = CableGeometry("rope", 0.1)
    checker = CollisionChecker([], WALL, cables=[cable]).slimmer(0.04)
    table = np.zeros((0, 12))
    for x, touches in ((-0.06 - GAP, False), (-0.06 + GAP, True)):
        ends = np.array([[x, 0.0, -1.0, x, 0.0, 1.0]])
        assert checker.collides(table, ends) is touches


def test_a_shrunk_wheel_does_not_sink_and_a_shrunk_hull_comes_lower() -> None:
    wheel = BodyGeometry("wheel", (Sphere(0.1),), touches_ground=True)
    hull = BodyGeometry("hull", (Sphere(0.1),))
    for body, lowest in ((wheel, 0.1 - 0.02), (hull, 0.1 - 0.02)):
        checker = CollisionChecker([body], World(ground=True)).slimmer(0.02)
        assert not checker.collides(pose(0.0, lowest + GAP))
        assert checker.collides(pose(0.0, lowest - GAP))


def test_the_machine_that_was_shrunk_is_as_it_was() -> None:
    whole = CollisionChecker([BodyGeometry("body", (Sphere(0.5),))], WALL)
    slim = whole.slimmer(0.1)
    assert whole.collides(pose(-0.45))
    assert not slim.collides(pose(-0.45))
    assert whole.collides(pose(-0.45))


def turned(points: np.ndarray, axis: str) -> np.ndarray:
    """Turn by 1 rad about an axis of the body's frame."""
    c, s, k = np.cos(1.0), np.sin(1.0), "xyz".index(axis)
    turn = np.eye(3)
    i, j = (k + 1) % 3, (k + 2) % 3
    turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
    return np.asarray(points @ turn.T)


@pytest.mark.parametrize(
    ("shape", "still"),
    [
        (Disk(0.3, 0.05, axis="y"), "y"),
        (Cylinder(0.3, 0.5, axis="x"), "x"),
        (Capsule(0.3, 0.5), "z"),
        (Sphere(0.3), "xyz"),
        (Box(0.3, 0.3, 0.3), ""),
    ],
)
def test_feature_points_move_where_a_shape_moves_and_nowhere_else(shape: Shape, still: str) -> None:
    """A spin about the axis of symmetry is no motion."""
    points = feature_points(shape)
    moved = {axis for axis in "xyz" if not np.allclose(turned(points, axis), points)}
    assert moved == set("xyz") - set(still)
    assert np.linalg.norm(feature_points(Sphere(0.3, at=(1.0, 0, 0)))) == 1.0
