"""Meshes of many triangles: what is near is judged as before, and the rest is not gone through."""

from __future__ import annotations

from pathlib import Path

import fcl
import numpy as np
import pytest
import trimesh

from kinolab.dynamics.language.shapes import Box, Sphere
from kinolab.world import BodyGeometry, CollisionChecker, Obstacle, World, mesh_obstacle
from kinolab.world.collision import contact_report
from kinolab.world.collision import fcl as door
from kinolab.world.obstacles.kept_together import kept_together

N = 60  # vertices along a side of the field, 1 m apart from 0
HULL = BodyGeometry("hull", (Box(0.6, 0.4, 0.2),))


@pytest.fixture(scope="module")
def field(tmp_path_factory: pytest.TempPathFactory) -> Obstacle:
    """A flat field of 6962 triangles at z = 0."""
    side = np.arange(N, dtype=float)
    x, y = np.meshgrid(side, side, indexing="ij")
    index = np.arange(N * N).reshape(N, N)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    folder = tmp_path_factory.mktemp("field")
    vertices = np.stack([x, y, np.zeros_like(x)], -1).reshape(-1, 3)
    trimesh.Trimesh(vertices, faces, process=False).export(folder / "field.ply")
    return mesh_obstacle("field", "field.ply", folder)


def at(x: float, y: float, z: float) -> np.ndarray:
    return np.column_stack([np.eye(3), [x, y, z]])[None]


@pytest.mark.parametrize("tile", [10, 500])
@pytest.mark.parametrize("thorough", [False, True])
def test_tiles_judge_as_the_plane_does(
    tile: int, thorough: bool, field: Obstacle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The hull's lower side is 0.1 m below its centre: it touches the plane from there down."""
    monkeypatch.setattr(door, "TILE_SIZE", tile)
    anew = kept_together(lambda one: door.FclTiles(one[0].vertices, one[0].faces))
    monkeypatch.setattr(door, "_tiles", anew)
    checker = CollisionChecker([HULL], World((field,)))
    checker = checker.thorough() if thorough else checker
    rng = np.random.default_rng(0)
    for gap in (-0.05, -1e-4, 1e-4, 5e-3, 0.3):
        for x, y in rng.uniform(0.5, N - 1.5, (10, 2)):
            pose = at(x, y, 0.1 + gap)
            assert checker.collides(pose) is (gap < 0)
            names = [(c.body, c.obstacle, c.kind) for c in checker.contacts(pose)]
            assert names == ([("hull", "field", "touches")] if gap < 0 else [])
            assert checker.clearance(pose) == pytest.approx(max(gap, 0.0), abs=1e-7)
    assert not checker.collides(at(N + 5.0, 3.0, 0.0))  # beside the field


def test_fcl_is_not_asked_where_a_gap_is_proved(
    field: Obstacle, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its search tree of a large mesh would take longer than most searches."""
    asked = 0

    def counted(*arguments: object) -> object:
        nonlocal asked
        asked += 1
        return collide(*arguments)

    collide = fcl.collide
    monkeypatch.setattr(fcl, "collide", counted)
    monkeypatch.setattr(contact_report, "LARGE", 100)
    monkeypatch.setattr(door, "TILE_SIZE", 100)
    checker = CollisionChecker([HULL], World((field,)))
    near = at(20.3, 31.2, 0.105)  # 5 mm above the field, whose boxes it is within when inflated
    assert not checker.inflated(1e-3, ground=False).collides(near)
    assert checker.contacts(at(20.3, 31.2, 0.102)) == []
    assert asked == 0
    assert checker.inflated(4e-3, ground=False).thorough().clearance(near) == pytest.approx(1e-3)
    assert asked == 0  # not even its box is near
    assert checker.collides(at(20.3, 31.2, 0.0999))
    assert asked > 0


def test_a_large_mesh_still_has_an_inside(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(door, "TILE_SIZE", 100)
    trimesh.creation.icosphere(subdivisions=4, radius=2.0).export(tmp_path / "ball.ply")
    world = World((mesh_obstacle("ball", "ball.ply", tmp_path),))
    checker = CollisionChecker([BodyGeometry("bead", (Sphere(0.1),))], world)
    for distance, free in ((0.0, False), (1.8, False), (2.05, False), (2.2, True)):
        assert checker.collides(at(distance, 0.0, 0.0)) is not free
        assert checker.thorough().collides(at(distance, 0.0, 0.0)) is not free
