"""Solids around parts of a mesh contain all of it, and less besides than one around the whole."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

import kinolab
from kinolab.dynamics.language.shapes import Box, Capsule
from kinolab.errors import InputError
from kinolab.numerics.arrays import Array
from kinolab.robots import read_mjcf, read_urdf
from kinolab.robots.solids.convex_parts import enclosing_shapes
from kinolab.robots.tree.kinematic_tree import PlacedShape
from tests.support import needs

ROBOTS = Path(sys.prefix).glob("lib/python*/site-packages/cmeel.prefix/share/example-robot-data")
FOLDER = next(ROBOTS, Path("not installed")) / "robots"
MESHES = {  # links of robots that others described, with what a union may be of one solid
    "panda_description/meshes/collision/link0.stl": 0.8,
    "panda_description/meshes/collision/link5.stl": 0.8,
    "tiago_pro_description/meshes/omni_base/wheels/suspension_rear_link.stl": 0.4,
}


def outside(solids: list[PlacedShape], points: Array) -> Array:
    """Return by how much points (n, 3) are outside of all solids; negative inside of one."""
    found = np.full(len(points), np.inf)
    for solid in solids:
        own = (points - solid.pose[:3, 3]) @ solid.pose[:3, :3]
        shape = solid.shape
        if isinstance(shape, Box):
            half = 0.5 * np.array([shape.x, shape.y, shape.z], dtype=float)
            far = (np.abs(own) - half).max(axis=1)
        else:
            assert isinstance(shape, Capsule)
            half_length = 0.5 * float(shape.length)
            own[:, 2] -= np.clip(own[:, 2], -half_length, half_length)
            far = np.linalg.norm(own, axis=1) - float(shape.radius)
        found = np.minimum(found, far)
    return found


def union_volume(solids: list[PlacedShape]) -> float:
    """Return the volume in [m^3] that solids take together, to about a percent."""
    corners = np.vstack([s.enclosed @ s.pose[:3, :3].T + s.pose[:3, 3] for s in solids])  # type: ignore[operator]
    size = np.ptp(corners, axis=0)
    low, high = corners.min(axis=0) - size, corners.max(axis=0) + size
    points = np.random.default_rng(0).uniform(low, high, (400_000, 3))
    return float((outside(solids, points) <= 0.0).mean() * (high - low).prod())


@pytest.mark.skipif(not FOLDER.is_dir(), reason="needs example-robot-data")
@pytest.mark.parametrize("name", MESHES)
def test_links_of_public_robots_fit_closer(name: str) -> None:
    mesh = trimesh.load_mesh(FOLDER / name)
    points = np.asarray(mesh.vertices, dtype=float)
    (one,) = enclosing_shapes(points, mesh.faces, None, name)
    several = enclosing_shapes(points, mesh.faces, 6, name)
    assert 1 < len(several) <= 6
    on_it = trimesh.sample.sample_surface(mesh, 20_000, seed=1)[0]
    assert outside(several, np.vstack([points, on_it])).max() < 1e-9  # [m]
    assert union_volume(several) < MESHES[name] * union_volume([one])


def corner() -> trimesh.Trimesh:
    """Return an L of two bricks, 1 m x 1 m with legs of 0.2 m x 0.2 m."""
    outline = [(0, 0), (1, 0), (1, 0.2), (0.2, 0.2), (0.2, 1), (0, 1)]
    vertices = np.array([(x, y, z) for z in (0.0, 0.2) for x, y in outline])
    cap = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]
    faces = [(a, c, b) for a, b, c in cap] + [(a + 6, b + 6, c + 6) for a, b, c in cap]
    for k in range(6):
        n = (k + 1) % 6
        faces += [(k, n, n + 6), (k, n + 6, k + 6)]
    return trimesh.Trimesh(vertices, faces, process=False)


@needs("coacd")
def test_a_corner_becomes_two_bricks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One box around it has 0.2 m^3, it itself has 0.072 m^3; the second time is from disk."""
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path))
    mesh = corner()
    assert mesh.is_volume
    found = [enclosing_shapes(mesh.vertices, mesh.faces, 2, "corner") for _ in range(2)]
    assert len(found[0]) == 2
    assert union_volume(found[0]) < 0.08
    for first, again in zip(*found, strict=True):
        assert first.shape == again.shape
        assert np.array_equal(first.pose, again.pose)


def written(tmp_path: Path) -> Path:
    """Return a file of a robot whose only link is a corner."""
    corner().export(tmp_path / "corner.stl")
    file = tmp_path / "robot.urdf"
    file.write_text(
        '<robot name="robot"><link name="base"/><link name="corner"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
        '<collision><geometry><mesh filename="corner.stl"/></geometry></collision></link>'
        '<joint name="turn" type="continuous"><parent link="base"/><child link="corner"/>'
        '<axis xyz="0 0 1"/><limit effort="5" velocity="1"/></joint></robot>'
    )
    return file


@needs("coacd", "yourdfpy", "mujoco")
def test_files_of_both_kinds_and_scenarios_take_the_number(tmp_path: Path) -> None:
    file = written(tmp_path)
    model = tmp_path / "model.xml"
    model.write_text(
        '<mujoco><asset><mesh name="corner" file="corner.stl"/></asset><worldbody><body>'
        '<joint name="turn"/><geom type="mesh" mesh="corner"/></body></worldbody></mujoco>'
    )
    for system in (read_urdf(file, convex_parts=2), read_mjcf(model, convex_parts=2)):
        assert sum(len(body.shapes) for body in system.bodies) == 2
    text = '[system]\nfile = "robot.urdf"\nconvex_parts = 2\n[goal]\nturn = 1.0\n'
    (tmp_path / "turn.toml").write_text('schema = 1\ntitle = "A corner turns"\n' + text)
    checker = kinolab.load(tmp_path / "turn.toml").checker()
    assert sum(len(body.shapes) for body in checker.bodies) == 2


@pytest.mark.parametrize("count", [0, 33, 2.5, True])
def test_other_numbers_are_refused(count: int, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"convex_parts.*Give a whole number from 1 to 32"):
        read_urdf(written(tmp_path), convex_parts=count)


def test_without_the_library_it_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "coacd", None)
    with pytest.raises(InputError, match=r"pip install 'kinolab\[convex\]'"):
        read_urdf(written(tmp_path), convex_parts=2)
