"""Which bodies of a robot are watched: all that can touch, but for neighbours."""

from __future__ import annotations

from pathlib import Path

import pytest

import kinolab
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import EndpointError, InputError
from kinolab.problem.warnings import problem_warnings
from kinolab.robots import read_mjcf, read_urdf
from tests.support import needs

pytestmark = needs("yourdfpy")

LIMIT = '<limit lower="{}" upper="{}" effort="1" velocity="1"/>'


def link(name: str, at: str = "0 0 0", size: float = 0.1) -> str:
    box = f'<collision><origin xyz="{at}"/><geometry><box size="{size} {size} {size}"/></geometry>'
    moments = 'ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"'
    mass = f'<inertial><mass value="1"/><inertia {moments}/></inertial>'
    return f'<link name="{name}">{mass}{box}</collision></link>'


def joint(parent: str, child: str, at: str, kind: str, low: float, high: float) -> str:
    return (
        f'<joint name="to_{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="1 0 0"/>{LIMIT.format(low, high)}</joint>'
    )


def sliders(folder: Path, low: float, high: float, between: str = "") -> Path:
    """Two boxes of 0.1 m on one rail, 3 m apart, each on a base of its own."""
    path = folder / "sliders.urdf"
    path.write_text(
        '<robot name="sliders">' + link("base", "0 0 -5") + link("a") + link("b")
        + joint("base", "a", "0 0 0", "prismatic", low, high)
        + joint("base", "b", "3 0 0", "prismatic", -0.5, 0.5) + between + "</robot>"
    )  # fmt: skip
    return path


@pytest.mark.parametrize(("high", "meet"), [(2.0, False), (2.41, True), (40.0, True)])
def test_what_meets_within_the_limits_is_watched(high: float, meet: bool, tmp_path: Path) -> None:
    """Faces 2.9 m apart, of which b takes 0.5 m: with 40 m of rail few random positions touch."""
    found = read_urdf(sliders(tmp_path, -high, high)).collisions
    assert (("a", "b") in found) is meet


@pytest.mark.parametrize(("reach", "meet"), [(0.3, False), (1.5, True)])
def test_arms_that_cannot_reach_each_other_are_not(
    reach: float, meet: bool, tmp_path: Path
) -> None:
    """Two arms 3 m apart meet only where both are stretched towards each other."""
    parts = "".join(
        link(name, f"0 0 {reach}")
        + joint("base", name, f"0 {y} 0", "revolute", -3.1, 3.1)
        for name, y in (("a", 0), ("b", 3))
    )  # fmt: skip
    path = tmp_path / "arms.urdf"
    path.write_text(f'<robot name="arms">{link("base", "0 0 -9")}{parts}</robot>')
    assert (("a", "b") in read_urdf(path).collisions) is meet


@pytest.mark.parametrize(("at", "meet"), [(-0.4, True), (0.4, False)])
def test_what_is_locked_is_no_part_of_what_it_hangs_from(
    at: float, meet: bool, tmp_path: Path
) -> None:
    """Faces 2.9 m apart, and 0.4 m less or more; the other one runs for 2.6 m, from the base."""
    found = read_urdf(sliders(tmp_path, -2.6, 2.6), locked={"to_b": at}).collisions
    assert [{*pair} for pair in found] == [{"a", "b"}] * meet


@pytest.mark.parametrize("x", [2.0, 2.8])
def test_a_post_on_a_base_is_no_neighbour_of_what_moves_there(x: float, tmp_path: Path) -> None:
    """A box of 0.1 m runs for 2.6 m towards a post of 0.1 m."""
    path = sliders(tmp_path, -2.6, 2.6)
    text = path.read_text().replace('xyz="3 0 0"', f'xyz="{x} 0 0"')
    path.write_text(text.replace('"to_b" type="prismatic"', '"to_b" type="fixed"'))
    assert [{*pair} for pair in read_urdf(path).collisions] == [{"a", "b"}] * (x < 2.7)


@pytest.mark.parametrize("locked", ["to_a", "to_b"])
def test_neighbours_of_a_locked_joint_stay_neighbours(locked: str, tmp_path: Path) -> None:
    """A chain of three boxes, of which the ends may meet where the last one folds back."""
    path = tmp_path / "chain.urdf"
    path.write_text(
        '<robot name="chain">' + link("base") + link("a") + link("b", "0 0 0.3")
        + joint("base", "a", "0 0 0.2", "revolute", -3.0, 3.0)
        + joint("a", "b", "0 0 0.2", "revolute", -3.0, 3.0) + "</robot>"
    )  # fmt: skip
    assert read_urdf(path, locked={locked: 0.5}).collisions == (("base", "b"),)


def test_an_srdf_says_which_may_touch(tmp_path: Path) -> None:
    path = sliders(tmp_path, -3.0, 3.0)
    assert ("a", "b") in read_urdf(path).collisions
    path.with_suffix(".srdf").write_text(
        '<robot name="sliders"><disable_collisions link1="b" link2="a" reason="Never"/></robot>'
    )
    assert ("a", "b") not in read_urdf(path).collisions


@needs("mujoco")
@pytest.mark.parametrize("locked", [{}, {"Bx": 0.0, "By": 0.0}])
@pytest.mark.parametrize("apart", [0.3, 3.0, 300.0])
def test_two_robots_of_one_file_are_watched(
    apart: float, locked: dict[str, float], tmp_path: Path
) -> None:
    """However far: their joints have no limits. At 0.3 m they touch where they rest."""
    bodies = "".join(
        f'<body name="{name}" pos="{x} 0 0"><joint name="{name}x" type="slide" axis="1 0 0"/>'
        f'<joint name="{name}y" type="slide" axis="0 1 0"/>'
        '<geom type="cylinder" size=".2 .1" mass="2"/></body>'
        for name, x in (("A", 0), ("B", apart))
    )
    (tmp_path / "two.xml").write_text(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")
    (pair,) = read_mjcf(tmp_path / "two.xml", locked=locked).collisions
    assert {*pair} == {"A", "B"}


def told(folder: Path, extra: str = "") -> list[str]:
    """Return what is said of what may touch, of sliders in a scenario."""
    (folder / "s.toml").write_text(
        f'schema = 1\ntitle = "t"\n[system]\nfile = "sliders.urdf"\n{extra}[goal]\nto_a = 0.5\n'
    )
    return [one for one in problem_warnings(kinolab.load(folder / "s.toml")) if "touch" in one]


def test_what_can_touch_unwatched_is_said(tmp_path: Path) -> None:
    """Neighbours always touch, and what is out of reach never does."""
    path = sliders(tmp_path, -1.0, 1.0)
    assert told(tmp_path) == []
    path.write_text(path.read_text().replace('lower="-1.0" upper="1.0"', 'lower="-4" upper="4"'))
    assert told(tmp_path) == []
    said = ["These bodies may touch each other unnoticed: a and b."]
    assert told(tmp_path, "self_collisions = false\n") == said
    path.with_suffix(".srdf").write_text(
        '<robot name="sliders"><disable_collisions link1="b" link2="a"/></robot>'
    )
    assert told(tmp_path) == said


def test_what_touches_at_rest_is_left_out_and_said(tmp_path: Path) -> None:
    path = sliders(tmp_path, -4.0, 4.0)
    path.write_text(path.read_text().replace('xyz="3 0 0"', 'xyz="0.09 0 0"'))
    assert ("a", "b") not in read_urdf(path).collisions
    assert told(tmp_path) == ["These bodies may touch each other unnoticed: a and b."]


def test_what_touches_in_most_positions_is_watched(tmp_path: Path) -> None:
    """A bar of 4 m that turns about its middle, and a box on a rail, which it rarely misses."""
    path = sliders(tmp_path, -1.5, 1.5)
    text = path.read_text().replace(link("b"), link("b", "0 0 0", 4.0))
    path.write_text(text.replace('xyz="3 0 0"', 'xyz="2.2 0 0"'))
    assert ("a", "b") in read_urdf(path).collisions


def test_a_machine_s_file_and_copies_keep_what_is_not_watched(tmp_path: Path) -> None:
    path = sliders(tmp_path, -4.0, 4.0)
    path.write_text(path.read_text().replace('xyz="3 0 0"', 'xyz="0.09 0 0"'))
    system = read_urdf(path)
    assert system.unwatched == (("a", "b"),)
    assert machine_from_json(machine_to_json(system)).unwatched == system.unwatched
    with pytest.raises(InputError, match="unwatched: no body is called 'c'"):
        system.changed(unwatched=[("a", "c")])


def test_an_srdf_may_name_a_link_that_touches_all_but_a_few(tmp_path: Path) -> None:
    """MoveIt's later words; the file may be called like the robot's up to its first point."""
    path = sliders(tmp_path, -3.0, 3.0)
    assert ("a", "b") in read_urdf(path).collisions
    default = '<disable_default_collisions link="a"/>'
    path.with_suffix(".srdf").write_text(f'<robot name="sliders">{default}</robot>')
    assert ("a", "b") not in read_urdf(path).collisions
    path.with_suffix(".srdf").write_text(
        f'<robot name="sliders">{default}<enable_collisions link1="b" link2="a"/></robot>'
    )
    assert ("a", "b") in read_urdf(path).collisions


def test_who_begins_in_an_obstacle_is_told_how_to_make_solids_smaller(tmp_path: Path) -> None:
    """The names of its start and of an obstacle, and what a robot's file can do about it."""
    sliders(tmp_path, -1.0, 1.0)
    crate = {"name": "crate", "box": [0.3, 0.3, 0.3], "position": [3.2, 0.0, 0.0]}
    table = {"file": str(tmp_path / "sliders.urdf")}
    scenario = {"world": {"obstacle": [crate]}, "goal": {"to_a": 0.5}}
    for further, told in (({}, True), ({"convex_parts": 4}, False)):
        problem = kinolab.load({**scenario, "system": {**table, **further}})
        with pytest.raises(EndpointError, match=r"b touches crate\.") as caught:
            problem.check_endpoints()
        assert ("convex_parts = 4 below [system] makes them smaller" in str(caught.value)) is told
