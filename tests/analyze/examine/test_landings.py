"""Where one mode ends and the next begins: signs that differ between a guard and a constraint."""

from __future__ import annotations

import pytest

from kinolab.analyze.examine.shapes.landings import landings
from kinolab.dynamics import (
    Body,
    Mode,
    Pull,
    System,
    Transition,
    closed,
    force_of,
    length,
    move,
    toward,
)
from tests.registered import MAKERS

L = 0.8  # [m] of the leg


def hopper(lands: int = 1, stands: int = 1) -> System:
    """The leg of the page on machines; -1 turns the sign of the guard, or of the foot's place."""
    z, s = length("z", 0.3, 3.0), length("s", -0.5, 0.5)
    body, foot = move(0, 0, z), move(0, 0, z - L - s)
    standing = closed(z - L - stands * s, "foot on the ground")
    return System(
        "hopper",
        bodies=[Body("body", body, mass=8.0), Body("foot", foot, mass=1.0)],
        inputs=[Pull("leg", between=(body, foot), limit=(-200.0, 200.0))],
        gravity=toward("-z"),
        modes=[Mode("stance", constraints=[standing]), Mode("flight")],
        transitions=[
            Transition("lift off", "stance", "flight", until=force_of(standing)),
            Transition("land", "flight", "stance", until=lands * (z - L - s)),
        ],
    )


def test_a_foot_that_lands_where_it_stands_gets_no_remark() -> None:
    assert list(landings(hopper())) == []


def test_a_flight_that_lasts_below_the_ground_is_named() -> None:
    [remark] = landings(hopper(lands=-1))
    assert remark.title == "lasts below the ground: land"
    assert "height of foot" in remark.sentence


def test_a_foot_that_stands_elsewhere_than_it_lands_is_named_with_how_far() -> None:
    """At z = L + s it stands where z = L - s: 2 s apart, up to 1 m."""
    [remark] = landings(hopper(stands=-1))
    assert remark.title == "lands elsewhere: land"
    off = float(remark.sentence.partition("off by up to ")[2].partition(":")[0])
    assert 0.1 < off <= 1.0


@pytest.mark.parametrize("name", sorted(name for name, made in MAKERS.items() if made().modes))
def test_our_machines_land_where_they_stand(name: str) -> None:
    assert list(landings(MAKERS[name]())) == []
