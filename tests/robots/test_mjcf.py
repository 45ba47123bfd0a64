"""Models of MuJoCo's move as MuJoCo says, where nothing touches."""

from __future__ import annotations

from contextlib import chdir
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import System
from kinolab.dynamics.language.shapes import Capsule
from kinolab.errors import InputError
from kinolab.robots import read_mjcf

gymnasium = pytest.importorskip("gymnasium")
mujoco: Any = pytest.importorskip("mujoco")
difference: Any = pytest.importorskip("tests.robots.against_mujoco").difference

ASSETS = Path(gymnasium.__file__).parent / "envs" / "mujoco" / "assets"
PUBLIC = ("ant", "half_cheetah", "hopper", "inverted_double_pendulum", "pusher", "walker2d")
AGREE = 1e-9  # relative to the largest acceleration


def agree(file: Path, system: System) -> None:
    """Compare a machine with MuJoCo's model of the same file."""
    assert difference(file, system, states=5, seed=1) <= AGREE


@pytest.mark.parametrize("name", PUBLIC)
def test_public_models_move_as_mujoco_says(name: str) -> None:
    """Shapes have no part in it; with them it is the machine that test_written_files writes."""
    file = ASSETS / f"{name}.xml"
    agree(file, read_mjcf(file))


EVERYTHING = """<mujoco model="everything">
  <compiler angle="radian"/>
  <option gravity="0.3 0 -9.81"/>
  <worldbody>
    <geom type="plane" size="5 5 0.1"/>
    <body name="pole" pos="0 0 2" euler="0.1 0.2 0.3">
      <joint name="socket" type="ball" pos="0 0 0.4"/>
      <geom type="capsule" size="0.05 0.4" mass="1.2"/>
      <body name="arm" pos="0.1 0 -0.4">
        <joint name="turn" axis="1 2 3" pos="0.1 0 0.05" armature="0.3" ref="0.2" range="-2 2"
               limited="true"/>
        <joint name="push" type="slide" axis="0 1 1" armature="0.2" stiffness="30" damping="0.7"
               springref="0.1"/>
        <geom type="box" size="0.1 0.2 0.3" mass="0.7"/>
        <body name="lid" pos="0 0 0.3" quat="1 0.2 0 0"><geom size="0.1" mass="0.3"/></body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="spin" joint="turn" gear="4" ctrlrange="-1 2" ctrllimited="true"/>
    <position name="servo" joint="push" kp="50" forcerange="-7 7" forcelimited="true"/>
  </actuator>
</mujoco>"""


def written(tmp_path: Path, text: str) -> Path:
    """Return a file with a text."""
    file = tmp_path / "model.xml"
    file.write_text(text)
    return file


def test_joints_of_every_kind_with_springs_and_rotors(tmp_path: Path) -> None:
    text = EVERYTHING.replace("<position", "<motor").replace('kp="50"', "")
    file = written(tmp_path, text)
    agree(file, read_mjcf(file))


@pytest.mark.parametrize(
    "attributes", ['damping="0.4"', 'armature="0.3"', 'damping="0.4 0.3 0.2" armature="0.1"']
)
def test_friction_and_rotors_of_ball_joints(tmp_path: Path, attributes: str) -> None:
    text = EVERYTHING.replace("<position", "<motor").replace('kp="50"', "")
    file = written(tmp_path, text.replace('type="ball"', f'type="ball" {attributes}'))
    agree(file, read_mjcf(file))


@pytest.mark.parametrize(
    "attributes",
    ['damping="0.7"', 'armature="0.3"', 'frictionloss="0.2"', 'damping="0.4 0.3" armature="0.1"'],
)
def test_friction_and_rotors_of_free_joints(tmp_path: Path, attributes: str) -> None:
    """A rotor has inertia in every direction and no weight."""
    text = EVERYTHING.replace("<position", "<motor").replace('kp="50"', "")
    text = text.replace('type="ball" pos="0 0 0.4"', f'type="free" {attributes}')
    file = written(tmp_path, text)
    agree(file, read_mjcf(file))


def test_locked_joints_stay_where_mujoco_puts_them(tmp_path: Path) -> None:
    """One that turns about an axis beside its body's origin, from a reference that is not zero."""
    file = written(tmp_path, EVERYTHING)
    own = read_mjcf(file, locked={"turn": 0.7}).model()
    lid = [body.name for body in own.machine.bodies].index("lid")
    model: Any = mujoco.MjModel.from_xml_path(str(file))
    data: Any = mujoco.MjData(model)
    data.qpos[model.jnt_qposadr[model.joint("turn").id]] = 0.7
    mujoco.mj_kinematics(model, data)
    place = own.frames(own.rest())[lid]
    assert np.allclose(place[[3, 7, 11]], data.body("lid").xpos, atol=1e-12)


def test_limits_of_motors_and_joints(tmp_path: Path) -> None:
    system = read_mjcf(written(tmp_path, EVERYTHING))
    assert {entry.name: entry.limit for entry in system.inputs} == {
        "spin": (-4.0, 8.0),
        "servo": (-7.0, 7.0),
    }
    turn = next(c for c in system.coordinates if c.name == "turn")
    assert (turn.lower, turn.upper) == (-2.0, 2.0)
    pole = next(body for body in system.bodies if body.name == "pole")
    assert isinstance(pole.shapes[0], Capsule)
    assert (pole.shapes[0].radius, pole.shapes[0].length) == (0.05, 0.8)


def test_coupled_joints_move_together(tmp_path: Path) -> None:
    """Two equal wheels of inertia I, of which one turns -3 times as far: (I + 9 I) a = tau."""
    wheel = """<body name="{0}" pos="{1} 0 0"><joint name="{0}" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 0.5"/></body>"""
    text = f"""<mujoco><worldbody>{wheel.format("a", 0)}{wheel.format("b", 1)}</worldbody>
      <equality><joint joint1="b" joint2="a" polycoef="0 -3 0 0 0"/></equality>
      <actuator><motor joint="a" ctrlrange="-9 9" ctrllimited="true"/></actuator></mujoco>"""
    model = read_mjcf(written(tmp_path, text)).model()
    assert model.state_names == ("a", "a_dot")
    assert abs(model.f([0.0, 0.0], [5.0])[1] - 5.0 / (0.5 + 9 * 0.5)) < 1e-12


def test_actuators_of_sites_push_as_mujoco_says(tmp_path: Path) -> None:
    """Along their sites' axes, at their places, on a part that is fixed to one that moves."""
    text = EVERYTHING.replace(
        '<geom size="0.1" mass="0.3"/>',
        '<geom size="0.1" mass="0.3"/><site name="nozzle" pos="0.1 0.2 0" euler="0.3 0.2 0.5"/>',
    )
    start, end = text.index("<motor"), text.index("</actuator>")
    jet = '<general name="jet" site="nozzle" gainprm="3" gear="1 -2 0.5 0.3 0 1" ctrlrange="0 2"/>'
    file = written(tmp_path, text[:start] + jet + text[end:])
    system = read_mjcf(file)
    assert [(entry.name, entry.limit) for entry in system.inputs] == [("jet", (0.0, 6.0))]
    agree(file, system)


def test_actuators_of_fixed_tendons_pull_as_mujoco_says(tmp_path: Path) -> None:
    """A force times gear and coefficient on each joint, hinges and slides, and its reaction."""
    text = EVERYTHING.replace(
        "<actuator>",
        """<tendon><fixed name="cord"><joint joint="turn" coef="2"/>
        <joint joint="push" coef="-0.5"/></fixed></tendon><actuator>
        <motor name="pull" tendon="cord" gear="3" ctrlrange="-1 2"/>""",
    )
    file = written(tmp_path, text.replace("<position", "<motor").replace('kp="50"', ""))
    system = read_mjcf(file)
    assert {entry.name: entry.limit for entry in system.inputs}["pull"] == (-1.0, 2.0)
    agree(file, system)


def test_a_servo_of_a_gripper_moves_both_of_its_fingers(tmp_path: Path) -> None:
    """Fingers of 0.1 kg, of which one follows the other: (0.1 + 0.1) a = 0.5 u + 0.5 u."""
    fingers = "".join(
        f'<body name="{k}" pos="0 {k} 0"><joint name="f{k}" type="slide" axis="0 {1 - 2 * k} 0"/>'
        '<geom size="0.05" mass="0.1"/></body>'
        for k in range(2)
    )
    text = f"""<mujoco><worldbody>{fingers}</worldbody>
      <tendon><fixed name="t"><joint joint="f0" coef="0.5"/><joint joint="f1" coef="0.5"/></fixed>
      </tendon><equality><joint joint1="f1" joint2="f0"/></equality>
      <actuator><position name="grip" tendon="t" kp="10" forcerange="-3 3"/></actuator></mujoco>"""
    system = read_mjcf(written(tmp_path, text))
    assert [(entry.name, entry.limit) for entry in system.inputs] == [("grip", (-3.0, 3.0))]
    assert abs(system.model().f([0.0, 0.0], [2.0])[1] - 2.0 / 0.2) < 1e-12


CANNOT = """<mujoco>
  <option density="1000"/>
  <worldbody><body><joint name="j"/><geom size="0.1"/><site name="a"/></body>
  <body><joint name="k"/><geom size="0.1"/><site name="b" pos="1 0 0"/></body></worldbody>
  <tendon><spatial name="t" stiffness="3"><site site="a"/><site site="b"/></spatial></tendon>
  <equality><joint joint1="j" joint2="k" polycoef="0 1 1 0 0"/></equality>
  <actuator><motor name="m" joint="j"/><motor name="n" tendon="t" ctrlrange="-1 1"/></actuator>
</mujoco>"""


def test_all_that_cannot_be_represented_is_named(tmp_path: Path) -> None:
    file = written(tmp_path, CANNOT)
    with pytest.raises(InputError) as caught:
        read_mjcf(file)
    said = str(caught.value)
    for part in (
        "option density is 1000",
        "tendon t has stiffness 3",
        "equality constraint equality_1, joint, has a polycoef that is not linear",
        "actuator m has no limit of its force",
        "actuator n does not act on a joint, but by the transmission tendon",
    ):
        assert part in said
    assert read_mjcf(file, partial=True).model().nv == 2


def test_reading_leaves_no_file_behind(tmp_path: Path) -> None:
    """MuJoCo logs its warnings in the working directory, such as one of this old attribute."""
    text = EVERYTHING.replace('angle="radian"', 'angle="radian" settotalmass="3"')
    file = written(tmp_path, text)
    with chdir(tmp_path):
        read_mjcf(file)
    assert [path.name for path in tmp_path.iterdir()] == [file.name]


def test_what_mujoco_refuses_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="MuJoCo does not read it"):
        read_mjcf(written(tmp_path, "<mujoco><worldbody><bodi/></worldbody></mujoco>"))
    with pytest.raises(InputError, match=r"it is not an XML file \(mismatched tag: line 1"):
        read_mjcf(written(tmp_path, "<mujoco><worldbody><body><joint/></worldbody></mujoco>"))
    with pytest.raises(InputError, match="there is no such file"):
        read_mjcf(tmp_path / "missing.xml")


def test_a_scenario_takes_a_model(tmp_path: Path) -> None:
    (tmp_path / "cart.xml").write_text((ASSETS / "inverted_double_pendulum.xml").read_text())
    (tmp_path / "cart.toml").write_text(
        'schema = 1\ntitle = "A cart with two poles"\n[system]\nfile = "cart.xml"\n'
        "[goal]\nslider = 0.5\nat_rest = true\n"
        "[bounds]\nslider_dot = [-5, 5]\nhinge_dot = [-9, 9]\nhinge2_dot = [-9, 9]\n"
    )
    assert kinolab.load(tmp_path / "cart.toml").model.control_names == ("slide",)
    wrong = (tmp_path / "cart.toml").read_text().replace('.xml"', '.xml"\nbase = "floating"')
    (tmp_path / "wrong.toml").write_text(wrong)
    with pytest.raises(InputError, match="base is a key of URDF files only"):
        kinolab.load(tmp_path / "wrong.toml")
