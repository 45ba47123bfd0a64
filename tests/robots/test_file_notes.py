"""What of a robot's file is not read, or is something else in its machine, is said."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any

import pytest

import kinolab
from kinolab.cli import run
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import EndpointError, InputError
from kinolab.problem.warnings import problem_warnings
from kinolab.robots import read_mjcf, read_urdf
from kinolab.show.view import content_of, views
from tests.support import needs

LINK = """<link name="{}"><inertial><origin xyz="0 0 0.2"/><mass value="1"/>
  <inertia ixx="{}" iyy="{}" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="{0}" type="{1}"><parent link="{2}"/><child link="{3}"/>
  <axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="9" velocity="2"/>{4}</joint>"""
ARM = (
    '<robot name="arm"><link name="base"/>'
    + LINK.format("upper", 0.02, 0.02)
    + LINK.format("finger", 0.02, 0.02)
    + JOINT.format("shoulder", "revolute", "base", "upper", "")
    + JOINT.format(
        *("follower", "revolute", "upper", "finger"),
        '<mimic joint="shoulder" multiplier="-2" offset="0.5"/>',
    )
    + "</robot>"
)
NOT_READ = "arm.urdf: the effort of joints that follow others is not read: follower."
SCENARIO = 'schema = 1\ntitle = "t"\n[system]\nfile = "{}"\n'

MODEL = """<mujoco><worldbody><geom name="floor" type="plane" size="1 1 0.1"/>
  <body name="target" mocap="true" pos="3 0 1"><geom size="0.1"/></body>
  <body name="arm" pos="0 0 1"><joint name="elbow" axis="0 1 0" range="-90 90"/>
    <geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.03" mass="1"/></body></worldbody>
  <actuator><position name="drive" joint="elbow" kp="{}" ctrlrange="-1 1" {}/></actuator>
  <keyframe><key name="home" qpos="0.5"/><key qpos="0"/></keyframe></mujoco>"""


def in_folder(folder: Path, name: str, text: str, further: str = "") -> Path:
    """Return a scenario of a robot's file."""
    (folder / name).write_text(text)
    (folder / "scenario.toml").write_text(SCENARIO.format(name) + further)
    return folder / "scenario.toml"


@needs("yourdfpy")
def test_a_run_s_folder_says_what_of_a_urdf_file_is_not_read(tmp_path: Path) -> None:
    further = "[goal]\nshoulder = 0.3\nat_rest = true\n[bounds]\nshoulder_dot = [-2, 2]\n"
    problem = kinolab.load(in_folder(tmp_path, "arm.urdf", ARM, further))
    assert NOT_READ in problem_warnings(problem)
    plan = problem.solve(seed=1, optimize=False)
    plan.save(tmp_path / "run")
    report = json.loads((tmp_path / "run" / "report.json").read_text())
    assert report["warnings"].count(NOT_READ) == 1
    page = views(content_of(problem, plan.trajectory, report))["scene.html"].decode()
    assert NOT_READ in page
    kept = machine_from_json((tmp_path / "run" / "assets" / "machine.json").read_text())
    assert ("", NOT_READ) in kept.notes


@needs("yourdfpy")
@pytest.mark.parametrize("command", ["examine", "describe"])
def test_a_command_says_it_once(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str], caplog: Any
) -> None:
    (tmp_path / "arm.urdf").write_text(ARM)
    run([command, str(tmp_path / "arm.urdf")])
    told = capsys.readouterr()
    assert told.out.count(NOT_READ) + told.err.count(NOT_READ) == 1
    assert not caplog.messages


@needs("yourdfpy")
def test_who_reads_a_file_in_python_is_told_once(tmp_path: Path, caplog: Any) -> None:
    (tmp_path / "arm.urdf").write_text(ARM)
    read_urdf(tmp_path / "arm.urdf")
    assert caplog.messages == [NOT_READ]
    caplog.clear()
    run(["simulate", str(tmp_path / "arm.urdf"), "--out", str(tmp_path / "o"), "--no-animation"])
    assert caplog.messages == [NOT_READ]


@needs("mujoco")
@pytest.mark.parametrize(
    ("kp", "further", "said"),
    [
        ("9", 'forcerange="-5 5"', ["stand still: target.", "not read: home, key_2. [start]",
                                    'the ground is not read: floor. Write ground = "plane"']),
        ("9", 'ctrllimited="false" forcerange="-5 5"',
         ["servos without ctrlrange are motors, whose inputs are forces: drive."]),
        ("9", 'group="3"', ["what is switched off is not read: pin, drive."]),
        ("-9", "", ["servos with a negative kp or kv drive their joints away: drive."]),
    ],
)  # fmt: skip
def test_what_is_something_else_in_a_model_is_said(
    kp: str, further: str, said: list[str], tmp_path: Path
) -> None:
    text = MODEL.format(kp, further)
    if "group" in further:
        off = '<option actuatorgroupdisable="3"/><equality><joint name="pin" joint1="elbow" '
        text = text.replace("<mujoco>", f'<mujoco>{off}active="false"/></equality>')
    (tmp_path / "arm.xml").write_text(text)
    system = read_mjcf(tmp_path / "arm.xml")
    told = [sentence for name, sentence in system.notes if not name]
    assert all(sentence.startswith("arm.xml: ") for sentence in told)
    assert all(any(words in sentence for sentence in told) for words in said), told
    assert machine_from_json(machine_to_json(system)).notes == system.notes


@needs("mujoco")
def test_a_model_without_such_things_says_nothing(tmp_path: Path) -> None:
    text = MODEL.format(9, 'forcerange="-5 5"')
    for part in ("<keyframe>.*</keyframe>", '<geom name="floor"[^>]*>', ' mocap="true"'):
        text = re.sub(part, "", text)
    extras = '<sensor><jointpos joint="elbow"/></sensor><visual/><statistic extent="1"/>'
    (tmp_path / "arm.xml").write_text(text.replace("</mujoco>", f"{extras}</mujoco>"))
    assert read_mjcf(tmp_path / "arm.xml").notes == ()


@needs("yourdfpy")
@pytest.mark.parametrize(
    ("section", "said"),
    [
        ("[goal]\nfollower = 0.1\n",
         r"\[goal\] follower: it follows shoulder: it is -2 \* shoulder \+ 0.5. "
         r"Write shoulder, at \(value - 0.5\) / -2"),
        ("[start]\nfollower_dot = 1.0\n", r"\[start\] follower_dot: it follows shoulder"),
        ("[bounds]\nfollower = [0, 1]\n", r"\[bounds\] follower: .* follows shoulder"),
    ],
)  # fmt: skip
def test_a_joint_that_follows_is_said_to(section: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=said):
        kinolab.load(in_folder(tmp_path, "arm.urdf", ARM, section))


@needs("yourdfpy")
def test_a_joint_that_is_locked_is_said_to_be(tmp_path: Path) -> None:
    further = 'locked = { shoulder = "30 deg" }\n[goal]\nshoulder = 0.3\n'
    with pytest.raises(InputError, match="it is not a coordinate, but held at"):
        kinolab.load(in_folder(tmp_path, "arm.urdf", ARM, further))


@needs("yourdfpy")
@pytest.mark.parametrize(
    ("kind", "angle"), [("prismatic", "30 deg"), ("revolute", "30 deg/s"), ("prismatic", "pi/9")]
)
def test_an_angle_locks_what_turns(kind: str, angle: str, tmp_path: Path) -> None:
    text = ARM.replace("revolute", kind)
    further = f'locked = {{ shoulder = "{angle}" }}\n'
    with pytest.raises(InputError, match=f"locked shoulder: '{angle}' is no position of shoulder"):
        kinolab.load(in_folder(tmp_path, "arm.urdf", text, further))


@needs("yourdfpy")
@pytest.mark.parametrize(
    ("moments", "doubted"), [((0.02, 0.02), False), ((2e4, 2e4), True), ((0.3, 0.3), True)]
)
def test_an_inertia_beyond_mass_and_size_is_doubted(
    moments: tuple[float, float], doubted: bool, tmp_path: Path
) -> None:
    """1 kg, 0.2 m from the root at most, has up to 1 * 0.4^2 = 0.16 kg m^2."""
    text = ARM.replace(LINK.format("upper", 0.02, 0.02), LINK.format("upper", *moments))
    (tmp_path / "arm.urdf").write_text(text)
    told = [sentence for _, sentence in read_urdf(tmp_path / "arm.urdf").notes]
    said = f"arm.urdf: the inertia of upper is {moments[0]:.3g}; its mass and the robot's size"
    assert any(f"{said} allow at most 0.16." in one for one in told) == doubted


@needs("mujoco")
def test_what_sinks_into_the_ground_is_not_told_to_write_python(tmp_path: Path) -> None:
    text = MODEL.format(9, 'forcerange="-5 5"').replace('pos="0 0 1"', 'pos="0 0 0.3"')
    further = '[world]\nground = "plane"\n[bounds]\nelbow_dot = [-9, 9]\n[goal]\nelbow = 1\n'
    with pytest.raises(EndpointError) as caught:
        kinolab.load(in_folder(tmp_path, "arm.xml", text, further)).check_endpoints()
    assert "touches_ground" not in str(caught.value)
    assert "Lift it in [start] and [goal], or leave ground out of [world]." in str(caught.value)


@needs("yourdfpy")
def test_a_description_lists_what_a_robot_s_file_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "arm.urdf").write_text(ARM)
    assert run(["describe", str(tmp_path / "arm.urdf")]) == 0
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    # the follower's limits, -2 to 2, leave the shoulder from -0.75 to 1.25, at half its speed
    assert "shoulder -0.75 to 1.25 rad at most 1 rad/s" in lines
    assert "shoulder_torque torque -9 to 9 N m" in lines
    assert run(["describe", "--json", str(tmp_path / "arm.urdf")]) == 0
    (shoulder,) = json.loads(capsys.readouterr().out)["coordinates"]
    assert (shoulder["limits"], shoulder["speed"]) == ([-0.75, 1.25], 1.0)


@needs("yourdfpy")
def test_what_a_second_engine_says_of_a_file_that_it_refuses_is_kept_quiet(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """URDF's readers in ROS ask for an effort, and say on stderr that a joint has none."""
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    file = tmp_path / "arm.urdf"
    file.write_text(ARM.replace('effort="9" ', ""))
    read_urdf(file)
    assert "Error" not in capfd.readouterr().err
    os.write(2, b"heard again")
    assert capfd.readouterr().err == "heard again"
