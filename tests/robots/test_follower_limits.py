"""Limits of joints that follow others bind their leaders, in both formats alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import System
from kinolab.errors import EndpointError, InputError
from kinolab.robots import read_mjcf, read_urdf

pytest.importorskip("mujoco")
pytest.importorskip("yourdfpy")
INF = math.inf


class Hinge(NamedTuple):
    """A hinge of a robot whose links hang from the world.

    Attributes:
        name: Its name.
        limits: Of its position in [rad], if it has any.
        follows: The name of a joint, factor and offset, if it follows one.
        speed: Limit of its rate in [rad/s]; URDF alone has one.
    """

    name: str
    limits: tuple[float, float] | None = None
    follows: tuple[str, float, float] | None = None
    speed: float = 0.0


def from_mjcf(
    folder: Path, hinges: list[Hinge], locked: Mapping[str, float] | None = None
) -> System:
    """Return a robot by way of MJCF."""
    bodies, equations = "", ""
    for k, one in enumerate(hinges):
        limits = "" if one.limits is None else 'range="{} {}"'.format(*one.limits)
        bodies += f"""<body pos="{k} 0 1"><joint name="{one.name}" axis="0 0 1" {limits}/>
          <geom type="box" size="0.2 0.02 0.02" mass="1"/></body>"""
        if one.follows is not None:
            leader, factor, offset = one.follows
            equations += f"""<joint joint1="{one.name}" joint2="{leader}"
              polycoef="{offset} {factor} 0 0 0"/>"""
    (folder / "robot.xml").write_text(f"""<mujoco><compiler angle="radian"/>
      <worldbody>{bodies}</worldbody><equality>{equations}</equality>
      <actuator><motor name="m" joint="{hinges[0].name}" ctrlrange="-5 5"/></actuator></mujoco>""")
    return read_mjcf(folder / "robot.xml", locked=locked)


def from_urdf(
    folder: Path, hinges: list[Hinge], locked: Mapping[str, float] | None = None
) -> System:
    """Return a robot by way of URDF."""
    parts = '<link name="base"/>'
    for one in hinges:
        limits = "" if one.limits is None else 'lower="{}" upper="{}"'.format(*one.limits)
        mimic = (
            ""
            if one.follows is None
            else ('<mimic joint="{}" multiplier="{}" offset="{}"/>'.format(*one.follows))
        )
        kind = "continuous" if one.limits is None else "revolute"
        parts += f"""<link name="{one.name} link"><inertial><mass value="1"/>
          <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
          <joint name="{one.name}" type="{kind}"><parent link="base"/>
          <child link="{one.name} link"/><axis xyz="0 0 1"/>
          <limit effort="5" velocity="{one.speed}" {limits}/>{mimic}</joint>"""
    (folder / "robot.urdf").write_text(f'<robot name="robot">{parts}</robot>')
    return read_urdf(folder / "robot.urdf", locked=locked)


READERS = [from_mjcf, from_urdf]
Reader = Callable[..., System]


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize(
    ("own", "followers", "expected"),
    [
        ((-2, 2), [Hinge("b", (0, 0.5), ("a", 1, 0))], (0, 0.5)),
        (None, [Hinge("b", (0, 0.5), ("a", 1, 0))], (0, 0.5)),
        ((-2, 2), [Hinge("b", (0, 0.5), ("a", -2, 0))], (-0.25, 0)),
        ((-2, 2), [Hinge("b", (-1, 1), ("a", 2, 0.5))], (-0.75, 0.25)),
        ((-2, 2), [Hinge("b", (-9, 9), ("a", 2, 0))], (-2, 2)),
        ((-2, 2), [Hinge("b", (-9, 9), ("a", 0, 0.5))], (-2, 2)),
        ((-2, 2), [Hinge("b", (-1, 1), ("a", 1, 0)), Hinge("c", (-1, 1), ("a", 4, 1))], (-0.5, 0)),
        # c = -2 (a + 0.5) + 1 = -2 a within -1 and 3
        ((-2, 2), [Hinge("b", (-9, 9), ("a", 1, 0.5)), Hinge("c", (-1, 3), ("b", -2, 1))],
         (-1.5, 0.5)),
    ],
)  # fmt: skip
def test_limits_of_followers_bind_their_leader(
    tmp_path: Path,
    read: Reader,
    own: tuple[float, float] | None,
    followers: list[Hinge],
    expected: tuple[float, float],
) -> None:
    (leader,) = read(tmp_path, [Hinge("a", own), *followers]).coordinates
    assert np.allclose([leader.lower, leader.upper], expected, rtol=1e-15, atol=0.0)


def test_speeds_of_followers_bind_their_leader(tmp_path: Path) -> None:
    """The first turns -4 times as fast, at 2 rad/s at most; the second half as fast as that."""
    first = Hinge("b", (-9, 9), ("a", -4, 1), speed=2.0)
    second = Hinge("c", (-9, 9), ("b", 0.5, 0), speed=0.5)
    (leader,) = from_urdf(tmp_path, [Hinge("a", (-2, 2), speed=3.0), first]).coordinates
    assert leader.speed == 0.5
    (leader,) = from_urdf(tmp_path, [Hinge("a", (-2, 2), speed=3.0), first, second]).coordinates
    assert leader.speed == 0.25


@pytest.mark.parametrize("read", READERS)
def test_a_leader_whose_follower_cannot_move_stays(tmp_path: Path, read: Reader) -> None:
    """Only where b = 2 a is 0.6 is a left, at 0.3, beside d, which moves."""
    b = Hinge("b", (0.6, 0.60000001), ("a", 2, 0))
    system = read(tmp_path, [Hinge("d"), Hinge("a", (-1, 1)), b])
    a = next(entry for entry in system.coordinates if entry.name == "a")
    assert np.allclose([a.lower, a.upper], 0.3, atol=1e-8)


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize(
    "followers",
    [
        [Hinge("b", (3, 4), ("a", 1, 0))],
        [Hinge("b", (0.5, 1), ("a", 1, 0)), Hinge("c", (0.5, 1), ("a", -1, 0))],
        [Hinge("b", (1, 2), ("a", 0, 0.5))],
    ],
)
def test_limits_that_exclude_each_other_are_named(
    tmp_path: Path, read: Reader, followers: list[Hinge]
) -> None:
    names = ", ".join(entry.name for entry in followers)
    with pytest.raises(InputError, match=f"joint 'a': its limits and those of {names}, which"):
        read(tmp_path, [Hinge("a", (-2, 2)), *followers])


@pytest.mark.parametrize("read", READERS)
def test_a_follower_is_locked_with_its_leader_alone(tmp_path: Path, read: Reader) -> None:
    hinges = [Hinge("d"), Hinge("a", (-2, 2)), Hinge("b", (-9, 9), ("a", 2, 0))]
    assert [c.name for c in read(tmp_path, hinges, {"a": 0.3}).coordinates] == ["d"]
    with pytest.raises(InputError, match=r"locked b: it follows a, .* Lock a\."):
        read(tmp_path, hinges, {"b": 0.6})


@pytest.mark.parametrize("read", READERS)
@pytest.mark.parametrize(
    ("followers", "at", "said"),
    [
        ([], 2.5, r"2\.5 is beyond its limits, -2\.0 to 2\.0\. Lock it within them\."),
        ([], -2.0000001, r"-2\.0000001 is beyond its limits, -2\.0 to 2\.0\."),
        ([Hinge("b", (-1, 1), ("a", 2, 0))], 0.6,
         r"0\.6 is beyond its limits, -0\.5 to 0\.5, those of b included\."),
    ],
)  # fmt: skip
def test_a_joint_is_locked_within_its_limits(
    tmp_path: Path, read: Reader, followers: list[Hinge], at: float, said: str
) -> None:
    hinges = [Hinge("d"), Hinge("a", (-2, 2)), *followers]
    with pytest.raises(InputError, match=rf"robot\.\w+ locked a: {said}"):
        read(tmp_path, hinges, {"a": at})
    for within in (-0.5, 0.5) if followers else (-2.0, 2.0):
        assert [c.name for c in read(tmp_path, hinges, {"a": within}).coordinates] == ["d"]


def test_a_scenario_that_locks_a_joint_beyond_its_limits_is_refused(tmp_path: Path) -> None:
    from_mjcf(tmp_path, [Hinge("d"), Hinge("a", (-2, 2))])
    (tmp_path / "turn.toml").write_text(
        'schema = 1\ntitle = "A turn"\n[system]\nfile = "robot.xml"\nlocked = { a = 2.5 }\n'
        "[goal]\nd = 1.5\n[bounds]\nd_dot = [-2, 2]\n"
    )
    with pytest.raises(InputError, match=r"locked a: 2\.5 is beyond its limits, -2\.0 to 2\.0"):
        kinolab.load(tmp_path / "turn.toml")


def test_a_goal_beyond_a_follower_s_limit_is_refused(tmp_path: Path) -> None:
    from_mjcf(tmp_path, [Hinge("a", (-2, 2)), Hinge("b", (0, 0.5), ("a", 1, 0))])
    (tmp_path / "turn.toml").write_text(
        'schema = 1\ntitle = "A turn"\n[system]\nfile = "robot.xml"\n[goal]\na = 1.5\n'
        "[bounds]\na_dot = [-2, 2]\n"
    )
    with pytest.raises((InputError, EndpointError), match=r"1\.5, outside 0 to 0\.5"):
        kinolab.load(tmp_path / "turn.toml").solve(seed=1, time_limit=1.0)
