"""Robots whose files say nothing of masses: moved by speeds, or filled with a density."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import kinolab
from kinolab.errors import InputError
from kinolab.robots import read_mjcf, read_urdf

mujoco: Any = pytest.importorskip("mujoco")

ROBOTS = Path(sys.prefix).glob("lib/python*/site-packages/cmeel.prefix/share/example-robot-data")
FOLDER = next(ROBOTS, Path("not installed")) / "robots"
INERTIAL = re.compile(r"<inertial>.*?</inertial>", re.DOTALL)

ARM = """<robot name="arm"><link name="base"/>
  <link name="upper"><collision><origin xyz="0 0 0.4"/>
    <geometry><box size="0.1 0.1 0.8"/></geometry></collision></link>
  <link name="lower"><collision><origin xyz="0.25 0 0"/>
    <geometry>{shape}</geometry></collision></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="0" velocity="1.5"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/>
    <origin xyz="0 0 0.9"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" velocity="2"/></joint>
</robot>
"""
BALL = '<sphere radius="0.1"/>'
TASK = """
schema = 1
title = "An arm without masses turns past a post"
[system]
file = "arm.urdf"
kinematic = true
{limits}
[[world.obstacle]]
box = [0.1, 0.1, 0.1]
position = [0.0, 0.0, 2.2]
[start]
shoulder = -1.0
[goal]
shoulder = 1.0
elbow = 0.3
tolerance = 0.02
"""


def written(folder: Path, shape: str = BALL) -> Path:
    path = folder / "arm.urdf"
    path.write_text(ARM.format(shape=shape))
    return path


def test_a_refusal_names_the_links_of_the_file_and_both_ways_on(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        read_urdf(written(tmp_path))
    for word in ("upper, lower", "shoulder, elbow", "kinematic = true", "density ="):
        assert word in str(refused.value)


def test_speeds_within_the_limits_of_the_file_are_the_inputs(tmp_path: Path) -> None:
    model = read_urdf(written(tmp_path), kinematic=True, max_velocity={"elbow": 1.0}).model()
    assert model.state_names == ("shoulder", "elbow")
    assert model.control_names == ("shoulder_velocity", "elbow_velocity")
    assert model.control_bounds.tolist() == [[-1.5, 1.5], [-1.0, 1.0]]
    assert model.f([0.3, -0.2], [0.7, -0.4]).tolist() == [0.7, -0.4]


def test_accelerations_are_the_inputs_where_they_have_limits(tmp_path: Path) -> None:
    """Double integrators: nothing of one joint's motion is felt by the other."""
    model = read_urdf(written(tmp_path), kinematic=True, max_acceleration=3.0).model()
    assert model.control_names == ("shoulder_acceleration", "elbow_acceleration")
    assert model.f([0.3, -0.2, 1.0, 1.5], [2.0, -3.0]).tolist() == [1.0, 1.5, 2.0, -3.0]
    assert model.state_bounds[2:].tolist() == [[-1.5, 1.5], [-2.0, 2.0]]


@pytest.mark.parametrize("limits", ["", "max_acceleration = 4.0"])
def test_a_plan_is_verified_and_no_faster_than_its_limits_allow(
    tmp_path: Path, limits: str
) -> None:
    """The shoulder turns by 2 rad, less the tolerance, at 1.5 rad/s at most."""
    written(tmp_path)
    (tmp_path / "task.toml").write_text(TASK.format(limits=limits))
    plan = kinolab.load(tmp_path / "task.toml").solve(seed=1)
    assert plan.status == "solved"
    assert plan.certificate.passed
    assert plan.trajectory.duration >= (2.0 - 0.02) / 1.5 - 1e-9
    rates = np.diff(plan.trajectory.x[:, 0]) / np.diff(plan.trajectory.t)
    assert np.abs(rates).max() <= 1.5 + 1e-6  # [rad/s]


def test_an_mjcf_robot_needs_limits_of_speed(tmp_path: Path) -> None:
    path = tmp_path / "pole.xml"
    path.write_text("""<mujoco><worldbody><body name="pole"><joint name="q" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 1" size="0.05"/></body></worldbody></mujoco>""")
    with pytest.raises(InputError, match=r"nothing limits the speed of q\. Write max_velocity"):
        read_mjcf(path, kinematic=True)
    assert read_mjcf(path, kinematic=True, max_velocity=2.0).model().control_bounds[0, 1] == 2.0


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"max_velocity": 1.0}, "forces move the robot"),
        ({"kinematic": True, "max_velocity": {"elbw": 1.0}}, "Did you mean 'elbow'"),
        ({"kinematic": True, "max_acceleration": -1.0}, "-1 is no limit"),
        ({"kinematic": True, "max_acceleration": {"elbow": 1.0}}, "acceleration of shoulder"),
        ({"kinematic": True, "base": "floating"}, "base that floats"),
        ({"density": 0.0}, "density: it is 0"),
    ],
)
def test_wrong_limits_are_told(tmp_path: Path, given: dict[str, object], told: str) -> None:
    with pytest.raises(InputError, match=told):
        read_urdf(written(tmp_path), **given)


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("density = 1000", "masses have no part"),
        ("max_velocity = 0.0", "max_velocity"),
        ('base = "fixed"\nmax_velocity = { elbow = "fast" }', "max_velocity"),
    ],
)
def test_keys_that_do_not_fit_each_other_are_told(tmp_path: Path, line: str, told: str) -> None:
    written(tmp_path)
    (tmp_path / "task.toml").write_text(TASK.format(limits=line))
    with pytest.raises(InputError, match=told):
        kinolab.load(tmp_path / "task.toml")


def masses(path: Path, density: float) -> tuple[float, float, float]:
    """Mass of ``lower``, its moment about y at its centre, and its centre along x."""
    found = read_urdf(path, density=density)
    body = next(body for body in found.bodies if body.name == "lower mass")
    return found.number(body.mass), found.number(body.inertia[1]), found.offered["cx_lower"]


def test_shapes_weigh_what_their_volume_says(tmp_path: Path) -> None:
    """A ball: 4/3 pi r^3 rho and 2/5 m r^2; a cylinder along z: m (3 r^2 + h^2) / 12."""
    mass = 4.0 / 3.0 * math.pi * 0.1**3 * 800.0
    expected = mass, 0.4 * mass * 0.01, 0.25
    assert masses(written(tmp_path), 800.0) == pytest.approx(expected, rel=1e-12)
    mass = math.pi * 0.04**2 * 0.5 * 800.0
    expected = mass, mass * (3 * 0.04**2 + 0.25) / 12.0, 0.25
    path = written(tmp_path, '<cylinder radius="0.04" length="0.5"/>')
    assert masses(path, 800.0) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("mirrored", ["1 1 1", "1 -1 1"])
@pytest.mark.parametrize("holes", [0, 1])
def test_meshes_weigh_what_they_enclose(tmp_path: Path, holes: int, mirrored: str) -> None:
    """A box 0.2 x 0.1 x 0.3 off its origin; one that lacks a face is filled all the same."""
    box = trimesh.creation.box((0.2, 0.1, 0.3))
    box.apply_translation((0.05, 0.0, 0.0))
    trimesh.Trimesh(box.vertices, box.faces[holes:]).export(tmp_path / "box.stl")
    path = written(tmp_path, f'<mesh filename="box.stl" scale="{mirrored}"/>')
    mass = 0.2 * 0.1 * 0.3 * 500.0
    expected = mass, mass * (0.04 + 0.09) / 12.0, 0.3
    assert masses(path, 500.0) == pytest.approx(expected, rel=1e-5)  # STL has 32-bit numbers


def test_a_robot_of_a_density_moves_as_mujoco_says_that_fills_it_too(tmp_path: Path) -> None:
    """MuJoCo's own inertia from geometry, of the same density."""
    text = ARM.format(shape=BALL)
    made = read_urdf(written(tmp_path), density=700.0).model()
    fill = '<mujoco><compiler inertiafromgeom="true"/></mujoco></robot>'
    there = mujoco.MjSpec.from_string(text.replace("</robot>", fill))
    for geom in there.geoms:
        geom.density = 700.0
    model = there.compile()
    data = mujoco.MjData(model)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    for state in np.random.default_rng(3).uniform(-1.0, 1.0, (5, 4)):
        data.qpos[:], data.qvel[:] = np.split(state, 2)
        mujoco.mj_forward(model, data)
        assert made.f(state, [])[2:] == pytest.approx(data.qacc, rel=1e-9)


@pytest.mark.skipif(not FOLDER.is_dir(), reason="needs example-robot-data")
@pytest.mark.parametrize(
    "name", ["ur_description/urdf/ur5_robot.urdf", "z1_description/urdf/z1.urdf"]
)
def test_public_robots_without_their_inertia_keep_their_frames(tmp_path: Path, name: str) -> None:
    """As a robot of ROS-Industrial: MuJoCo, of the original file, has the same frames."""
    text = (FOLDER / name).read_text()
    (tmp_path / "bare.urdf").write_text(INERTIAL.sub("", text))
    with pytest.raises(InputError, match="have no inertia"):
        read_urdf(tmp_path / "bare.urdf", shapes=False)
    made = read_urdf(tmp_path / "bare.urdf", shapes=False, kinematic=True)
    model = made.model()
    bare = re.sub(r"<(visual|collision)\b.*?</\1>", "", text, flags=re.DOTALL)
    there = mujoco.MjModel.from_xml_string(
        bare.replace("</robot>", '<mujoco><compiler fusestatic="false"/></mujoco></robot>')
    )
    data = mujoco.MjData(there)
    q = np.random.default_rng(2).uniform(-1.0, 1.0, model.nq)
    for value, joint in zip(q, model.state_names, strict=True):
        data.joint(joint).qpos[0] = value
    mujoco.mj_kinematics(there, data)
    frames = dict(zip([body.name for body in made.bodies], model.frames(q), strict=True))
    last = made.bodies[-1].name
    assert frames[last].reshape(3, 4)[:, 3] == pytest.approx(data.body(last).xpos, abs=1e-9)
