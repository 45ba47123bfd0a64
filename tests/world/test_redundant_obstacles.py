"""What is left out of a world makes no gap larger, wherever it is looked from."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import Capsule
from kinolab.errors import InputError
from kinolab.scenario import builtin_scenarios
from kinolab.trajopt.nlp.collision_constraints import collision_arrays
from kinolab.world import (
    Obstacle,
    box_obstacle,
    capsule_obstacle,
    cylinder_obstacle,
    sphere_obstacle,
)
from kinolab.world.distances import distance_field as module
from kinolab.world.distances.distance_field import TRANSFORM_REACH, distance_field
from kinolab.world.obstacles.redundant_obstacles import without_redundant
from tests.support import OPEN, ROOT, problem_of, within

BOX = box_obstacle("box", (2.0, 1.0, 1.0), (1.0, 2.0, 0.5), (0.0, 0.0, 0.3))


def drawn(count: int, seed: int = 1) -> list[Obstacle]:
    """Boxes, balls, cylinders and capsules of all sizes about the origin."""
    draw = np.random.default_rng(seed)
    made: list[Obstacle] = []
    for k in range(count):
        at, rpy = draw.uniform(-1, 1, 3), draw.uniform(-3, 3, 3)
        size = draw.uniform(0.05, 1.5, 3) ** 2
        shapes = (
            box_obstacle(f"{k}", tuple(size), tuple(at), tuple(rpy)),
            sphere_obstacle(f"{k}", size[0], tuple(at)),
            cylinder_obstacle(f"{k}", size[0], size[1], tuple(at), tuple(rpy)),
            capsule_obstacle(f"{k}", size[0], size[1], tuple(at), tuple(rpy)),
        )
        made.append(shapes[k % 4])
    return made


def distance(obstacle: Obstacle, points: np.ndarray) -> np.ndarray:
    """Distances (n,) of points (n, 3) to a box, a ball, a cylinder or a capsule, in closed form."""
    assert obstacle.primitive is not None
    shape, pose = obstacle.primitive
    local = (points - pose[:, 3]) @ pose[:, :3]
    if hasattr(shape, "x"):
        beyond = np.abs(local) - 0.5 * np.array([shape.x, shape.y, shape.z], dtype=float)
        return np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    if not hasattr(shape, "length"):
        return np.maximum(np.linalg.norm(local, axis=1) - float(shape.radius), 0.0)
    if isinstance(shape, Capsule):
        beyond = np.maximum(np.abs(local) - [0.0, 0.0, 0.5 * float(shape.length)], 0.0)
        return np.maximum(np.linalg.norm(beyond, axis=1) - float(shape.radius), 0.0)
    around = np.hypot(local[:, 0], local[:, 1]) - float(shape.radius)
    along = np.abs(local[:, 2]) - 0.5 * float(shape.length)
    return np.hypot(np.maximum(around, 0.0), np.maximum(along, 0.0))


def nearest(obstacles: list[Obstacle] | tuple[Obstacle, ...], points: np.ndarray) -> np.ndarray:
    return np.min([distance(obstacle, points) for obstacle in obstacles], axis=0)


@pytest.mark.parametrize("seed", range(5))
def test_every_distance_stays_as_it_is(seed: int) -> None:
    world = [*drawn(60, seed), *drawn(60, seed)]
    left = without_redundant(world)
    assert len(left) < 60  # repeats go, and some that lie inside
    points = np.random.default_rng(seed).uniform(-4, 4, (20_000, 3))
    assert np.abs(nearest(left, points) - nearest(world, points)).max() < 1e-12  # [m]


def test_two_hundred_equal_boxes_are_one() -> None:
    assert without_redundant([BOX] * 200) == (BOX,)
    again = [box_obstacle(f"{k}", (2.0, 1.0, 1.0), (1.0, 2.0, 0.5), (0.0, 0.0, 0.3)) for k in "ab"]
    assert without_redundant([BOX, *again]) == (BOX,)


@pytest.mark.parametrize("name", sorted(builtin_scenarios()))
def test_nothing_is_left_out_of_our_scenarios(name: str) -> None:
    obstacles = kinolab.load(ROOT / "scenarios" / f"{name}.toml").world.obstacles
    assert without_redundant(obstacles) == obstacles


@pytest.mark.parametrize("count", [1, 3, 40])
def test_a_grid_bounds_distances_from_below_and_not_by_much_more_than_a_cell(count: int) -> None:
    """Cells within half a diagonal of a shape are marked, and no others."""
    world = drawn(count)
    grid = distance_field(world, 0.0, memory=400_000)
    shape = grid.distance.shape[::-1]
    draw = np.random.default_rng(count)
    cells = np.column_stack([draw.integers(n, size=5000) for n in shape])
    found = grid.distance[tuple(cells.T[::-1])]
    true = nearest(world, grid.low + (cells + 0.5) * grid.width)
    marked = true <= TRANSFORM_REACH * grid.width
    sure = np.abs(true - TRANSFORM_REACH * grid.width) > 1e-6 * grid.width
    assert (found[marked & sure] == 0.0).all()
    assert (found[~marked & sure] > 0.0).all()
    assert (found <= true + 1e-6).all()
    assert (found >= true - 2.0 * TRANSFORM_REACH * grid.width - 1e-6).all()


def test_a_grid_asks_about_one_of_four_hundred_equal_boxes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Any] = []

    def counted(rows: Any, *arguments: Any) -> None:
        asked.extend(rows)
        mark(rows, *arguments)

    mark = module.mark_shapes
    monkeypatch.setattr(module, "mark_shapes", counted)
    many, one = distance_field([BOX] * 400, 0.05), distance_field([BOX], 0.05)
    assert len(asked) == 2
    assert np.array_equal(many.distance, one.distance)


def test_programs_look_at_what_is_outermost(tmp_path: Path) -> None:
    wall = "\n[[world.obstacle]]\nbox = [0.1, 4.0, 1.0]\nposition = [3.0, 0.0, 0.5]\n"
    many, one = (problem_of(tmp_path / f"{n}", OPEN + n * wall) for n in (200, 1))
    sizes = [collision_arrays(problem)[0].held.scene.obstacle.shape for problem in (many, one)]
    assert sizes[0] == sizes[1]


def test_more_obstacles_than_anybody_asks_about_are_refused_in_words(tmp_path: Path) -> None:
    balls = "{ sphere = 1.0 }, " * 100_001
    world = f'ground = "plane"\nobstacle = [{balls}]'
    with within(60), pytest.raises(InputError, match=r"Give a list of at most 100000"):
        problem_of(tmp_path, OPEN.replace('ground = "plane"', world))


@pytest.mark.parametrize("clearance", ["1e300", "1.1e6", "1e155"])
def test_a_clearance_wider_than_any_world_is_refused(clearance: str, tmp_path: Path) -> None:
    """Its square is infinite: nothing was near, and a motion beside a wall was called proved."""
    text = OPEN.replace('ground = "plane"', f'ground = "plane"\nclearance = {clearance}')
    with pytest.raises(InputError, match=r"\[world\] clearance: .* is too large. Give a distance"):
        problem_of(tmp_path, text)
