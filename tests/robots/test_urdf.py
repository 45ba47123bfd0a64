"""Robots that others described in URDF move as Pinocchio says."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh

import kinolab
from kinolab.dynamics.language.shapes import Box, Cylinder
from kinolab.errors import InputError
from kinolab.robots import read_urdf
from tests.robots.against_pinocchio import difference
from tests.support import needs

pytestmark = needs("yourdfpy")

ROBOTS = Path(sys.prefix).glob("lib/python*/site-packages/cmeel.prefix/share/example-robot-data")
FOLDER = next(ROBOTS, Path("not installed")) / "robots"
AGREE = 1e-9  # relative to the largest acceleration

# Arms, a hand, a quadruped, a flying arm and a wheeled robot, described by their makers.
PUBLIC = {
    "panda_description/urdf/panda.urdf": "fixed",
    "ur_description/urdf/ur5_robot.urdf": "fixed",
    "xarm_description/urdf/xarm7.urdf": "fixed",
    "z1_description/urdf/z1.urdf": "fixed",
    "kinova_description/robots/kinova.urdf": "fixed",
    "so_arm_description/urdf/so101.urdf": "fixed",
    "allegro_hand_description/urdf/allegro_right_hand.urdf": "fixed",
    "tiago_description/robots/tiago_no_hand.urdf": "fixed",
    "finger_edu_description/robots/finger_edu.urdf": "fixed",
    "double_pendulum_description/urdf/double_pendulum.urdf": "fixed",
    "solo_description/robots/solo12.urdf": "floating",
    "borinot_description/urdf/borinot_flying_arm_2.urdf": "floating",
}


@pytest.mark.skipif(not FOLDER.is_dir(), reason="needs example-robot-data")
@pytest.mark.parametrize("name", PUBLIC)
def test_public_robots_move_as_pinocchio_says(name: str) -> None:
    file, floating = FOLDER / name, PUBLIC[name] == "floating"
    system = read_urdf(file, base="floating" if floating else "fixed", shapes=False)
    assert difference(file, system, states=5, seed=1, floating=floating) <= AGREE


ARM = """<?xml version="1.0"?>
<robot name="two-bar arm">
  <link name="base"><visual><geometry><box size="0.2 0.2 0.1"/></geometry></visual></link>
  <link name="upper">
    <inertial>
      <origin xyz="0 0 0.5"/><mass value="2.0"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <collision>
      <origin xyz="0 0 0.5" rpy="0 1.5707963267948966 0"/>
      <geometry><cylinder radius="0.05" length="0.9"/></geometry>
    </collision>
    <collision>
      <origin xyz="0 0 0.5" rpy="0.3 0 0"/><geometry><box size="0.1 0.2 0.3"/></geometry>
    </collision>
  </link>
  <link name="tip">
    <inertial>
      <origin xyz="0 0 0.1"/><mass value="1.0"/>
      <inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="shoulder-pan" type="revolute">
    <parent link="base"/><child link="upper"/><origin xyz="0 0 1"/><axis xyz="0 2 0"/>
    <limit lower="-2" upper="2" velocity="3" effort="10"/><dynamics damping="0.5"/>
  </joint>
  <joint name="wrist" type="fixed">
    <parent link="upper"/><child link="tip"/><origin xyz="0 0 1"/>
  </joint>
</robot>
"""


def written(tmp_path: Path, text: str, name: str = "arm.urdf") -> Path:
    """Return a file with a text."""
    file = tmp_path / name
    file.write_text(text)
    return file


def test_an_arm_swings_as_a_physical_pendulum(tmp_path: Path) -> None:
    """Links that are fixed to each other swing as one: I a = tau - d w + (sum m l) g sin(theta)."""
    system = read_urdf(written(tmp_path, ARM))
    model = system.model()
    assert model.state_names == ("shoulder_pan", "shoulder_pan_dot")
    assert [entry.name for entry in system.inputs] == ["shoulder_pan_torque"]
    inertia = 0.1 + 2.0 * 0.5**2 + 1.0 * 1.1**2
    theta, omega, torque = 0.7, -0.4, 3.0
    lifting = 9.81 * (2.0 * 0.5 + 1.0 * 1.1) * math.sin(theta)
    expected = (torque - 0.5 * omega + lifting) / inertia
    assert abs(model.f([theta, omega], [torque])[1] - expected) < 1e-12


def test_limits_are_those_of_the_joint(tmp_path: Path) -> None:
    system = read_urdf(written(tmp_path, ARM))
    (shoulder,) = system.coordinates
    assert (shoulder.lower, shoulder.upper, shoulder.speed) == (-2.0, 2.0, 3.0)
    assert system.inputs[0].limit == (-10.0, 10.0)


def test_shapes_are_where_the_file_says(tmp_path: Path) -> None:
    """In their links' frames; what is turned obliquely has a body of its own, the tip a frame."""
    bodies = {body.name: body for body in read_urdf(written(tmp_path, ARM)).bodies}
    (bar,) = bodies["upper"].shapes
    assert isinstance(bar, Cylinder)
    assert (bar.axis, bar.radius, bar.length) == ("x", 0.05, 0.9)
    assert np.allclose(np.array(bar.at, dtype=float), [0, 0, 0.5])
    assert [type(shape) for shape in bodies["upper 2"].shapes] == [Box]
    assert bodies["base"].touches_ground
    assert not bodies["tip"].shapes
    model = read_urdf(written(tmp_path, ARM)).model()
    x, places = [0.0, 0.0], [body.name for body in model.machine.bodies]
    tip = model.frames(x)[places.index("tip")]
    assert np.allclose(tip[[3, 7, 11]], [0.0, 0.0, 2.0])  # 1 m above the upper link's


def test_joints_are_locked_and_free_bases_float(tmp_path: Path) -> None:
    file = written(tmp_path, ARM)
    free = read_urdf(file, base="floating", locked={"shoulder-pan": 0.3}).model()
    assert free.nv == 6
    assert "base_wz" in free.state_names


def test_a_follower_moves_its_leader_s_way(tmp_path: Path) -> None:
    """Two equal masses on rails, of which one goes twice as far: (m + 4 m) a = F."""
    slider = """
  <link name="{0}"><inertial><mass value="1.0"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{0}_rail" type="prismatic"><parent link="base"/><child link="{0}"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="5" velocity="1"/>{1}</joint>"""
    mimic = '<mimic joint="a_rail" multiplier="-2" offset="0.1"/>'
    text = f"""<robot name="gripper"><link name="base"/>
{slider.format("a", "")}{slider.format("b", mimic)}</robot>"""
    system = read_urdf(written(tmp_path, text))
    assert [entry.name for entry in system.inputs] == ["a_rail_force"]
    model = system.model()
    assert abs(model.f([0.0, 0.0], [5.0])[1] - 1.0) < 1e-12
    locked = read_urdf(written(tmp_path, text), base="floating", locked={"a_rail": 0.3})
    model = locked.model()
    mass = [body.name for body in model.machine.bodies].index("base mass")
    place = model.frames(model.rest())[mass]  # a at 0.3, b at -0.5, in one body
    assert np.allclose(place[[3, 7, 11]], [(0.3 - 0.5) / 2, 0.0, 0.0], atol=1e-12)


WRONG = """<robot name="wrong">
  <link name="base"/>
  <link name="arm"><inertial><mass value="1.0"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><mesh filename="package://nowhere/arm.stl"/></geometry></collision></link>
  <link name="hand"/>
  <link name="arm"/>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="arm"/></joint>
  <joint name="wrist" type="revolute"><parent link="arm"/><child link="hnad"/>
    <axis xyz="0 0 0"/><limit lower="2" upper="-2" effort="1" velocity="1"/></joint>
</robot>"""


def test_all_mistakes_of_a_file_are_named_at_once(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_urdf(written(tmp_path, WRONG, "wrong.urdf"))
    said = str(caught.value)
    for part in (
        "wrong.urdf link 'arm': its mesh package://nowhere/arm.stl: it cannot be found.",
        "wrong.urdf joint 'shoulder': it has no <limit>.",
        "wrong.urdf joint 'wrist': its axis has no direction.",
        "wrong.urdf joint 'wrist' child",
        "wrong.urdf joint 'wrist': its limits are 2 to -2.",
        "wrong.urdf link 'arm': two links have this name.",
    ):
        assert part in said


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('ixx="0.1"', 'ixx="-5"'), "negative principal moment"),
        (('mass value="2.0"', 'mass value="nan"'), "not finite"),
        (('mass value="2.0"', 'mass value="-1"'), "its mass is -1 kg"),
        (('<origin xyz="0 0 0.5"/><mass', '<origin xyz="0 0 500"/><mass'), "millimetres"),
        (('type="revolute"', 'type="screw"'), "its type is 'screw'"),
        (('radius="0.05"', 'radius="0"'), "Give positive ones."),
        (('axis xyz="0 2 0"', 'axis xyz="200"'), "<axis> xyz is '200'. Give 3 numbers."),
        (('mass value="2.0"', 'mass value="2 0"'), "<mass> value is '2 0'. Give one number."),
        (('mass value="2.0"', 'mass value="1e300"'), "1e+300 is a mass or an inertia beyond 1e+60"),
        (("</robot>", ""), "arm.urdf: it is not an XML file (Premature end of data in tag robot"),
        (('damping="0.5"', 'damping="-0.5"'), "arm.urdf joint 'shoulder-pan': its damping is -0.5"),
        (('izz="0.01"', 'izz="50"'), "arm.urdf link 'upper': of its moments of inertia"),
        (("<robot", "<!DOCTYPE r [<!ENTITY a 'b'>]><robot"), "XML entities"),
    ],
)
def test_what_is_wrong_is_said(change: tuple[str, str], said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read_urdf(written(tmp_path, ARM.replace(*change)))
    assert said in str(caught.value)


FOLLOWER = """<link name="f"><inertial><mass value="1.5"/>
  <inertia ixx="0.3" iyy="0.3" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><sphere radius="0.125"/></geometry>
  <material name="nan"><color rgba="0.1 0.2 0.3 1.0"/></material></visual></link>
<joint name="inf" type="revolute"><parent link="tip"/><child link="f"/><axis xyz="1 0 0"/>
  <limit lower="-1.25" upper="1.5" velocity="1.75" effort="7"/>
  <dynamics friction="0.375" damping="0.4"/>
  <safety_controller k_velocity="12.5" k_position="110" soft_lower_limit="-1.1"
    soft_upper_limit="1.3"/>
  <mimic joint="shoulder-pan" multiplier="2.5" offset="0.0625"/></joint></robot>"""
WITH_FOLLOWER = ARM.replace("</robot>", FOLLOWER)


@pytest.mark.parametrize(
    "joints",
    [
        [("upper", "upper")],  # beside the one from the base
        [("tip", "upper")],
        [("tip", "tip")],
        [("tip", "base")],
    ],
)
def test_links_that_go_round_are_refused(joints: list[tuple[str, str]], tmp_path: Path) -> None:
    added = "".join(
        f'<joint name="further {k}" type="continuous"><parent link="{parent}"/>'
        f'<child link="{child}"/><limit effort="1" velocity="1"/></joint>'
        for k, (parent, child) in enumerate(joints)
    )
    with pytest.raises(InputError, match=r"two joints|to itself|every link has one"):
        read_urdf(written(tmp_path, ARM.replace("</robot>", f"{added}</robot>")))


@pytest.mark.parametrize("word", ["nan", "-inf", "1e999"])
@pytest.mark.parametrize(
    "attribute",
    [
        'mass value="2.0"', 'origin xyz="0 0 0.5"', 'rpy="0.3 0 0"', 'cylinder radius="0.05"',
        'length="0.9"', 'box size="0.1 0.2 0.3"', 'sphere radius="0.125"', 'axis xyz="0 2 0"',
        'lower="-1.25"', 'upper="1.5"', 'velocity="1.75"', 'effort="7"', 'effort="10"',
        'friction="0.375"', 'damping="0.4"', 'multiplier="2.5"', 'offset="0.0625"',
        'rgba="0.1 0.2 0.3 1.0"', 'ixx="0.3"', 'ixy="0"', 'k_velocity="12.5"', 'k_position="110"',
        'soft_lower_limit="-1.1"', 'soft_upper_limit="1.3"',
    ],
)  # fmt: skip
def test_a_number_that_is_not_finite_is_refused(attribute: str, word: str, tmp_path: Path) -> None:
    """Wherever it stands; names may be what they like."""
    changed = re.sub(r'"[^ "]+', f'"{word}', attribute)  # the first number of it
    assert WITH_FOLLOWER.count(attribute)
    with pytest.raises(InputError, match=rf"is '{word}.*', which is not finite"):
        read_urdf(written(tmp_path, WITH_FOLLOWER.replace(attribute, changed)))
    read_urdf(written(tmp_path, WITH_FOLLOWER))


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('velocity="3"', 'velocity="-3"', "<limit> velocity is -3"),
        ('effort="10"', 'effort="-10"', "<limit> effort is -10"),
        ('velocity="1.75"', 'velocity="-1.75"', "<limit> velocity is -1.75"),
        ('effort="7"', 'effort="-7"', "<limit> effort is -7"),
        ('friction="0.375"', 'friction="-0.375"', "<dynamics> friction is -0.375"),
    ],
)
def test_a_magnitude_that_is_negative_is_refused(
    before: str, after: str, said: str, tmp_path: Path
) -> None:
    """A joint with a negative limit of its speed had none."""
    joint = "shoulder-pan" if before in ARM else "inf"
    assert WITH_FOLLOWER.count(before) == 1
    with pytest.raises(InputError, match=re.escape(f"joint {joint!r}: {said}")) as caught:
        read_urdf(written(tmp_path, WITH_FOLLOWER.replace(before, after)))
    assert len(caught.value.mistakes) == 1


def test_what_is_not_read_is_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    read_urdf(written(tmp_path, ARM))
    assert not caplog.messages
    changed = WITH_FOLLOWER.replace('effort="10"', 'effort="0" acceleration="4"')
    changed = changed.replace("</robot>", '<loop_joint name="l"/><gazebo/></robot>')
    read_urdf(written(tmp_path, changed))
    soft = "<safety_controller> of inf is not read; [bounds] of a scenario may be as narrow."
    assert caplog.messages == [
        "arm.urdf: not read: acceleration of <limit> (shoulder-pan), <loop_joint> (l).",
        "arm.urdf: the effort of joints that follow others is not read: inf.",
        "arm.urdf: joints with effort 0 have no motor: shoulder-pan.",
        f"arm.urdf: {soft}",
    ]


def test_a_file_of_many_strange_words_is_told_in_one_line(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    strange = " ".join(f'gear{k}{"x" * 10}="1"' for k in range(9))
    read_urdf(written(tmp_path, ARM.replace("<axis", f"<axis {strange}")))
    (line,) = caplog.messages
    assert line.endswith("…).") or line.endswith(" ….")
    assert len(line) < 250


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("collision>", "colision>", "link has 'colision', which is not a word of URDF. Did you"),
        (
            "upper=",
            "uper=",
            "<limit> has 'uper', which is not a word of URDF. Did you",
        ),
        ("effort=", "efort=", "<limit> has 'efort'"),
        ("dynamics", "dynamic", "joint has 'dynamic'"),
        ("<inertial>", "<inertia>", "link has 'inertia'"),
        ("multiplier=", "multiplyer=", "<mimic> has 'multiplyer'"),
        ("sphere", "capsule", "its <geometry> has <capsule>. Known: box, cylinder, mesh, sphere."),
        ('<mass value="1.5"/>', "", "link 'f': its <inertial> has no <mass>."),
        ('effort="7"', 'effort="7 Nm"', "<limit> effort is '7 Nm', which is not finite."),
        ("robot", "mujoco", "it begins with <mujoco>, not <robot>"),
    ],
)
def test_a_word_that_is_misspelt_is_not_passed_over(
    before: str, after: str, said: str, tmp_path: Path
) -> None:
    """A link lost its shape, a joint its limits or its motor, and no word was said."""
    text = WITH_FOLLOWER
    if before == "<inertial>":
        text = text.replace("</inertial>", "</inertia>")
    with pytest.raises(InputError, match=re.escape(said)):
        read_urdf(written(tmp_path, text.replace(before, after)))


@pytest.mark.parametrize("before", ['<?xml version="0.0" ?>', "\n<?xml version='1.0'?>", "\n "])
def test_what_files_begin_with_is_taken_as_other_readers_do(before: str, tmp_path: Path) -> None:
    """Files of simulators call themselves XML 0.0, or begin with a blank line."""
    read = read_urdf(written(tmp_path, before + ARM.partition("?>")[2], "begun.urdf"))
    assert [c.name for c in read.coordinates] == ["shoulder_pan"]


def test_a_robot_without_mass_agrees_with_engines_that_give_it_the_least(tmp_path: Path) -> None:
    """MuJoCo knows no mass below 1e-15 kg; its rounding is no difference."""
    plane = (
        "<robot name='p'><link name='l'><inertial><mass value='0'/><inertia ixx='0' ixy='0' "
        "ixz='0' iyy='0' iyz='0' izz='0'/></inertial><collision><geometry>"
        "<box size='3 3 1'/></geometry></collision></link></robot>"
    )
    assert read_urdf(written(tmp_path, plane, "plane.urdf"), base="floating").bodies


def test_all_mistakes_in_numbers_are_told_at_once(tmp_path: Path) -> None:
    text = ARM.replace('velocity="3"', 'velocity="-3"').replace('effort="10"', 'effort="nan"')
    with pytest.raises(InputError) as caught:
        read_urdf(written(tmp_path, text))
    assert len(caught.value.mistakes) == 2


def test_a_joint_that_moves_nothing_is_refused(tmp_path: Path) -> None:
    text = ARM.replace("fixed", "continuous").replace('<mass value="1.0"/>', '<mass value="0"/>')
    with pytest.raises(InputError, match="it moves tip, which has no inertia"):
        read_urdf(written(tmp_path, text))


def test_a_mesh_in_millimetres_is_noticed(tmp_path: Path) -> None:
    corners = "v 0 0 0\nv 300 0 0\nv 0 300 0\nv 0 0 300\n"
    (tmp_path / "bar.obj").write_text(corners + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    cylinder = '<cylinder radius="0.05" length="0.9"/>'
    text = ARM.replace(cylinder, '<mesh filename="bar.obj"/>')
    with pytest.raises(InputError, match="Is it in millimetres"):
        read_urdf(written(tmp_path, text))
    scaled = ARM.replace(cylinder, '<mesh filename="bar.obj" scale="0.001 0.001 0.001"/>')
    assert read_urdf(written(tmp_path, scaled)).model().nv == 1


BAR = """<link name="{0}"><inertial><origin xyz="0 0 0.25"/><mass value="1"/>
  <inertia ixx="0.02" iyy="0.02" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><origin xyz="0 0 0.25"/><geometry><box size="0.05 0.05 0.5"/></geometry></collision>
  </link>
  <joint name="to_{0}" type="revolute"><parent link="{1}"/><child link="{0}"/>
  <origin xyz="0 0 {2}"/><axis xyz="0 1 0"/>
  <limit lower="-3" upper="3" effort="30" velocity="3"/></joint>"""


def test_links_that_are_no_neighbours_may_not_touch(tmp_path: Path) -> None:
    bars = BAR.format("a", "base", 0) + BAR.format("b", "a", 0.5) + BAR.format("c", "b", 0.5)
    file = written(tmp_path, f'<robot name="chain"><link name="base"/>{bars}</robot>')
    system = read_urdf(file)
    assert system.collisions == (("a", "c"),)
    assert not read_urdf(file, self_collisions=False).collisions
    (tmp_path / "fold.toml").write_text(
        'schema = 1\ntitle = "It folds"\n[system]\nfile = "arm.urdf"\n'
        "[goal]\nto_b = 1.0\nat_rest = true\n"
    )
    problem = kinolab.load(tmp_path / "fold.toml")
    straight, folded = problem.model.rest(), problem.model.rest()
    folded[1:3] = 2.2, 2.2  # the third bar crosses the first one
    checker = problem.checker()
    for x, touching in ((straight, False), (folded, True)):
        assert checker.collides(problem.model.frames(x)) is touching


def test_a_scenario_plans_for_a_robot_s_file(tmp_path: Path) -> None:
    written(tmp_path, ARM.replace('effort="10"', 'effort="40"'))
    (tmp_path / "swing.toml").write_text("""
schema = 1
title = "An arm is lowered"
[system]
file = "arm.urdf"
[goal]
shoulder_pan = 1.5
at_rest = true
""")
    plan = kinolab.load(tmp_path / "swing.toml").solve(seed=1, time_limit=30.0, improve=0.5)
    assert plan.status == "solved"
    plan.save(tmp_path / "run")
    assert kinolab.read_run(tmp_path / "run").problem.model.state_names[0] == "shoulder_pan"


def test_only_robots_from_files_have_a_base(tmp_path: Path) -> None:
    text = 'schema = 1\ntitle = "x"\n[system]\nname = "rolling_disk"\nbase = "floating"\n'
    (tmp_path / "s.toml").write_text(text)
    with pytest.raises(InputError, match="base is a key of URDF files only"):
        kinolab.load(tmp_path / "s.toml")


def test_arguments_that_do_not_fit_are_named(tmp_path: Path) -> None:
    file = written(tmp_path, ARM)
    with pytest.raises(InputError, match="no base is called 'foo'"):
        read_urdf(file, base="foo")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="read_urdf locked"):
        read_urdf(file, locked="grip")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="read_urdf path"):
        read_urdf(None)  # type: ignore[arg-type]


def test_an_inertia_that_no_body_has_is_balanced_if_wanted(tmp_path: Path) -> None:
    """As MuJoCo's balanceinertia has it, whose model of the file is the judge; a note says so."""
    crooked = ARM.replace(
        '<inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/>',
        '<inertia ixx="0.1" iyy="0.02" izz="0.06" ixy="0.01" ixz="0" iyz="0"/>',
    )
    path = written(tmp_path, crooked)
    with pytest.raises(InputError, match=r"arm.urdf link 'upper': .* exceeds the sum of the oth"):
        read_urdf(path)
    system = read_urdf(path, balance_inertia=True)
    assert "the inertia of upper is balanced" in dict(system.notes)[""]
    mujoco = pytest.importorskip("mujoco")
    option = '<mujoco><compiler balanceinertia="true"/></mujoco><link name="base">'
    there = mujoco.MjModel.from_xml_string(crooked.replace('<link name="base">', option, 1))
    data = mujoco.MjData(there)
    data.qpos[:], data.qvel[:] = 0.7, -0.4
    mujoco.mj_forward(there, data)
    found = system.model().f([0.7, -0.4], [0.0])[1]
    assert abs(found - data.qacc[0]) < 1e-9 * abs(found)


PLANAR = """<robot name="slider"><link name="a"/><link name="b"><inertial><mass value="1"/>
  <inertia ixx="0.01" iyy="0.02" izz="0.015" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j" type="planar"><parent link="a"/><child link="b"/><axis xyz="{}"/></joint></robot>
"""


@pytest.mark.parametrize("axis", ["0 0 1", "1 0 0", "0 1 0", "0 0 -1", "0.36 0.48 0.8"])
def test_a_planar_joint_slides_along_the_axes_that_mujoco_has(axis: str, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = read_urdf(written(tmp_path, PLANAR.format(axis))).model()
    there = mujoco.MjModel.from_xml_string(PLANAR.format(axis))
    data = mujoco.MjData(there)
    data.qpos[:] = at = [0.3, -0.2, 0.7]
    mujoco.mj_kinematics(there, data)
    pose = model.frames([*at, 0.0, 0.0, 0.0])[-1].reshape(3, 4)
    assert np.abs(pose[:, 3] - data.xpos[-1]).max() < 1e-12
    assert np.abs(pose[:, :3] - data.xmat[-1].reshape(3, 3)).max() < 1e-12


TEMPLATE = ARM.replace(
    'name="two-bar arm">',
    'name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="m" value="2"/>',
).replace('<mass value="2.0"/>', '<mass value="${m}"/>')


def test_a_template_without_xacro_says_how_to_get_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)
    with pytest.raises(InputError, match=r"pip install xacro, or run xacro on it first: xacro rob"):
        read_urdf(written(tmp_path, TEMPLATE, "arm.urdf.xacro"))


@needs("xacro")
def test_a_template_is_expanded(tmp_path: Path) -> None:
    plain = read_urdf(written(tmp_path, ARM)).model()
    model = read_urdf(written(tmp_path, TEMPLATE, "arm.urdf.xacro")).model()
    assert np.array_equal(model.f([0.3, 0.1], [1.0]), plain.f([0.3, 0.1], [1.0]))
    with pytest.raises(InputError, match=r"arm.urdf.xacro: xacro cannot expand it \("):
        read_urdf(written(tmp_path, TEMPLATE.replace("${m}", "${mass}"), "arm.urdf.xacro"))


@needs("xacro")
def test_a_template_finds_what_lies_beside_its_package(tmp_path: Path) -> None:
    """As in a folder of packages that were downloaded, without ROS."""
    parts, urdf = tmp_path / "arm_parts", tmp_path / "arm_description" / "urdf"
    for folder in (parts, urdf):
        folder.mkdir(parents=True)
    (parts / "values.xacro").write_text(
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="m" value="2"/>'
        "</robot>"
    )
    trimesh.creation.box((0.1, 0.1, 0.3)).export(parts / "tip.stl")
    include = '<xacro:include filename="$(find arm_parts)/values.xacro"/>'
    mesh = 'size="0.1 0.2 0.3"', "file://$(find arm_parts)/tip.stl"
    text = TEMPLATE.replace('<xacro:property name="m" value="2"/>', include)
    text = text.replace(f"<box {mesh[0]}/>", f'<mesh filename="{mesh[1]}"/>')
    file = written(urdf, text, "arm.urdf.xacro")
    read = read_urdf(file)
    plain = read_urdf(written(tmp_path, ARM)).model()
    assert np.array_equal(read.model().f([0.3, 0.1], [1.0]), plain.f([0.3, 0.1], [1.0]))
    ((tip,),) = (body.shapes for body in read.bodies if body.name == "upper 2")
    assert isinstance(tip, Box)
    assert (tip.x, tip.y, tip.z) == pytest.approx((0.1, 0.1, 0.3))
    (parts / "values.xacro").unlink()
    missing = (
        r"arm.urdf.xacro: what it includes is not in the folders above it: package://arm_parts"
    )
    with pytest.raises(InputError, match=missing):
        read_urdf(file)


def test_a_scenario_may_name_a_file_anywhere(tmp_path: Path) -> None:
    """Robots lie where their packages are installed, which is seldom beside a scenario."""
    place = str(written(tmp_path, ARM).absolute())
    problem = kinolab.load({"system": {"file": place}, "goal": {"shoulder_pan": 1.0}})
    assert problem.machine.name == "two_bar_arm"
    run = problem.solve(seed=1).save(tmp_path / "run")
    assert kinolab.read_run(run).problem.machine.name == "two_bar_arm"
