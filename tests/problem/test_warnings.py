"""What is said before a search about what may be meant otherwise."""

from __future__ import annotations

import pytest

import kinolab
from kinolab.problem.warnings import problem_warnings


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (
            "goal.psi=90",
            ('[goal] psi = 90 is in rad, more than a whole turn; "90 deg" is in degrees.',),
        ),
        (
            "start.psi=-45",
            ('[start] psi = -45 is in rad, more than a whole turn; "-45 deg" is in degrees.',),
        ),
        ('goal.psi="90 deg"', ()),
        ("goal.psi=3", ()),
        ('goal.psi="450 deg"', ()),  # whoever writes this knows
        ("goal.x=9", ()),
    ],
)
def test_angles_that_look_like_degrees(given: str, told: tuple[str, ...]) -> None:
    problem = kinolab.load("rolling_disk_maze", overrides=[given])
    assert problem_warnings(problem) == told
