"""Machines of other kinds: the search works for them or ends cleanly."""

from __future__ import annotations

from pathlib import Path

import pytest

import kinolab
from tests.support import problem_of

SLIDER = """\
from kinolab.dynamics import Body, Rate, Sphere, System, length, move


def slider():
    x, y = length("x", -5, 5), length("y", -5, 5)
    ball = Body("ball", move(x, y, 0.3), shape=Sphere(0.2))
    return System(
        "slider",
        bodies=[ball],
        inputs=[Rate("east", on=x, limit=1.0), Rate("north", on=y, limit=1.0)],
    )
"""

AROUND = """\
schema = 1
title = "A ball that is moved around a post"
[system]
file = "slider.py:slider"
[world]
bounds = { x = [-4, 4], y = [-4, 4] }
ground = "plane"
[[world.obstacle]]
name = "post"
box = [0.5, 3.0, 1.0]
position = [0, 0, 0.5]
[start]
x = -2.0
[goal]
x = 2.0
y = 0.0
tolerance = 0.1
[planner]
improve = 0
name = "potential_field"
"""


def test_a_kinematic_machine_goes_around_a_post(tmp_path: Path) -> None:
    (tmp_path / "slider.py").write_text(SLIDER, encoding="utf-8")
    found = problem_of(tmp_path, AROUND).solve(seed=1, max_iterations=2000)
    assert found.status == "solved"


@pytest.mark.parametrize("name", ["two_cranes", "rolling_disk_maze"])
def test_other_scenarios_are_solved_too(name: str) -> None:
    """None of these is promised; that they are solved today is worth noticing when it changes."""
    found = kinolab.load(name).solve(
        planner="potential_field", seed=1, time_limit=600.0, optimize=False
    )
    assert found.status == "solved"


@pytest.mark.parametrize("name", ["vehicle_parking", "snakeboard_park", "pendulum_swingup"])
def test_where_nothing_is_found_the_search_ends_cleanly(name: str) -> None:
    found = kinolab.load(name).solve(
        planner="potential_field", seed=1, max_iterations=40, optimize=False
    )
    assert found.status in {"approximate", "not_found", "local_minimum", "solved"}
    assert found.iterations <= 40
