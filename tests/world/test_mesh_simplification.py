"""Simplified meshes: how far the old triangles are from the new ones is proved, and kept."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

from kinolab.errors import InputError
from kinolab.world import mesh_obstacle
from kinolab.world.mesh_simplification import largest_distance, simplified
from tests.support import OPEN, needs, problem_of

WAVES = '[[world.obstacle]]\nmesh = "waves.ply"\nposition = [3.0, 3.0, 0.0]\nsimplify = 400\n'


def waves(folder: Path) -> None:
    """A surface of 7200 triangles that lies in waves of 0.1 m, from 0.5 m up."""
    side = np.linspace(0.0, 2.0, 61)
    x, y = np.meshgrid(side, side, indexing="ij")
    z = 0.6 + 0.1 * np.sin(4.0 * x) * np.cos(3.0 * y)
    index = np.arange(61 * 61).reshape(61, 61)
    a, b, c, d = index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    vertices = np.stack([x, y, z], -1).reshape(-1, 3)
    trimesh.Trimesh(vertices, faces, process=False).export(folder / "waves.ply")


@needs("fast_simplification")
def test_no_point_is_farther_than_the_bound(tmp_path: Path) -> None:
    """Distances by trimesh, of points all over the old triangles; the bound is not far above."""
    waves(tmp_path)
    whole = mesh_obstacle("waves", "waves.ply", tmp_path)
    few = simplified(whole, 400)
    assert 300 <= len(few.faces) <= 400
    old = trimesh.Trimesh(whole.vertices, whole.faces, process=False)
    new = trimesh.Trimesh(few.vertices, few.faces, process=False)
    points = np.concatenate([old.sample(2000, seed=0), whole.vertices[::7]])
    nearest = trimesh.proximity.closest_point_naive(new, points)[1].max()
    assert nearest <= few.error <= 2.0 * nearest
    assert few.warnings[-1].startswith("waves.ply: simplified from 7200 to ")


def test_a_shifted_plane_is_as_far_as_it_was_shifted(tmp_path: Path) -> None:
    square = trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]])
    square.export(tmp_path / "square.ply")
    surface = mesh_obstacle("square", "square.ply", tmp_path)
    bound = largest_distance(square.vertices + np.array([0, 0, 0.2]), square.faces, surface)
    assert 0.2 <= bound <= 0.24


@needs("fast_simplification")
def test_what_is_closed_stays_closed(tmp_path: Path) -> None:
    trimesh.creation.icosphere(subdivisions=4).export(tmp_path / "ball.ply")
    few = simplified(mesh_obstacle("ball", "ball.ply", tmp_path), 300)
    assert few.solid
    assert few.parts is not None
    assert few.parts.volume == pytest.approx([4 / 3 * np.pi], rel=0.05)
    with pytest.raises(InputError, match=r"does not stay closed|nothing left"):
        simplified(mesh_obstacle("ball", "ball.ply", tmp_path), 1)


@needs("fast_simplification")
def test_plans_keep_the_error_besides_their_clearance(tmp_path: Path) -> None:
    waves(tmp_path)
    problem = problem_of(tmp_path, OPEN.replace("[start]", f"clearance = 0.05\n{WAVES}[start]"))
    (few,) = problem.world.obstacles
    assert few.error > 0.0
    assert problem.world.clearance == pytest.approx(0.05 + few.error)


def test_without_its_library_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    waves(tmp_path)
    monkeypatch.setitem(sys.modules, "fast_simplification", None)
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    with pytest.raises(InputError, match=r"pip install 'kinolab\[simplify\]'"):
        simplified(mesh_obstacle("waves", "waves.ply", tmp_path), 400)
