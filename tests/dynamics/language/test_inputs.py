"""Inputs as data, and their mistakes."""

import math
from typing import Any

import pytest

from kinolab.dynamics import (
    WORLD,
    Body,
    Control,
    Drive,
    Force,
    Pull,
    Rate,
    System,
    Torque,
    angle,
    length,
    move,
)
from kinolab.dynamics.language.inputs import bounds_of
from kinolab.errors import InputError

BODY = Body("b", move(length("x")), mass=1)
LIMITS = [0, -1, math.nan, math.inf, (1, 1), (2, 1), (0, math.inf)]


def test_a_limit_is_a_magnitude_or_a_pair() -> None:
    assert bounds_of(Torque("t", on=BODY, about=WORLD.z, limit=2)) == (-2.0, 2.0)
    assert bounds_of(Force("f", on=BODY, along=WORLD.z, limit=(0, 5))) == (0.0, 5.0)


def test_a_rope_only_pulls() -> None:
    rope = Pull("p", between=(WORLD, BODY.frame), limit=3)
    assert bounds_of(rope) == (0.0, 3.0)
    assert bounds_of(Pull("p", between=(WORLD, BODY.frame), limit=(1, 3))) == (1.0, 3.0)


def test_units_are_those_of_what_an_input_is() -> None:
    x, turn = length("x"), angle("turn")
    units = [Rate("r", on=x, limit=1).unit, Rate("r", on=turn, limit=1).unit]
    assert units == ["m/s", "rad/s"]
    assert [Drive("d", on=q, limit=1).unit for q in (x, turn)] == ["m/s^2", "rad/s^2"]
    assert Control("c", limit=1, unit="V").unit == "V"


@pytest.mark.parametrize("limit", LIMITS)
def test_another_limit_is_an_error(limit: Any) -> None:
    with pytest.raises(InputError) as caught:
        System("s", bodies=[BODY], inputs=[Torque("drive", on=BODY, about=WORLD.z, limit=limit)])
    assert str(caught.value) == (
        f"input 'drive': its limit is {limit!r}. "
        "Give a positive magnitude, or (lower, upper), finite."
    )
