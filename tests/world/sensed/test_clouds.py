"""Clouds as obstacles: against the same balls as obstacles of their own, each judged by itself."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import kinolab
from kinolab.errors import InputError
from kinolab.loading import load
from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.distances.triangle_gaps import TOUCHING_MARGIN
from kinolab.world.sensed.cloud_file import read_cloud
from kinolab.world.sensed.point_cloud import cloud_obstacle

Points = NDArray[np.float64]
RADIUS = 0.1  # [m]
HEAD = "ply\nformat {} 1.0\nelement vertex {}\n{}end_header\n"
PCD = (
    "VERSION 0.7\nFIELDS intensity x y z\nSIZE 1 8 8 8\nTYPE U F F F\nCOUNT 2 1 1 1\n"
    "WIDTH {0}\nHEIGHT 1\nPOINTS {0}\nDATA {1}\n"
)


def some_points(count: int = 300, seed: int = 0) -> Points:
    low, high = [-3.0, -3.0, 0.05], [3.0, 3.0, 0.6]
    return np.random.default_rng(seed).uniform(low, high, (count, 3))


def ply(points: Points, order: str = "<") -> bytes:
    word = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    names = "property uchar red\n" + "".join(f"property double {axis}\n" for axis in "xyz")
    rows = np.zeros(len(points), [("red", "u1"), ("at", order + "f8", 3)])
    rows["at"] = points
    return HEAD.format(word, len(points), names).encode() + rows.tobytes()


def text(points: Points, separator: str = " ") -> str:
    return "".join(separator.join(map(repr, row)) + "\n" for row in points.tolist())


def files(points: Points) -> dict[str, bytes]:
    """The same points in every format that is read."""
    names = "".join(f"property float {axis}\n" for axis in "xyz")
    rows = np.zeros(len(points), [("light", "u1", 2), ("at", "<f8", 3)])
    rows["at"] = points
    lines = "".join(f"1 2 {line}\n" for line in text(points).splitlines())
    return {
        "little.ply": ply(points),
        "big.ply": ply(points, ">"),
        "text.ply": HEAD.format("ascii", len(points), names).encode() + text(points).encode(),
        "text.pcd": PCD.format(len(points), "ascii").encode() + lines.encode(),
        "binary.pcd": PCD.format(len(points), "binary").encode() + rows.tobytes(),
        "spaces.xyz": b"# a comment\n" + text(points).encode(),
        "commas.xyz": text(np.column_stack([points, points]), ", ").encode(),
    }


@pytest.mark.parametrize("name", files(some_points(2)))
def test_every_format_gives_the_points_that_were_written(name: str, tmp_path: Path) -> None:
    points = some_points()
    (tmp_path / name).write_bytes(files(points)[name])
    assert (read_cloud(name, root=tmp_path) == points).all()


def test_balls_are_scaled_turned_and_moved_as_meshes_are(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text("1000 2000 3000\n")
    cloud = cloud_obstacle(
        "a", "a.xyz", tmp_path, (5.0, 0.0, 0.0), (0.0, 0.0, np.pi / 2), radius=0.5, scale=1e-3
    )
    assert np.allclose(cloud.vertices, [[3.0, 1.0, 3.0]])  # turned by a quarter, then moved
    assert np.allclose(cloud.bounding_box(), [[2.5, 0.5, 2.5], [3.5, 1.5, 3.5]])
    upright = cloud_obstacle("a", "a.xyz", tmp_path, radius=0.5, scale=1e-3, up="y")
    assert np.allclose(upright.vertices, [[1.0, -3.0, 2.0]])


@pytest.mark.parametrize("voxel", [0.05, 0.3, 10.0])
def test_merged_balls_cover_the_ones_that_they_replace(voxel: float, tmp_path: Path) -> None:
    """A ball lies in another one if its centre is nearer than the radii differ."""
    points = some_points(2000)
    (tmp_path / "a.ply").write_bytes(ply(points))
    merged = cloud_obstacle("a", "a.ply", tmp_path, radius=RADIUS, voxel=voxel)
    assert len(merged.vertices) < len(points)
    away = cKDTree(merged.vertices).query(points)[0]
    assert (away <= merged.ball - RADIUS + 1e-12).all()  # [m], rounding
    assert merged.ball - RADIUS <= voxel * np.sqrt(3.0)  # the diagonal of a cube
    assert f"merged to {len(merged.vertices)} of" in str(merged)


def worlds(folder: Path, machine: str = "diff_drive") -> tuple[PlanningTask, PlanningTask]:
    """The same world as a cloud and as obstacles."""
    points = some_points()
    points = points[np.linalg.norm(points[:, :2], axis=1) > 0.8]  # there is room at the start
    (folder / "cloud.ply").write_bytes(ply(points))
    start = f'schema = 1\ntitle = "Balls"\n[system]\nname = "{machine}"\n[world]\n'
    start += 'bounds = { x = [-4, 4], y = [-4, 4] }\nground = "plane"\n'
    balls = [
        f"[[world.obstacle]]\nsphere = {RADIUS}\nposition = {row}\n" for row in points.tolist()
    ]
    given = {
        "cloud.toml": f'[[world.obstacle]]\ncloud = "cloud.ply"\nradius = {RADIUS}\n',
        "balls.toml": "".join(balls),
    }
    for name, obstacles in given.items():
        (folder / name).write_text(f"{start}{obstacles}[goal]\nx = 1.0\n")
    cloud, single = (load(folder / name) for name in given)
    return cloud, single


@pytest.mark.parametrize("machine", ["diff_drive", "rolling_disk"])
def test_a_cloud_is_met_where_its_balls_are(machine: str, tmp_path: Path) -> None:
    """FCL judges both, but of the cloud it is asked about near balls only."""
    cloud, balls = worlds(tmp_path, machine)
    one, other, thorough = cloud.checker(), balls.checker(), cloud.checker().thorough()
    random, met = np.random.default_rng(2), 0
    for x in random.uniform(*cloud.sampling_bounds.T, (400, cloud.model.nx)):
        placed = cloud.placement(x)
        hit = other.collides(*placed)
        assert one.collides(*placed) == thorough.collides(*placed) == hit
        assert one.clearance(*placed) == pytest.approx(other.clearance(*placed), abs=1e-7)  # [m]
        met += hit
    assert 50 < met < 350


def test_bounds_and_gradients_of_a_cloud_are_those_of_its_balls(tmp_path: Path) -> None:
    cloud, balls = worlds(tmp_path, "rolling_disk")
    rooms = [ClearanceBound(collision_scene(p.bodies, p.world)) for p in (cloud, balls)]
    gaps = [CollisionConstraints(p, 0.0) for p in (cloud, balls)]
    random = np.random.default_rng(3)
    for x in random.uniform(*cloud.sampling_bounds.T, (300, cloud.model.nx)):
        placed = cloud.placement(x)
        known = balls.checker().clearance(*placed)
        if known > 2.0 * TOUCHING_MARGIN:
            one, other = (room.within(*placed, 0.3) for room in rooms)
            assert one == pytest.approx(other, abs=1.1 * TOUCHING_MARGIN)
            assert rooms[0].within(*placed, 0.3, 0.02) <= known
        one, other = (each.least(x[None]) for each in gaps)
        if other > 0.0:  # overlaps are measured along the best of some directions
            assert one == pytest.approx(other, abs=1e-7)  # [m]
        else:
            assert one <= 1e-7


def test_what_the_ground_covers_of_a_cloud_is_no_obstacle(tmp_path: Path) -> None:
    (tmp_path / "a.xyz").write_text("0 0 0\n1 1 -0.01\n2 2 0.5\n")
    (tmp_path / "a.toml").write_text(
        'schema = 1\ntitle = "Floor"\n[system]\nname = "rolling_disk"\n[world]\n'
        'bounds = { x = [-4, 4], y = [-4, 4] }\nground = "plane"\n'
        '[[world.obstacle]]\ncloud = "a.xyz"\nradius = 0.1\n[goal]\nx = 1.0\n'
    )
    world = load(tmp_path / "a.toml").world
    assert [len(obstacle.vertices) for obstacle in world.obstacles] == [1]
    assert any("2 points down to 10 mm below z = 0" in note for note in world.notes)


def test_points_that_are_no_numbers_are_left_out_and_counted(tmp_path: Path) -> None:
    points = some_points(5)
    points[2, 1], points[4, 0] = np.nan, np.inf
    (tmp_path / "a.ply").write_bytes(ply(points))
    cloud = cloud_obstacle("a", "a.ply", tmp_path, radius=0.1)
    assert len(cloud.vertices) == 3
    assert "2 of 5 points are no finite numbers" in cloud.warnings[0]


BAD = {
    "nan.ply": (ply(np.full((2, 3), np.nan)), "has no point whose coordinates are finite"),
    "cut.ply": (ply(some_points(9))[:-5], "is not a readable cloud in PLY. It may be cut short"),
    "faces.ply": (
        b"ply\nformat ascii 1.0\nelement face 1\nelement vertex 1\nend_header\n",
        "does not begin with its vertices.",
    ),
    "flat.ply": (
        HEAD.format("ascii", 1, "property float x\nproperty float y\n").encode() + b"1 2\n",
        "is not a readable cloud in PLY.",
    ),
    "packed.pcd": (PCD.format(1, "binary_compressed").encode(), "pcl_convert_pcd_ascii_binary"),
    "words.xyz": (b"1 2 three\n", "is not a readable cloud in XYZ."),
    "plane.xyz": (b"1 2\n", "has 2 numbers in its first line, and a point has three."),
    "scan.las": (b"LASF", "is not a cloud format that kinolab reads. Convert it to PLY, PCD, XYZ"),
    "far.xyz": (b"1e12 0 0\n", "reaches farther than"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_is_wrong_with_a_cloud_is_said(name: str, tmp_path: Path) -> None:
    content, told = BAD[name]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=re.escape(told)):
        cloud_obstacle("a", name, tmp_path, radius=0.1)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ('cloud = "mm.xyz"\nradius = 0.1', "Write scale = 0.001 if the file is in millimetres"),
        ('cloud = "mm.xyz"\nscale = 0.001', "the points of a cloud have no radius. Write radius"),
        ("box = [1, 1, 1]\nvoxel = 1.0", "voxel is a key of clouds only."),
    ],
)
def test_what_is_wrong_in_a_scenario_is_said(given: str, told: str, tmp_path: Path) -> None:
    (tmp_path / "mm.xyz").write_text(text(1000.0 * some_points(50)))
    (tmp_path / "a.toml").write_text(
        'schema = 1\ntitle = "Units"\n[system]\nname = "rolling_disk"\n[world]\n'
        f"bounds = {{ x = [-4, 4], y = [-4, 4] }}\n[[world.obstacle]]\n{given}\n[goal]\nx = 1.0\n"
    )
    with pytest.raises(InputError, match=re.escape(told)):
        kinolab.load(tmp_path / "a.toml")


def test_a_plan_among_balls_is_verified_and_says_what_they_are(tmp_path: Path) -> None:
    cloud, _ = worlds(tmp_path, "rolling_disk")
    problem = kinolab.load(tmp_path / "cloud.toml")
    assert cloud.world.sensed == (
        f"cloud: balls of {RADIUS:g} m around {len(cloud.world.obstacles[0].vertices)} points",
    )
    plan = problem.solve(max_iterations=20_000, time_limit=20.0, improve=0)
    assert plan.certificate is not None
    assert plan.certificate.passed
    assert plan.certificate.conditions is not None
    assert plan.certificate.conditions.sensed == cloud.world.sensed
