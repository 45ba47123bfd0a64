"""Robots are drawn by their visual meshes, which touch nothing, in every picture of a run."""

from __future__ import annotations

import base64
import logging
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

import kinolab
from kinolab.dynamics.language.shapes.drawn_mesh import DrawnMesh
from kinolab.errors import InputError
from kinolab.robots import read_mjcf, read_urdf
from kinolab.show.scene.picture import Picture
from tests.support import needs

ROBOTS = Path(sys.prefix).glob("lib/python*/site-packages/cmeel.prefix/share/example-robot-data")
PANDA = next(ROBOTS, Path("not installed")) / "robots" / "panda_description"


@pytest.mark.skipif(not PANDA.is_dir(), reason="needs example-robot-data")
def test_a_panda_looks_like_its_meshes() -> None:
    """With a fifth of the triangles, no corner is farther than 2 mm from trimesh's own reading."""
    pytest.importorskip("collada")
    system = read_urdf(PANDA / "urdf" / "panda.urdf", self_collisions=False)
    drawn = {body.name: body.drawn for body in system.bodies if body.drawn}
    assert len(drawn) == 11
    count = sum(len(mesh.faces) for some in drawn.values() for mesh in some)
    assert 27_000 < count < 30_300
    for name in ("link2", "link6", "hand"):
        whole = trimesh.load(PANDA / "meshes" / "visual" / f"{name}.dae", force="mesh")
        points = np.concatenate([mesh.vertices for mesh in drawn[f"panda_{name}"]])
        assert np.abs(points.min(axis=0) - whole.bounds[0]).max() < 2e-3  # [m]
        assert np.abs(points.max(axis=0) - whole.bounds[1]).max() < 2e-3
        some = np.random.default_rng(0).choice(len(points), 300, replace=False)
        assert trimesh.proximity.closest_point(whole, points[some])[1].max() < 2e-3
    brightness = [np.mean(mesh.color) for mesh in drawn["panda_link6"]]
    assert min(brightness) < 0.4  # dark covers
    assert max(brightness) > 0.9  # and white ones


BALL = """<robot name="ball">
  <material name="green"><color rgba="0.1 0.7 0.2 1"/></material>
  <link name="base"/>
  <link name="ball"><inertial><mass value="1"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><origin xyz="0 0 1"/><geometry><mesh filename="ball.stl"/></geometry>
      <material name="green"><color rgba="0.1 0.7 0.2 1"/></material></visual>
    <collision><origin xyz="0 0 1" rpy="0.3 0 0"/><geometry><box size="0.2 0.2 0.2"/></geometry>
    </collision></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="ball"/>
    <axis xyz="1 0 0"/><limit lower="-9" upper="9" effort="20" velocity="9"/></joint>
</robot>"""

ROLL = """schema = 1
title = "A ball slides past a wall"
[system]
file = "ball.urdf"
[[world.obstacle]]
box = [0.1, 0.1, 3.0]
position = [0.3, 0.5, 1.5]
[goal]
slide = 0.6
at_rest = true
"""


def ball_in(folder: Path) -> Path:
    """Write a robot that is drawn larger than it collides; return its file."""
    trimesh.creation.icosphere(2, 1.0).export(folder / "ball.stl")
    (folder / "ball.urdf").write_text(BALL)
    (folder / "roll.toml").write_text(ROLL)
    return folder / "ball.urdf"


@needs("yourdfpy", "mujoco")
def test_what_is_drawn_touches_nothing_and_stays_with_the_run(tmp_path: Path) -> None:
    """A ball of 1 m is drawn and goes through a wall; the box inside it does not touch it."""
    home, run = tmp_path / "home", tmp_path / "run"
    home.mkdir()
    ball_in(home)
    problem = kinolab.load(home / "roll.toml")
    plan = problem.solve(seed=1, time_limit=30.0, improve=0.0)
    assert plan.status == "solved"
    plan.save(run)
    shutil.rmtree(home)
    again = kinolab.read_run(run).problem
    seen = Picture(bodies=again.bodies).machine()
    names = [body.name for body in again.bodies]
    ball, box = seen[names.index("ball")], seen[names.index("ball 2")]
    assert len(ball.faces) == 320
    assert not len(box.faces)  # it collides, and is not drawn
    assert np.abs(np.linalg.norm(ball.vertices - [0, 0, 1], axis=1) - 1.0).max() < 1e-6
    assert np.allclose(ball.colors, [0.1, 0.7, 0.2], atol=1e-3)
    kinolab.save_glb(again, kinolab.read_run(run), tmp_path / "ball.glb")
    scene = trimesh.load(tmp_path / "ball.glb")
    assert any(len(mesh.faces) == 320 for mesh in scene.geometry.values())


@needs("yourdfpy", "mujoco")
def test_meshes_that_are_missing_are_not_drawn(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    file = ball_in(tmp_path)
    (tmp_path / "ball.stl").unlink()
    with caplog.at_level(logging.WARNING, "kinolab"):
        bodies = {body.name: body for body in read_urdf(file).bodies}
    assert "link 'ball': its mesh is not drawn: ball.stl: it cannot be found." in caplog.text
    assert bodies["ball 2"].drawn is None


@needs("yourdfpy", "mujoco")
def test_a_model_s_meshes_are_drawn_in_their_materials(tmp_path: Path) -> None:
    trimesh.creation.icosphere(1, 0.5).export(tmp_path / "ball.stl")
    (tmp_path / "model.xml").write_text(
        '<mujoco><asset><mesh name="ball" file="ball.stl"/><material name="red" rgba="1 0 0 1"/>'
        '</asset><worldbody><body name="ball"><joint name="turn" pos="0 0 2"/>'
        '<geom type="mesh" mesh="ball" material="red" pos="0 0 1" contype="0" conaffinity="0"/>'
        '<geom size="0.1"/></body></worldbody></mujoco>'
    )
    (ball,) = (body for body in read_mjcf(tmp_path / "model.xml").bodies if body.name == "ball")
    assert ball.drawn is not None
    (mesh,) = ball.drawn
    assert mesh.color == (1.0, 0.0, 0.0)
    assert np.abs(np.linalg.norm(mesh.vertices - [0, 0, 1], axis=1) - 0.5).max() < 1e-6
    assert len(ball.shapes) == 1


def packed(numbers: object, kind: str) -> str:
    """Return numbers as a mesh that is drawn has them."""
    return base64.b64encode(np.asarray(numbers, kind).tobytes()).decode()


TRIANGLE = packed([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4")


@pytest.mark.parametrize(
    ("points", "corners", "said"),
    [
        (TRIANGLE, packed([0, 1, 3], "<u2"), "do not fit each other"),
        (TRIANGLE, packed([0, 1], "<u2"), "do not fit each other"),
        ("no base64!", packed([0, 1, 2], "<u2"), "do not fit each other"),
        (packed([[np.nan] * 3] * 3, "<f4"), packed([0, 1, 2], "<u2"), "do not fit each other"),
        (TRIANGLE, packed([[0, 1, 2]] * 50_001, "<u2"), "more than 50000 triangles"),
    ],
)
def test_what_is_no_mesh_is_refused(points: str, corners: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        DrawnMesh(points, corners, (1.0, 1.0, 1.0))
