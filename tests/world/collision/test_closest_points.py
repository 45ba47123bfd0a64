"""Gaps to obstacles against closed forms, for every pair that the planners meet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from kinolab.dynamics.language.shapes import Box, Capsule, Cylinder, Shape, Sphere
from kinolab.world import (
    BodyGeometry,
    Obstacle,
    World,
    box_obstacle,
    cylinder_obstacle,
    mesh_obstacle,
    sphere_obstacle,
)
from kinolab.world.collision.closest_points import Gap, GapFinder

Array = NDArray[np.float64]

CLOSE = 1e-5  # [m]; FCL's own tolerance between convex shapes is 1e-6
SHAPES: dict[str, Shape] = {
    "ball": Sphere(0.2),
    "box": Box(0.4, 0.4, 0.4),
    "capsule": Capsule(0.2, 0.6, axis="y"),
    "cylinder": Cylinder(0.2, 0.6, axis="y"),
}


def pose(*at: float, turn: Array | None = None) -> Array:
    return np.column_stack([np.eye(3) if turn is None else turn, at]).reshape(1, 12)


def turn_z(angle: float) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def gaps(shape: Shape, world: World, where: Array, reach: float = 10.0) -> list[Gap]:
    return GapFinder([BodyGeometry("body", (shape,))], world, reach).gaps(where)


@pytest.fixture(scope="module")
def cube(tmp_path_factory: pytest.TempPathFactory) -> Obstacle:
    """A cube of 2 m around the origin as a mesh of triangles."""
    folder: Path = tmp_path_factory.mktemp("cube")
    trimesh.creation.box([2.0, 2.0, 2.0]).export(folder / "cube.stl")
    return mesh_obstacle("cube", "cube.stl", folder)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_beside_a_wall_the_gap_is_the_distance_of_its_face(
    name: str, kind: str, cube: Obstacle
) -> None:
    """All shapes reach 0.2 m along x."""
    wall = box_obstacle("wall", (2.0, 2.0, 2.0)) if kind == "box" else cube
    (gap,) = gaps(SHAPES[name], World((wall,)), pose(1.5, 0.0, 0.1))
    assert gap.distance == pytest.approx(0.3, abs=CLOSE)
    assert gap.on_body[0] == pytest.approx(1.3, abs=CLOSE)
    assert gap.on_obstacle[0] == pytest.approx(1.0, abs=CLOSE)


@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_beyond_a_corner_a_ball_is_nearest_to_the_corner(kind: str, cube: Obstacle) -> None:
    wall = box_obstacle("wall", (2.0, 2.0, 2.0)) if kind == "box" else cube
    centre = np.array([1.3, 1.4, 2.2])
    away = centre - 1.0
    (gap,) = gaps(SHAPES["ball"], World((wall,)), pose(*centre))
    length = float(np.linalg.norm(away))  # 1.3 m
    assert gap.distance == pytest.approx(length - 0.2, abs=CLOSE)
    assert gap.on_obstacle == pytest.approx(np.ones(3), abs=CLOSE)
    assert gap.on_body == pytest.approx(centre - 0.2 * away / length, abs=CLOSE)


def test_two_balls_are_nearest_on_the_line_between_them() -> None:
    (gap,) = gaps(
        SHAPES["ball"], World((sphere_obstacle("ball", 0.5, (3.0, 4.0, 0.0)),)), pose(0, 0, 0)
    )
    assert gap.distance == pytest.approx(4.3, abs=CLOSE)
    assert gap.on_body == pytest.approx([0.12, 0.16, 0.0], abs=CLOSE)
    assert gap.on_obstacle == pytest.approx([2.7, 3.6, 0.0], abs=CLOSE)


def test_a_turned_capsule_is_nearest_with_its_end() -> None:
    """Its axis along y is turned to point along -x: the cap reaches 0.5 m ahead."""
    post = cylinder_obstacle("post", 0.1, 4.0, (-2.0, 0.0, 0.0))
    (gap,) = gaps(SHAPES["capsule"], World((post,)), pose(0.0, 0.0, 0.3, turn=turn_z(np.pi / 2)))
    assert gap.distance == pytest.approx(1.4, abs=CLOSE)
    assert gap.on_body == pytest.approx([-0.5, 0.0, 0.3], abs=1e-3)


@pytest.mark.parametrize("name", SHAPES)
def test_above_the_ground_the_gap_is_the_height(name: str) -> None:
    (gap,) = gaps(SHAPES[name], World(ground=True), pose(1.0, 2.0, 0.7))
    assert gap.distance == pytest.approx(0.5, abs=1e-12)
    assert gap.on_body[2] == pytest.approx(0.5, abs=1e-12)
    assert gap.on_obstacle == pytest.approx([*gap.on_body[:2], 0.0], abs=1e-12)


def test_the_ground_pushes_nothing_that_may_touch_it() -> None:
    wheel = BodyGeometry("wheel", (Sphere(0.2),), touches_ground=True)
    assert GapFinder([wheel], World(ground=True), 1.0).gaps(pose(0, 0, 0.2)) == []


def test_what_is_beyond_the_reach_is_not_listed() -> None:
    world = World((box_obstacle("wall", (2.0, 2.0, 2.0)),))
    assert gaps(SHAPES["ball"], world, pose(1.5, 0, 0), reach=0.29) == []
    assert len(gaps(SHAPES["ball"], world, pose(1.5, 0, 0), reach=0.31)) == 1


def test_the_body_of_a_gap_is_named_and_moves_with_it() -> None:
    bodies = [BodyGeometry("far", (Sphere(0.1),)), BodyGeometry("near", (Sphere(0.1),))]
    world = World((box_obstacle("wall", (2.0, 2.0, 2.0)),))
    poses = np.vstack([pose(5, 0, 0), pose(1.2, 0, 0)])
    (gap,) = GapFinder(bodies, world, 0.5).gaps(poses)
    assert (gap.body, gap.distance) == (1, pytest.approx(0.1, abs=CLOSE))


@pytest.mark.parametrize("name", SHAPES)
def test_what_overlaps_has_no_gap_and_is_not_measured(name: str, cube: Obstacle) -> None:
    for wall in (box_obstacle("wall", (2.0, 2.0, 2.0)), cube):
        (gap,) = gaps(SHAPES[name], World((wall,)), pose(1.1, 0.0, 0.0))
        assert gap.distance == 0.0


@pytest.mark.parametrize("name", SHAPES)
def test_the_points_are_as_far_apart_as_the_gap_in_any_pose(name: str, cube: Obstacle) -> None:
    generator = np.random.default_rng(0)
    world = World((cube, box_obstacle("wall", (1.0, 2.0, 0.5), (0.0, 3.0, 0.0), (0.3, 0.2, 0.1))))
    finder = GapFinder([BodyGeometry("body", (SHAPES[name],))], world, 10.0)
    for _ in range(50):
        turn = np.linalg.qr(generator.normal(size=(3, 3)))[0]
        turn *= np.sign(np.linalg.det(turn))
        for gap in finder.gaps(pose(*generator.uniform(-4, 4, 3), turn=turn)):
            apart = float(np.linalg.norm(gap.on_body - gap.on_obstacle))
            assert gap.distance == 0.0 or apart == pytest.approx(gap.distance, abs=1e-9)
