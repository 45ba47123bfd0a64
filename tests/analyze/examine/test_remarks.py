"""Planted mistakes are named in the right words, with their line; right machines get no remark."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import kinolab
import kinolab.analyze.examine
from kinolab import systems
from kinolab.analyze.describe.each_mode import in_each_mode
from kinolab.analyze.examine.behaviour import behaviour
from kinolab.analyze.examine.examination import examine, remarks_on
from kinolab.analyze.examine.remarks.subject import Subject
from kinolab.analyze.examine.shapes.passing_bodies import passing_bodies
from kinolab.dynamics import (
    WORLD,
    Body,
    Cable,
    Disk,
    Force,
    Pull,
    Sphere,
    System,
    Viscous,
    angle,
    length,
    move,
    rate,
    rot_y,
    toward,
)
from kinolab.errors import InputError
from kinolab.scenario.schema import IntegrationSection
from tests.analyze.examine.mistaken import (
    arm,
    ball,
    block,
    cart,
    coin,
    crane,
    post,
    sledge,
    slung,
    turntable,
)
from tests.registered import MAKERS
from tests.support import ROOT

EXAMINE = Path(kinolab.analyze.examine.__file__).parent
SLOW = {"marionette"}  # a minute: 30 bodies, most of which touch each other


def titles(system: System) -> set[str]:
    subject = Subject(system.with_feedback(None))
    return {remark.title for remark in (*remarks_on(subject), *passing_bodies(subject)[1])}


@pytest.mark.parametrize(
    "made", [coin, arm, cart, ball, turntable, slung, crane, sledge, block, post]
)
def test_a_right_machine_gets_no_remark(made: Callable[..., System]) -> None:
    assert titles(made()) == set()


@pytest.mark.parametrize("name", sorted(set(MAKERS) - SLOW))
def test_our_machines_get_no_remark(name: str) -> None:
    """What is only said is at most twelve sentences about each mode."""
    machine = MAKERS[name]()
    assert titles(machine) == set()
    for _, alone in in_each_mode(machine):
        assert len([*behaviour(Subject(alone.with_feedback(None)))]) <= 11  # and one on pairs


@pytest.mark.parametrize(
    ("made", "mistake", "title"),
    [
        (coin, {"without": ("rolling",)}, "no rolling constraint: coin"),
        (coin, {"without": ("no sideslip",)}, "no sideslip constraint: coin"),
        (coin, {"sign": -1}, "rolling with the wrong sign: coin"),
        (coin, {"rolls": 0.4}, "rolling with the wrong radius: coin"),
        (coin, {"along_x": True}, "rolling along the wrong direction: coin"),
        (coin, {"swapped": True}, "touches at rest only: coin and the ground"),
        (coin, {"own_axis": True}, "axis that rolls along: steer"),
        (coin, {"down": "z"}, "gravity points up"),
        (coin, {"down": "x"}, "gravity points aside"),
        (coin, {"g": 981.0}, "gravity of another size"),
        (coin, {"mass": 500.0}, "mass too large: coin"),
        (coin, {"inertia": (50.0, 100.0, 50.0)}, "inertia too large: coin"),
        (coin, {"radius": 0.2}, "size without its parameter: coin"),
        (coin, {"push": 2.0}, "friction that pushes: wrench on body 'coin'"),
        (arm, {"swapped": True}, "touches at rest only: upper and fore"),
        (arm, {"alone": True}, "no reaction: second"),
        (arm, {"turn": 45}, "degrees: fore"),
        (arm, {"limits": (-90, 90)}, "degrees: a"),
        (arm, {"l": 400.0}, "size too large: upper"),
        (arm, {"m": 500.0}, "mass too large: fore"),
        (arm, {"push": 0.1}, "friction that pushes: wrench on body 'fore'"),
        (arm, {"down": "z"}, "gravity points up"),
        (cart, {"free": True}, "no rolling constraint: wheel"),
        (cart, {"way": -1}, "rolling with the wrong sign: wheel"),
        (cart, {"rolls": 0.2}, "rolling with the wrong radius: wheel"),
        (cart, {"radius": 0.1}, "size without its parameter: wheel"),
        (cart, {"alone": True}, "no reaction: slide"),
        (cart, {"inertia": 25.0}, "inertia too large: wheel"),
        (ball, {"free": True}, "no rolling constraint: stone"),
        (ball, {"radius": 0.05}, "size without its parameter: stone"),
        (ball, {"mass": 400.0}, "mass too large: stone"),
        (ball, {"inertia": 4.0}, "inertia too large: stone"),
        (slung, {"swapped": True}, "carried at rest only: load and hull"),
        (crane, {"swapped": True}, "carried at rest only: jib and tower"),
        (post, {"swapped": True}, "touches at rest only: stand and rod"),
        (post, {"lever": 0.6}, "away from its joint: rod and stand"),
        (turntable, {"about": WORLD.y}, "axis of another direction than the joint's: tilt"),
        (turntable, {"along": WORLD.y}, "axis of another direction than the joint's: pull"),
        (turntable, {"reacts": False}, "no reaction: tilt"),
        (turntable, {"sign": -1}, "spring that pushes: s"),
        (turntable, {"sign": -1, "spring": "force"}, "spring that pushes: s"),
        (sledge, {"without": ("towed",)}, "no sideslip constraint: towed"),
        (sledge, {"without": ("board", "towed")}, "no sideslip constraint: board"),
        (sledge, {"stands": False}, "collision with the ground: towed"),
        (block, {"radius": 0.1}, "size without its parameter: ball"),
        (block, {"pairs": 1, "held": False}, "bodies pass through each other"),
    ],
)
def test_a_planted_mistake_is_named(
    made: Callable[..., System], mistake: dict[str, Any], title: str
) -> None:
    assert title in titles(made(**mistake))


def test_a_law_that_pushes_the_wrong_way_is_told_apart_from_one_that_is_too_stiff() -> None:
    for gain, kinds in (
        (1, set()),
        (-1, {"law that pushes the wrong way"}),
        (40, {"law too stiff for its step"}),
    ):
        found = examine(post(gain=gain), IntegrationSection()).remarks
        assert {remark.kind for remark in found} == kinds


def test_a_step_that_nobody_chose_is_advice() -> None:
    """A damper of 0.01 s and the usual step of 0.05 s: rk4 holds up to 2.8 times 0.01 s."""
    x = length("x", speed=1.0)
    body = Body("sledge", move(x, 0, 1), mass=1.0)
    push = Force("push", on=body, along=WORLD.x, limit=1.0)
    stiff = System("s", bodies=[body], inputs=[push], efforts=[Viscous(rate(x), 100.0)])
    usual = examine(stiff, IntegrationSection())
    assert usual.faults == ()
    assert any("choose a step" in sentence for sentence in usual.sentences)
    assert "stable at steps of 0.04 s" in examine(stiff, IntegrationSection(step=0.04)).faults[0]


def test_a_wrong_radius_is_told_beside_the_right_one() -> None:
    (found,) = remarks_on(Subject(coin(rolls=0.4)))
    assert "it rolls as with the radius 0.4 m, and its middle is 0.2 m from where" in found.sentence


@pytest.mark.parametrize("drawn", [True, False])
def test_a_rope_that_may_push_is_named_and_a_muscle_may(drawn: bool) -> None:
    hook = move(0, 0, -length("l", 0.5, 5.0))
    load = Body("load", hook, mass=3.0, shape=Sphere(0.1))
    winch = Pull("winch", between=(WORLD, hook), limit=(-60.0, 60.0))
    cables = [Cable((hook, WORLD), "rope")] if drawn else []
    hoist = System("hoist", bodies=[load], inputs=[winch], gravity=toward("-z"), cables=cables)
    assert titles(hoist) == ({"rope that pushes: winch"} if drawn else set())


def test_what_is_expected_is_left_out_and_what_is_not_there_is_told() -> None:
    wrong = {"without": ("rolling",)}
    for entry in ("no rolling constraint", "no rolling constraint: coin"):
        assert examine(coin(**wrong, expected=[entry])).faults == ()
    vain = examine(coin(expected=["no rolling constraint"]))
    assert vain.faults == ("expected='no rolling constraint' answers to no remark",)
    assert "1 expectation in vain" in vain.verdict


@pytest.mark.parametrize("strength", [-9.81, math.inf])
def test_a_strength_of_gravity_below_zero_is_refused(strength: float) -> None:
    with pytest.raises(InputError) as refused:
        coin(g=strength)
    if strength < 0:
        assert "gravity: its strength is -9.81 m/s^2. Give 0 or more" in str(refused.value)


def test_a_remark_has_its_line_in_the_file(tmp_path: Path) -> None:
    text = Path(systems.maker("rolling_disk").__code__.co_filename).read_text(encoding="utf-8")
    wrong = text.replace("V.x - R * rate(phi)", "V.x + R * rate(phi)")
    (tmp_path / "own.py").write_text(wrong, encoding="utf-8")
    (found,) = kinolab.examine(tmp_path / "own.py").remarks
    line = next(k for k, row in enumerate(wrong.splitlines(), 1) if "+ R * rate(phi)" in row)
    assert found.place == f"own.py, line {line}"
    assert f"(own.py, line {line})" in kinolab.examine(tmp_path / "own.py")._repr_html_()


def test_sentences_say_what_one_can_agree_with() -> None:
    told = examine(cart())
    assert "It has 3 coordinates, 2 degrees of freedom and 2 inputs;" in told.sentences[0]
    assert "Gravity pulls toward -z, down onto the ground z = 0, with 9.81" in told.sentences[1]
    assert any("reacts on hull" in sentence for sentence in told.sentences)
    assert len(told.sentences) <= 12
    assert told.verdict == "cart: nothing to remark, and the laws of mechanics hold."


def test_a_stone_that_is_let_go_falls_as_far_as_galilei_says() -> None:
    """g t^2 / 2 = 1.2 m in half a second."""
    stone = Body("stone", move(0, 0, length("z")), mass=1.0, shape=Sphere(0.05))
    told = examine(System("stone", bodies=[stone], gravity=toward("-z")))
    assert "Let go at rest, in 0.5 s stone falls 1.2 m." in told.sentences


def test_a_machine_is_let_go_where_its_scenario_starts(tmp_path: Path) -> None:
    """A spring of 2 m is as long as its own at z = 2, and pulls it up from 1, where z begins."""
    (tmp_path / "bob.py").write_text(
        "from kinolab.dynamics import *\n\n\ndef bob():\n"
        "    body = Body('bob', move(0, 0, length('z', 1.0, 9.0)), mass=1.0)\n"
        "    spring = Spring(between=(WORLD, body.frame), stiffness=20.0, length=2.0)\n"
        "    return System('bob', bodies=[body], efforts=[spring])\n"
    )
    (tmp_path / "bob.toml").write_text(
        'schema = 1\ntitle = "A bob"\nsystem.file = "bob.py"\nstart.z = 2.5\ngoal.z = 2.0\n'
    )
    alone = kinolab.examine(tmp_path / "bob.py").sentences
    begun = kinolab.examine(tmp_path / "bob.toml").sentences
    assert any(told.startswith("Let go at z = 1, in 0.5 s bob rises") for told in alone)
    assert any(
        told.startswith("Let go at the scenario's start, in 0.5 s bob falls") for told in begun
    )


@pytest.mark.parametrize(
    ("axle", "named"), [("x", True), ("y", False)], ids=["about another axis", "about its axle"]
)
def test_a_round_body_has_like_moments_across_its_axle(axle: str, named: bool) -> None:
    disk = Body(
        "disk",
        move(0, 0, 0.25) @ rot_y(angle("phi")),
        mass=1.0,
        inertia=(0.03125, 0.015625, 0.015625) if axle == "x" else (0.015625, 0.03125, 0.015625),
        shape=Disk(0.25, 0.05, axis="y"),
    )
    found = titles(System("disk", bodies=[disk]))
    assert ("inertia in another order: disk" in found) is named


def test_what_nothing_holds_or_drives_is_named() -> None:
    told = examine(ball(free=True))
    assert "Nothing holds or drives phi: no input, force, constraint or weight." in told.sentences


def test_every_kind_of_remark_is_explained_in_the_manual() -> None:
    code = "".join(path.read_text("utf-8") for path in EXAMINE.rglob("*.py"))
    kinds = {*re.findall(r'Remark\(\s*"([^"]+)"', code), *re.findall(r'ASKEW = "([^"]+)"', code)}
    page = (ROOT / "docs" / "machines.md").read_text("utf-8")
    assert {kind for kind in kinds if f"`{kind}`" not in page} == set()
    assert len(kinds) > 20
