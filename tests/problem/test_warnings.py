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


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (("goal.tolerance={ x = 0.1, psi_dot = 0.1 }",), ["psi_dot"]),
        (("goal.tolerance={ psi = 0.1, phi = 0.2 }",), ["psi", "phi"]),
        (("goal.tolerance={ x = 0.1, psi_dot = 0.1 }", "goal.at_rest=true"), []),
        (("goal.tolerance={ x = 0.1 }",), []),
    ],
)
def test_a_tolerance_of_what_the_goal_leaves_free(given: tuple[str, ...], told: list[str]) -> None:
    problem = kinolab.load("rolling_disk_maze", overrides=["goal.at_rest=false", *given])
    wanted = [
        f"[goal] tolerance.{name} counts for nothing, since the goal leaves {name} free; "
        f"write {name} = value below [goal]."
        for name in told
    ]
    assert list(problem_warnings(problem)) == wanted
