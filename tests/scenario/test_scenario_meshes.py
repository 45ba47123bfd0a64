"""The meshes of the built-in scenarios: reproducible, closed, and of every format we read."""

from __future__ import annotations

import importlib.util
from functools import cache
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from tests.support import ROOT

Array = NDArray[np.float64]
Integers = NDArray[np.int64]

FOLDER = ROOT / "scenarios" / "meshes"
FORMATS = {".stl", ".obj", ".ply", ".glb"}
FILES = sorted(file for file in FOLDER.iterdir() if file.suffix in FORMATS)
ROOMS = {"canyon.ply", "cave.ply"}
MAX_BYTES = 12_000_000  # of all files together: people download them with every installation

on_every_file = pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)


@pytest.fixture(scope="module")
def scripts() -> ModuleType:
    """Import the script that writes all meshes."""
    spec = importlib.util.spec_from_file_location(
        "write_meshes", ROOT / "tools" / "meshes" / "write_meshes.py"
    )
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@cache  # several laws are asserted of each file
def read(file: Path) -> trimesh.Trimesh:
    """Read a mesh with trimesh, points at the same place merged, as STL files need it."""
    mesh = trimesh.load(file, force="mesh", process=False)
    mesh.merge_vertices()
    return mesh


@on_every_file
def test_the_script_writes_every_byte_of_a_mesh_again(file: Path, scripts: ModuleType) -> None:
    assert scripts.drawn(file.name)[1] == file.read_bytes()


def test_every_mesh_has_a_script(scripts: ModuleType) -> None:
    assert {file.name for file in FILES} == set(scripts.MESHES)


@on_every_file
def test_every_mesh_is_closed(file: Path) -> None:
    """Each edge is run through as often in one direction as in the other."""
    edges = read(file).edges
    there, back = (np.unique(way, axis=0, return_counts=True) for way in (edges, edges[:, ::-1]))
    np.testing.assert_array_equal(there[0], back[0])
    np.testing.assert_array_equal(there[1], back[1])


@on_every_file
def test_every_part_of_a_mesh_faces_outward(file: Path) -> None:
    """But a room faces inward: its volume, a sum of cones from the origin, is negative."""
    mesh = read(file)
    a, b, c = (mesh.triangles[:, k] for k in range(3))
    cones = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    volume = np.bincount(parts(mesh), weights=cones)
    assert ((volume < 0.0) == (file.name in ROOMS)).all()
    assert volume.all()


@on_every_file
def test_no_triangle_of_a_mesh_is_without_area(file: Path) -> None:
    """A triangle with an edge of 1 mm and a height of 0.1 mm has 5e-8 m²; files may use mm."""
    assert read(file).area_faces.min() > 5e-8


@on_every_file
def test_a_mesh_has_between_a_hundred_and_a_hundred_thousand_triangles(file: Path) -> None:
    assert 100 <= len(read(file).faces) <= 100_000


def test_all_four_formats_occur() -> None:
    assert {file.suffix for file in FILES} == FORMATS


def test_the_meshes_are_small_enough_to_ship() -> None:
    assert sum(file.stat().st_size for file in FILES) < MAX_BYTES


def test_the_parked_car_stands_on_the_ground_where_y_is_up() -> None:
    """Its sizes in [m] are those that its script promises, mirrors included."""
    low, high = read(FOLDER / "parking_cars.obj").bounds
    np.testing.assert_allclose(low, [-2.15, 0.0, -0.99], atol=1e-4)
    np.testing.assert_allclose(high, [2.15, 1.45, 0.99], atol=1e-4)


def test_the_racks_are_drawn_in_millimetres() -> None:
    low, high = read(FOLDER / "warehouse_racks.stl").bounds
    np.testing.assert_allclose(low, [2200.0, 200.0, 0.0], atol=0.01)
    np.testing.assert_allclose(high[1:], [10_000.0, 2400.0], atol=0.01)


# What the scripts promise to leave free, as two opposite corners in the file's unit.
FREE = {
    "factory's loading bay": ("factory.glb", (1, 1, 0), (5, 5, 9)),
    "factory's gap": ("factory.glb", (9.5, 9.3, 0), (13.3, 11.9, 9)),
    "factory's slot": ("factory.glb", (19.8, 9.6, 0), (22.2, 14, 9)),
    "flight over the machine": ("factory.glb", (10, 0, 4), (13, 4, 9)),
    "flight over everything": ("factory.glb", (0, 0, 7.2), (24, 14, 9)),
    "pipes' gap": ("factory_pipes.ply", (13, 8.9, 0), (16, 12.6, 9)),
    "flight over the pipes": ("factory_pipes.ply", (0, 0, 5.9), (24, 14, 9)),
    "parking lane": ("parking_kerb.stl", (-1, 5.2, 0), (24, 10.8, 3)),
    "parking bay": ("parking_kerb.stl", (12, 11, 0), (14.5, 15.2, 3)),
    "warehouse's first aisle": ("warehouse_racks.stl", (3200, 0, 0), (4400, 1e4, 3000)),
    "warehouse's last aisle": ("warehouse_racks.stl", (7600, 0, 0), (8800, 1e4, 3000)),
    "warehouse's first gap": ("warehouse_racks.stl", (2000, 3790, 0), (3300, 4990, 3000)),
    "robot's bay": ("warehouse_racks.stl", (12200, 8250, 0), (12850, 8950, 3000)),
}


@pytest.mark.parametrize("place", FREE)
def test_what_a_script_promises_to_leave_free_is_free(place: str) -> None:
    """No box around a part of the mesh reaches in by more than a micrometre."""
    name, low, high = FREE[place]
    mesh = read(FOLDER / name)
    label = parts(mesh)
    lowest, highest = np.full((label.max() + 1, 3), np.inf), np.full((label.max() + 1, 3), -np.inf)
    np.minimum.at(lowest, label, mesh.triangles.min(axis=1))
    np.maximum.at(highest, label, mesh.triangles.max(axis=1))
    inside = (lowest < np.array(high) - 1e-6).all(axis=1) & (highest > np.array(low) + 1e-6).all(1)
    assert not inside.any(), (lowest[inside], highest[inside])


STRAIGHT = {
    "canyon.ply": ((1.5, 0, 2), (30.3, 4.82, 2)),
    "cave.ply": ((2, 3, -4), (30, 14, -7)),
    "factory.glb": ((3, 3, 6.7), (21, 11, 6.7)),
    "skate_park.ply": ((2, 2, 0.1), (13.5, 9.5, 0.1)),
    "warehouse_racks.stl": ((1000, 1000, 200), (12600, 8600, 200)),
}


@pytest.mark.parametrize("name", STRAIGHT)
def test_the_straight_way_is_blocked(name: str) -> None:
    start, end = (np.array(place, dtype=float) for place in STRAIGHT[name])
    assert crossings(read(FOLDER / name), start, end) > 0


def test_a_pendulum_passes_its_bracket_on_one_side_only() -> None:
    """A bob of radius 0.1 m touches it from 100 to 130 degrees, and elsewhere has room."""
    angles = np.radians(np.arange(0.0, 360.0))
    bob = np.stack([np.cos(angles), np.sin(angles), 0.0 * angles], axis=1)
    faces = read(FOLDER / "pendulum_bracket.stl").triangles
    gap = np.array([distance(faces, place) for place in bob]) - 0.1
    assert (np.flatnonzero(gap < 0.0)[[0, -1]] == [100, 130]).all()
    assert (gap[:94] > 0.1).all()
    assert (gap[139:] > 0.1).all()


def parts(mesh: trimesh.Trimesh) -> Integers:
    """Number the connected parts of a mesh: one number per face, shape (m,)."""
    label = trimesh.graph.connected_component_labels(mesh.face_adjacency, len(mesh.faces))
    return np.asarray(label)


def distance(triangles: Array, point: Array) -> float:
    """Return how far a point is from the nearest of triangles (m, 3, 3)."""
    everywhere = np.broadcast_to(point, (len(triangles), 3))
    closest = trimesh.triangles.closest_point(triangles, everywhere)
    return float(np.linalg.norm(closest - point, axis=1).min())


def crossings(mesh: trimesh.Trimesh, start: Array, end: Array) -> int:
    """Count the faces that a straight line from ``start`` to ``end`` goes through.

    Source: Möller, Trumbore, Fast, minimum storage ray/triangle intersection, JGT 2(1), 1997.
    """
    a, b, c = (mesh.triangles[:, k] for k in range(3))
    ray = end - start
    p, offset = np.cross(ray, c - a), start - a
    q = np.cross(offset, b - a)
    scale = np.einsum("ij,ij->i", b - a, p)
    with np.errstate(divide="ignore", invalid="ignore"):  # faces along the line
        u = np.einsum("ij,ij->i", offset, p) / scale
        v, t = (q @ ray) / scale, np.einsum("ij,ij->i", c - a, q) / scale
        through = (u >= 0) & (v >= 0) & (u + v <= 1) & (t >= 0) & (t <= 1)
    return int(through.sum())


def test_check_tells_a_changed_mesh(
    scripts: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = "rolling_disk_maze.stl"
    monkeypatch.setattr(scripts, "FOLDER", tmp_path)
    monkeypatch.setattr(scripts, "MESHES", {name: scripts.MESHES[name]})
    monkeypatch.setattr("sys.argv", ["write_meshes.py"])
    assert scripts.main() == 0
    monkeypatch.setattr("sys.argv", ["write_meshes.py", "--check"])
    assert scripts.main() == 0
    (tmp_path / name).write_bytes(b"solid")
    assert scripts.main() == 1
