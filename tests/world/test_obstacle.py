from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kinolab.errors import InputError
from kinolab.loading import load
from kinolab.search import Outcome, SearchResult
from kinolab.world import (
    Obstacle,
    World,
    box_obstacle,
    capsule_obstacle,
    cylinder_obstacle,
    mesh_obstacle,
    sphere_obstacle,
)
from kinolab.world.obstacles.obstacle import rotation

PI = np.pi


def volume(obstacle: Obstacle) -> float:
    return float(trimesh.Trimesh(obstacle.vertices, obstacle.faces, process=False).volume)


def corner_mesh(folder: Path) -> str:
    """A triangle with one corner on each axis: x at 1, y at 2, z at 3."""
    (folder / "corner.obj").write_text("v 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 2 3\n")
    return "corner.obj"


def rows(obstacle: Obstacle) -> set[tuple[float, ...]]:
    return {tuple(np.round(vertex, 12) + 0.0) for vertex in obstacle.vertices.tolist()}


def test_rpy_turns_about_x_then_y_then_z_of_the_world() -> None:
    np.testing.assert_allclose(rotation((PI / 2, 0, 0)) @ [0, 1, 0], [0, 0, 1], atol=1e-15)
    np.testing.assert_allclose(rotation((0, PI / 2, 0)) @ [1, 0, 0], [0, 0, -1], atol=1e-15)
    np.testing.assert_allclose(rotation((0, 0, PI / 2)) @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    matrix = trimesh.transformations.euler_matrix(0.3, -0.7, 1.9, axes="sxyz")[:3, :3]
    np.testing.assert_allclose(rotation((0.3, -0.7, 1.9)), matrix, atol=1e-15)


@pytest.mark.parametrize(
    ("up", "expected"),
    [
        ("z", {(1, 0, 0), (0, 2, 0), (0, 0, 3)}),
        ("y", {(1, 0, 0), (0, 0, 2), (0, -3, 0)}),
        ("x", {(0, 0, 1), (2, 0, 0), (0, 3, 0)}),
    ],
)
def test_up_turns_the_named_axis_to_plus_z(
    up: str, expected: set[tuple[float, ...]], tmp_path: Path
) -> None:
    obstacle = mesh_obstacle("m", corner_mesh(tmp_path), tmp_path, up=up)  # type: ignore[arg-type]
    assert rows(obstacle) == expected


def test_scale_comes_first_then_up_then_rpy_then_position(tmp_path: Path) -> None:
    """The corner z = 3 doubles, goes to -y, turns by 90 degrees about z to +x, and is moved."""
    obstacle = mesh_obstacle(
        "m",
        corner_mesh(tmp_path),
        tmp_path,
        position=(10, 20, 30),
        rpy=(0, 0, PI / 2),
        scale=(1, 1, 2),
        up="y",
    )
    assert (16.0, 20.0, 30.0) in rows(obstacle)


def test_primitives_are_where_they_are_said_to_be() -> None:
    box = box_obstacle("b", (1, 2, 4), position=(1, 1, 1), rpy=(0, 0, PI / 2))
    np.testing.assert_allclose(box.vertices.min(axis=0), [0, 0.5, -1], atol=1e-12)
    assert volume(box) == pytest.approx(8)
    tube = cylinder_obstacle("c", 0.5, 2.0, rpy=(0, PI / 2, 0))
    np.testing.assert_allclose(np.ptp(tube.vertices, axis=0), [2, 1, 1], atol=1e-2)
    pill = capsule_obstacle("p", 0.5, 2.0, rpy=(0, PI / 2, 0))
    np.testing.assert_allclose(np.ptp(pill.vertices, axis=0), [3, 1, 1], atol=2e-2)
    assert pill.bounding_box()[1] == pytest.approx([1.5, 0.5, 0.5])
    ball = sphere_obstacle("s", 1.0, position=(0, 0, 5))
    np.testing.assert_allclose(np.linalg.norm(ball.vertices - [0, 0, 5], axis=1), 1.0)


@pytest.mark.parametrize(("solid", "expected"), [(None, False), (True, True), (False, False)])
def test_an_inward_shell_is_a_room_unless_it_is_called_solid(
    solid: bool | None, expected: bool, tmp_path: Path
) -> None:
    shell = trimesh.creation.box((2, 2, 2))
    shell.invert()
    shell.export(tmp_path / "room.stl")
    obstacle = mesh_obstacle("room", "room.stl", tmp_path, solid=solid)
    assert obstacle.solid is expected
    assert volume(obstacle) == pytest.approx(8 if expected else -8)  # solids look outward


def test_a_mirrored_solid_stays_a_solid(tmp_path: Path) -> None:
    trimesh.creation.box((2, 2, 2)).export(tmp_path / "box.stl")
    obstacle = mesh_obstacle("box", "box.stl", tmp_path, scale=(-1, 1, 1))
    assert obstacle.solid
    assert volume(obstacle) == pytest.approx(8)


def test_an_open_mesh_cannot_be_solid(tmp_path: Path) -> None:
    path = corner_mesh(tmp_path)
    assert not mesh_obstacle("m", path, tmp_path).solid
    with pytest.raises(InputError, match="not watertight, so it cannot be solid"):
        mesh_obstacle("m", path, tmp_path, solid=True)


def test_faces_that_disagree_about_outside_do_not_make_a_solid(tmp_path: Path) -> None:
    box = trimesh.creation.box((1, 1, 1))
    box.faces[0] = box.faces[0][::-1]
    (tmp_path / "box.ply").write_bytes(trimesh.exchange.ply.export_ply(box))
    assert not mesh_obstacle("box", "box.ply", tmp_path).solid


def test_each_part_of_a_mesh_is_judged_alone(tmp_path: Path) -> None:
    half_open = trimesh.creation.box((1, 1, 1))
    half_open.update_faces(np.arange(12) > 0)
    both = trimesh.util.concatenate(
        [half_open, trimesh.creation.box((1, 1, 1)).apply_translation((5, 0, 0))]
    )
    both.export(tmp_path / "both.ply")
    obstacle = mesh_obstacle("both", "both.ply", tmp_path)
    assert obstacle.solid
    assert len(obstacle.warnings) == 1


@pytest.mark.parametrize("scale", [0.0, (1, 0, 1), float("nan"), (1, float("inf"), 1)])
def test_a_scale_that_loses_the_mesh_is_a_mistake(scale: float, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="scale must be finite and not 0"):
        mesh_obstacle("m", corner_mesh(tmp_path), tmp_path, scale=scale)


def test_sizes_must_be_positive() -> None:
    with pytest.raises(InputError, match="b: edges must be positive"):
        box_obstacle("b", (1, 0, 1))
    with pytest.raises(InputError, match="radius must be positive"):
        sphere_obstacle("s", float("nan"))
    with pytest.raises(InputError, match="radius and length must be positive"):
        cylinder_obstacle("c", 1, -1)


@pytest.mark.parametrize("far", [1e10, 1e300])
def test_nothing_is_farther_away_than_rounding_allows(far: float) -> None:
    message = re.escape(f"is {far:g} m. Stay within 1e+09 m.")
    for make in (
        lambda: box_obstacle("wall", (0.1, far, 1.8)),
        lambda: sphere_obstacle("planet", 1.0, (-far, 0, 0)),
        lambda: cylinder_obstacle("mast", 1.0, far),
    ):
        with pytest.raises(InputError, match=message):
            make()


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_places_must_be_finite(bad: float, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="b: position and rpy must be finite"):
        box_obstacle("b", (1, 1, 1), position=(0, bad, 0))
    with pytest.raises(InputError, match="m: position and rpy must be finite"):
        mesh_obstacle("m", corner_mesh(tmp_path), tmp_path, rpy=(0, 0, bad))
    with pytest.raises(InputError, match="farther than"):
        mesh_obstacle("m", corner_mesh(tmp_path), tmp_path, scale=1e300)


def test_millimetres_that_are_scaled_are_not_warned_about(tmp_path: Path) -> None:
    trimesh.creation.box((4000, 4000, 4000)).export(tmp_path / "box.stl")
    assert mesh_obstacle("b", "box.stl", tmp_path, scale=0.001).warnings == ()
    (warning,) = mesh_obstacle("b", "box.stl", tmp_path).warnings
    assert "Millimetres?" in warning


def test_a_world_tells_what_it_holds(tmp_path: Path) -> None:
    mesh = mesh_obstacle("wedge", corner_mesh(tmp_path), tmp_path)
    world = World((sphere_obstacle("ball", 1.0), mesh), True, {"x": (0.0, 4000.0)})
    assert world.describe() == (
        "ball: sphere",
        "wedge: mesh of 1 triangles from corner.obj, surface only",
        "ground: the plane z = 0",
    )
    assert len(world.warnings) == 2  # open mesh, 4000 m wide


def test_what_holds_arrays_is_shown_in_one_line() -> None:
    """An obstacle by name, kind and place; its world, its problem, and what a search returns."""
    crate = box_obstacle("crate", (1.0, 2.0, 0.5), (0.0, 0.0, 0.25))
    assert repr(crate) == "<Obstacle crate: box, from (-0.5, -1, 0) to (0.5, 1, 0.5) m>"
    task = load("rolling_disk_maze")
    found = SearchResult(Outcome.SOLVED, np.zeros(2), np.zeros((1, 2)), 7)
    assert repr(found) == "<SearchResult SOLVED: 1 step, 7 iterations>"
    assert repr(task) == "<PlanningTask rolling_disk_maze: rolling_disk, 4 obstacles>"
    for thing in (*task.world.obstacles, task.world):
        assert "\n" not in repr(thing)
        assert "array" not in repr(thing)
