"""Whatever goes wrong between a robot's file and its machine is refused, and names a joint."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from kinolab.errors import InputError
from kinolab.robots import read_mjcf, read_urdf
from kinolab.robots.compared import disagreements, urdf_engines
from kinolab.robots.compared.second_engine import AbstractSecondEngine
from kinolab.robots.machine import robot_machine
from kinolab.robots.mjcf import compiled_model, mjcf_file
from kinolab.robots.tree.constant_frames import turned_about
from kinolab.robots.tree.kinematic_tree import KinematicTree, Mimicked, pose_of
from kinolab.robots.urdf import urdf_file
from tests.support import needs

pytestmark = [needs("mujoco"), needs("yourdfpy")]

Change = Callable[[KinematicTree], KinematicTree]

HEAD = """<mujoco><compiler angle="radian"/><option gravity="0.3 -0.2 -9.81"/><worldbody>"""
TREE = f"""{HEAD}
  <body name="post" pos="0 0 1" euler="0.3 0.2 0.1">
    <joint name="socket" type="ball" pos="0 0.02 0.4" damping="0.3" armature="0.02"/>
    <inertial pos="0.1 0 0.2" mass="2" fullinertia="0.3 0.2 0.25 0.02 -0.03 0.04"/>
    <body name="arm" pos="0.1 0 -0.4" quat="1 0.3 0.2 0.1">
      <joint name="turn" axis="1 2 3" pos="0.1 0 0.05" armature="0.3" ref="0.2" damping="0.4"/>
      <joint name="push" type="slide" axis="0 1 1" armature="0.2" stiffness="30 2"
             springref="0.1" damping="0.7 0.2" frictionloss="3"/>
      <inertial pos="0 0.1 0" mass="0.7" fullinertia="0.01 0.02 0.015 0.001 0.002 -0.001"/>
      <body name="lid" pos="0 0 0.3" quat="1 0.2 0 0"><geom size="0.1" mass="0.3"/></body>
    </body>
  </body>
  </worldbody>
  <actuator><motor joint="turn" ctrlrange="-1 1"/></actuator>
</mujoco>"""
FREE = f"""{HEAD}
  <body name="ball"><joint name="free" type="free"/>
    <inertial pos="0.1 0 0.2" mass="2" fullinertia="0.3 0.2 0.25 0.02 -0.03 0.04"/></body>
  </worldbody></mujoco>"""
PAIR = f"""{HEAD}
  <body name="a"><joint name="a" axis="0 0 1" limited="true" range="-1 1"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 0.5"/></body>
  <body name="b" pos="1 0 0"><joint name="b" axis="0 0 1" ref="0.3"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 0.5"/></body>
  </worldbody>
  <equality><joint joint1="b" joint2="a" polycoef="0.1 -0.5 0 0 0"/></equality></mujoco>"""
LOOP = f"""{HEAD}
  <body name="crank"><joint name="crank" axis="0 0 1"/>
    <geom type="capsule" fromto="0 0 0 0 0.2 0" size="0.02" mass="0.4"/>
    <body name="coupler" pos="0 0.2 0"><joint name="coupler" axis="0 0 1"/>
      <geom type="capsule" fromto="0 0 0 0.6 0.2 0" size="0.02" mass="0.8"/></body></body>
  <body name="rocker" pos="0.5 0 0"><joint name="rocker" axis="0 0 1"/>
    <geom type="capsule" fromto="0 0 0 0.1 0.4 0" size="0.02" mass="0.6"/></body>
  </worldbody>
  <equality><connect name="pin" body1="coupler" body2="rocker" anchor="0.6 0.2 0"/></equality>
</mujoco>"""


def joint(name: str, **changed: Any) -> Change:
    """Return a change of a joint; functions are of its own value."""

    def change(tree: KinematicTree) -> KinematicTree:
        (own,) = (one for one in tree.joints if one.name == name)
        new = {key: v(getattr(own, key)) if callable(v) else v for key, v in changed.items()}
        new = replace(own, **new)
        return replace(tree, joints=tuple(new if one is own else one for one in tree.joints))

    return change


def link(name: str, **changed: Callable[[Any], Any]) -> Change:
    """Return a change of a link's mass properties."""

    def change(tree: KinematicTree) -> KinematicTree:
        (own,) = (one for one in tree.links if one.name == name)
        new = {key: v(getattr(own.inertial, key)) for key, v in changed.items()}
        new = replace(own, inertial=replace(own.inertial, **new))
        return replace(tree, links=tuple(new if one is own else one for one in tree.links))

    return change


def closure(**changed: Any) -> Change:
    return lambda tree: replace(tree, closures=(replace(tree.closures[0], **changed),))


SLIGHTLY = turned_about(np.array([1.0, 0.0, 0.0]), 1e-6)


def otherwise(inertia: Any) -> Any:
    """Return an inertia about axes that are turned slightly."""
    return SLIGHTLY @ inertia @ SLIGHTLY.T


def loosely(inertia: Any) -> Any:
    """Return an inertia without its products."""
    return np.diag(np.diag(inertia))


LEVEL, NONE = (0.0, 0.0, -9.81), (0.0, 0.0, 0.0)
BESIDE = pose_of(np.array([0.6, 0.2 + 1e-5, 0.0]), np.eye(3))
# What goes wrong with a file, and joints of which one is named.
MISTAKES: Mapping[str, tuple[str, Change, str]] = {
    "armature": (TREE, joint("turn", armature=0.0), "turn"),
    "armature of a slide": (TREE, joint("push", armature=0.2001), "push"),
    "armature of a ball joint": (TREE, joint("socket", armature=0.0), "socket"),
    "damping": (TREE, joint("turn", damping=0.0), "turn"),
    "damping of a ball joint": (TREE, joint("socket", damping=0.31), "socket"),
    "a power of damping": (TREE, joint("push", higher_damping=()), "push"),
    "stiffness": (TREE, joint("push", stiffness=0.0), "push"),
    "a power of stiffness": (TREE, joint("push", higher_stiffness=()), "push"),
    "a spring's rest": (TREE, joint("push", rest=0.0), "push"),
    "an axis's sign": (TREE, joint("turn", axis=np.negative), "turn|push|socket"),
    "an axis": (TREE, joint("push", axis=lambda axis: SLIGHTLY @ axis), "push|socket"),
    "an anchor": (TREE, joint("turn", anchor=lambda anchor: anchor + 1e-6), "turn|push"),
    "a ball joint's anchor": (TREE, joint("socket", anchor=np.zeros(3)), "socket"),
    "where a joint is zero": (TREE, joint("turn", zero=0.0), "turn|push|socket"),
    "a pose": (TREE, joint("push", pose=pose_of(np.zeros(3), SLIGHTLY)), "turn|push|socket"),
    "a fixed joint's pose": (TREE, joint("lid fixed", pose=np.eye(4)), "turn|push|socket"),
    "a joint": (TREE, joint("turn", kind="fixed"), "turn"),
    "a mass": (TREE, link("arm", mass=lambda mass: mass * (1 + 1e-6)), "turn|push|socket"),
    "an inertia's axes": (TREE, link("arm", inertia=otherwise), "turn|push|socket"),
    "gravity's direction": (TREE, lambda tree: replace(tree, gravity=LEVEL), "push|socket|turn"),
    "no gravity": (FREE, lambda tree: replace(tree, gravity=NONE), "free"),
    "a centre of mass": (FREE, link("ball", centre=np.negative), "free"),
    "an inertia of what is free": (FREE, link("ball", inertia=loosely), "free"),
    "a follower's factor": (PAIR, joint("b", mimics=Mimicked("a", 0.5, 0.4)), "a|b"),
    "a follower's offset": (PAIR, joint("b", mimics=Mimicked("a", -0.5, 0.1)), "a|b"),
    "a follower's leader": (PAIR, joint("b", mimics=None), "a|b"),
    "a loop's anchor": (LOOP, closure(first_pose=BESIDE), "crank|coupler|rocker"),
    "a loop": (LOOP, lambda tree: replace(tree, closures=()), "crank|coupler|rocker"),
    "what a loop holds": (LOOP, closure(kind="pose"), "crank|coupler|rocker"),
}


@pytest.fixture(autouse=True)
def nothing_is_known_yet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor does anything become known: entries cannot be kept in a file."""
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "file"))


def written(tmp_path: Path, text: str, name: str = "robot.xml") -> Path:
    file = tmp_path / name
    file.write_text(text)
    return file


def read_wrongly(monkeypatch: pytest.MonkeyPatch, module: Any, change: Change) -> None:
    """Let a reader make a tree with a mistake."""
    right = module.assembled
    monkeypatch.setattr(module, "assembled", lambda tree, **given: right(change(tree), **given))


@pytest.mark.parametrize("what", MISTAKES)
def test_a_mistake_of_the_reader_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    text, change, named = MISTAKES[what]
    read_wrongly(monkeypatch, mjcf_file, change)
    with pytest.raises(InputError, match=rf"^robot.xml joint '({named})': .* report it") as caught:
        read_mjcf(written(tmp_path, text), shapes=False)
    assert len(caught.value.mistakes) == 1
    assert caught.value.exit_code == 2


@pytest.mark.parametrize("text", [TREE, FREE, PAIR, LOOP])
def test_what_is_read_as_it_stands_is_not_refused(tmp_path: Path, text: str) -> None:
    """Dry friction, limits and actuators have no part in it."""
    assert read_mjcf(written(tmp_path, text))


def test_the_message_has_both_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    read_wrongly(monkeypatch, mjcf_file, lambda tree: replace(tree, gravity=NONE))
    with pytest.raises(InputError) as caught:
        read_mjcf(written(tmp_path, FREE), shapes=False)
    assert re.search(r"in SI units, \S+ in MuJoCo, and \S+ in kinolab\.", str(caught.value))


def not_at_all(*_: Any) -> Any:
    """Return nothing for whatever."""


ASSEMBLED: Mapping[str, tuple[str, Any, str]] = {
    "products of inertia": ("six", lambda inertia: (*np.diag(inertia).tolist(), 0, 0, 0), ".*"),
    "a turn": ("along_an_axis", lambda _: ("z", 1.0), ".*"),
    "gravity": ("_gravity", not_at_all, ".*"),
}


@pytest.mark.parametrize("what", ASSEMBLED)
def test_a_mistake_of_the_assembly_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, what: str
) -> None:
    function, wrong, named = ASSEMBLED[what]
    monkeypatch.setattr(robot_machine, function, wrong)
    with pytest.raises(InputError, match=rf"joint '({named})': .* report it"):
        read_mjcf(written(tmp_path, TREE), shapes=False)


def test_a_locked_joint_must_be_where_it_is_locked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = written(tmp_path, TREE)
    assert len(read_mjcf(file, shapes=False, locked={"turn": 0.7}).coordinates) == 2
    right = robot_machine.moved_to
    monkeypatch.setattr(robot_machine, "moved_to", lambda one, at: right(one, at + 1e-6))
    with pytest.raises(InputError, match=r"joint '(push|socket)': .* report it"):
        read_mjcf(file, shapes=False, locked={"turn": 0.7})


@pytest.mark.parametrize("flag", ["gravity", "damper", "spring"])
def test_a_flag_that_is_not_applied_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, flag: str
) -> None:
    """What it disables is nothing in MuJoCo itself, whatever kinolab makes of it."""
    flags = f'<option><flag {flag}="disable"/></option><worldbody>'
    file = written(tmp_path, TREE.replace("<worldbody>", flags))
    read_mjcf(file, shapes=False)
    monkeypatch.setattr(compiled_model, "apply_flags", not_at_all)
    with pytest.raises(InputError, match="report it"):
        read_mjcf(file, shapes=False)


def test_what_is_left_out_on_demand_is_not_compared(tmp_path: Path) -> None:
    """A fluid slows MuJoCo's model down, not the machine."""
    text = TREE.replace("<option ", '<option density="1000" ')
    assert read_mjcf(written(tmp_path, text), partial=True, shapes=False)


ARM = """<robot name="arm">
  <link name="base"><inertial><mass value="3"/><origin xyz="0 0 0.1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="upper">
    <visual><geometry><mesh filename="package://nowhere/upper.stl"/></geometry></visual>
    <inertial><mass value="1.5"/><origin xyz="0 0.1 0.2" rpy="0.1 0.2 0.3"/>
      <inertia ixx="0.02" iyy="0.03" izz="0.025" ixy="0.001" ixz="0"
      iyz="-0.002"/></inertial></link>
  <link name="wrist"/>
  <link name="hand"><inertial><mass value="0.4"/>
    <inertia ixx="0.001" iyy="0.001" izz="{izz}" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="finger"><inertial><mass value="0.1"/><origin xyz="0 0.1 0"/>
    <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.2" rpy="0.4 0 0"/><axis xyz="0 1 1"/><dynamics damping="0.3" friction="2"/>
    <limit lower="-1" upper="1" effort="5" velocity="2"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="wrist"/>
    <origin xyz="0 0 0.4" rpy="0 0.3 0"/><axis xyz="1 0 0"/></joint>
  <joint name="roll" type="continuous"><parent link="wrist"/><child link="hand"/>
    <axis xyz="0 0 1"/></joint>
  <joint name="grip" type="prismatic"><parent link="hand"/><child link="finger"/>
    <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="5" velocity="2"/>
    <mimic joint="roll" multiplier="0.02" offset="0.01"/></joint>
</robot>"""
OF_URDF: Mapping[str, tuple[Change, str]] = {
    "damping": (joint("shoulder", damping=0.0), "shoulder"),
    "an axis's sign": (joint("elbow", axis=np.negative), "elbow|roll"),
    "a pose": (joint("elbow", pose=np.eye(4)), "shoulder|elbow|roll"),
    "an inertia's axes": (link("upper", inertia=otherwise), "shoulder"),
    "a mass": (link("hand", mass=lambda mass: 2 * mass), "shoulder|elbow|roll"),
    "gravity": (lambda tree: replace(tree, gravity=(0.0, 0.0, -9.8)), ".*"),
}


@pytest.mark.parametrize("base", ["fixed", "floating"])
@pytest.mark.parametrize("what", OF_URDF)
@pytest.mark.parametrize("engine", ["MuJoCo", "Pinocchio"])
def test_a_mistake_with_a_urdf_file_is_refused_by_either_engine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, engine: str, what: str, base: Any
) -> None:
    """Meshes that are not there have no part in it, nor has a link without mass."""
    lacking = {"MuJoCo": "pinocchio", "Pinocchio": "mujoco"}
    if engine == "Pinocchio":
        pytest.importorskip("pinocchio", exc_type=ImportError)
    right = urdf_engines._library
    monkeypatch.setattr(
        urdf_engines, "_library", lambda name: None if name == lacking[engine] else right(name)
    )
    file = written(tmp_path, ARM.format(izz=0.001), "arm.urdf")
    read_urdf(file, base=base, shapes=False)
    change, named = OF_URDF[what]
    read_wrongly(monkeypatch, urdf_file, change)
    with pytest.raises(InputError, match=rf"^arm.urdf joint '({named}|base)': .*{engine}"):
        read_urdf(file, base=base, shapes=False)


def test_a_follower_of_a_urdf_file_is_compared(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read_wrongly(monkeypatch, urdf_file, joint("grip", mimics=Mimicked("roll", 0.03, 0.01)))
    with pytest.raises(InputError, match=r"joint '(grip|roll)'"):
        read_urdf(written(tmp_path, ARM.format(izz=0.001), "arm.urdf"), shapes=False)


def test_a_file_that_mujoco_refuses_is_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A moment of inertia larger than the sum of the others; a package of tests is no engine."""
    monkeypatch.setitem(sys.modules, "pinocchio", ModuleType("pinocchio"))
    file = written(tmp_path, ARM.format(izz=0.002000000001), "arm.urdf")
    assert read_urdf(file, shapes=False)


def test_inertia_that_is_taken_for_rounding_is_no_difference(tmp_path: Path) -> None:
    """It is 0.1 of what resists the joint, and less than a file's digits are worth."""
    text = """<mujoco><worldbody><body name="hub"><joint name="spin" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="1e-11 1e-11 1e-11"/>
      <body name="tip"><joint name="tip" axis="1 0 0"/>
        <inertial pos="0 1e-5 0" mass="1" diaginertia="1e-9 1e-9 1e-9"/></body></body>
      </worldbody></mujoco>"""
    assert read_mjcf(written(tmp_path, text), shapes=False)


def test_engines_are_asked_once_of_the_same_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And again of another file, pose, base or engine, and of one that was refused."""
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    asked: list[str] = []
    right = urdf_file.urdf_engines

    def asking(*args: Any, **options: Any) -> Iterator[AbstractSecondEngine]:
        asked.append("")
        yield from right(*args, **options)

    monkeypatch.setattr(urdf_file, "urdf_engines", asking)

    def times_asked(izz: float = 0.001, **options: Any) -> int:
        asked.clear()
        read_urdf(written(tmp_path, ARM.format(izz=izz), "arm.urdf"), shapes=False, **options)
        return len(asked)

    assert [times_asked(), times_asked()] == [1, 0]
    assert [times_asked(izz=0.0011), times_asked(locked={"elbow": 0.1})] == [1, 1]
    assert [times_asked(base="floating"), times_asked(locked={"elbow": 0.1})] == [1, 0]
    monkeypatch.setattr(disagreements, "versions_of", lambda *_: {"mujoco": "0"})
    assert times_asked() == 1
    read_wrongly(monkeypatch, urdf_file, joint("elbow", axis=np.negative))
    for _ in range(2):
        with pytest.raises(InputError, match=r"elbow|roll"):
            times_asked(izz=0.0012)


def test_what_mujoco_compiles_is_the_content_of_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file that another one includes, too."""
    monkeypatch.setenv("KINOLAB_CACHE", str(tmp_path / "cache"))
    part, whole = tmp_path / "part.xml", tmp_path / "robot.xml"
    whole.write_text('<mujoco><include file="part.xml"/></mujoco>')
    part.write_text(FREE.replace("mujoco>", "mujocoinclude>"))
    assert read_mjcf(whole, shapes=False)
    read_wrongly(monkeypatch, mjcf_file, lambda tree: replace(tree, gravity=NONE))
    assert read_mjcf(whole, shapes=False)  # what is wrong now was not when it was compared
    part.write_text(part.read_text().replace('mass="2"', 'mass="2.1"'))
    with pytest.raises(InputError, match="joint 'free'"):
        read_mjcf(whole, shapes=False)
