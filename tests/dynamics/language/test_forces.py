"""Gravity as data, and its mistakes."""

from typing import Any

import pytest

from kinolab.dynamics import toward
from kinolab.errors import InputError


@pytest.mark.parametrize(
    ("direction", "down"),
    [("-z", (0, 0, -1)), ("+x", (1, 0, 0)), ("y", (0, 1, 0)), ("-x", (-1, 0, 0))],
)
def test_a_direction_is_a_signed_axis(direction: str, down: Any) -> None:
    field = toward(direction, 3.0)
    assert field.down == down
    assert field.strength == 3.0


@pytest.mark.parametrize("direction", ["down", "-w", "+-z", "xy", "- z", "-", ""])
def test_another_direction_is_an_error(direction: str) -> None:
    with pytest.raises(InputError) as caught:
        toward(direction)
    assert str(caught.value) == (
        f"gravity: {direction!r} is not a direction. "
        "Use x, y or z with an optional sign, such as '-z'."
    )
