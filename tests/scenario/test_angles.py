"""Angles that a scenario writes as text."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.scenario import load_scenario, write_scenario
from kinolab.scenario.angles import angle_of
from tests.support import problem_of, within

SWING = """\
schema = 1
title = "A pendulum swings up"
[system]
name = "pendulum"
[goal]
theta = "pi"
theta_dot = 0.0
[planner]
improve = 0
"""


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("pi", math.pi),
        ("-pi/2", -math.pi / 2),
        ("+ 3 pi / 4", 3 * math.pi / 4),
        ("3/4 pi", 3 * math.pi / 4),
        ("2*pi", 2 * math.pi),
        ("π/6", math.pi / 6),
        ("0.5pi rad", math.pi / 2),
        ("180 deg", math.pi),
        ("-90°", -math.pi / 2),
        ("45 degrees", math.pi / 4),
        ("1.5 rad", 1.5),
        ("1e1 deg", math.pi / 18),
        ("360 deg/s", 2 * math.pi),
    ],
)
def test_an_angle_is_read_as_a_textbook_writes_it(text: str, value: float) -> None:
    angle = angle_of(text)
    assert angle is not None
    assert float(angle) == pytest.approx(value, rel=1e-15)  # rounding of one division


@pytest.mark.parametrize(
    "text", ["", "pie", "1.5", "-2", "pi deg", "pi/0", "deg", "1/0 deg", "1e999 deg", "pi/2 + 1",
             "pi/s", "2 m", "nan deg"]
)  # fmt: skip
def test_what_is_no_angle_is_none(text: str) -> None:
    assert angle_of(text) is None


def test_blanks_after_a_number_take_no_time() -> None:
    """Tried in all ways in which n blanks fall into six places, these would take years."""
    with within(20):
        assert angle_of("1" + " " * 100_000 + "x") is None
        assert angle_of("1" * 100_000 + "x") is None


def test_start_goal_tolerances_and_limits_take_angles(tmp_path: Path) -> None:
    text = SWING.replace("theta_dot", 'tolerance = { theta = "2 deg" }\ntheta_dot') + (
        '[start]\ntheta = "-90 deg"\ntheta_dot = "10 deg/s"\n[bounds]\ntheta = ["-pi", "2 pi"]\n'
    )
    problem = problem_of(tmp_path, text)
    assert problem.start.tolist() == [-math.pi / 2, math.radians(10)]
    assert problem.goal.targets.tolist() == [math.pi, 0.0]
    assert problem.goal.tolerances[0] == math.radians(2)
    assert problem.bounds[0].tolist() == [-math.pi, 2 * math.pi]


@pytest.mark.parametrize(
    ("override", "value"),
    [("goal.theta=pi/2", math.pi / 2), ("goal.theta=90 deg", math.pi / 2), ("goal.theta=1", 1.0)],
)
def test_an_override_takes_angles(override: str, value: float, tmp_path: Path) -> None:
    assert problem_of(tmp_path, SWING, override).goal.targets[0] == value


def test_an_override_takes_limits_with_angles(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, SWING, "bounds.theta=[-pi/2, 7]")
    assert problem.bounds[0].tolist() == [-math.pi / 2, 7.0]


def test_a_scenario_with_angles_is_written_with_every_digit(tmp_path: Path) -> None:
    problem: PlanningTask = problem_of(tmp_path, SWING)
    (tmp_path / "again.toml").write_text(write_scenario(problem.scenario), encoding="utf-8")
    assert load_scenario(tmp_path / "again.toml") == problem.scenario


@pytest.mark.parametrize(
    ("override", "answer"),
    [
        ("goal.theta=pie", '"pie" is text, not a number. Give a number, an angle such as "pi/2"'),
        ("bounds.theta=['-pie', 'pi']", 'entry 1, "-pie", is text, not a number. Give [low, high]'),
        ("bounds.theta=[-pie, pi]", "[-pie, pi] is not a TOML value."),
        ("goal.theta_dot=90 deg", '"90 deg" is an angle, but theta_dot is in rad/s. Give a number'),
        ("goal.theta=90 deg/s", '"90 deg/s" is a rate, but theta is in rad. Give a number [rad].'),
        (
            "bounds.torque=[-pi, pi]",
            '"-pi" is an angle, but torque is in N m. Give a number [N m].',
        ),
        ("system.parameters.m=pi", '"pi" is text, not a number. Give a number.'),
        ("world.bounds.x=[-pi, pi]", "is text, not a number."),
        ("goal.tolerance=5 deg", "is text, not a number. Give a number of at least 1e-12"),
    ],
)
def test_what_is_no_angle_there_is_said(override: str, answer: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        problem_of(tmp_path, SWING, override)
    first = caught.value.mistakes[0]
    assert str(first).startswith(f"--set {override}: ")
    assert answer in str(first)


def test_a_length_is_no_angle(tmp_path: Path) -> None:
    text = SWING.replace("pendulum", "rolling_disk").replace("theta_dot = 0.0", "")
    with pytest.raises(InputError, match=r'\[start\] x: "pi" is an angle, but x is in m\.'):
        problem_of(tmp_path, text.replace("theta", "psi") + '[start]\nx = "pi"\n')
