"""Planning with velocities of frames as states."""

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.errors import InputError
from tests.dynamics.wheeled import chaplygin_sleigh
from tests.support import problem_of

THROUGH_90_DEGREES = """
schema = 1
title = "A sleigh turns left through heading 90 degrees"
[system]
file = "machine.json"
[world]
bounds = { x = [-3, 3], y = [-3, 3] }
[start]
theta = 1.5707963267948966
V_x = 0.5
[goal]
x = -0.7
y = 1.0
theta = 2.4
tolerance = 0.4
[planner]
name = "rrt_fast"
time_limit = 60.0
max_iterations = 20000
"""


@pytest.fixture(autouse=True)
def machine(tmp_path: Path) -> None:
    (tmp_path / "machine.json").write_text(machine_to_json(chaplygin_sleigh()), encoding="utf-8")


def test_a_sleigh_is_planned_for_from_heading_90_degrees(tmp_path: Path) -> None:
    (tmp_path / "sleigh.toml").write_text(THROUGH_90_DEGREES, encoding="utf-8")
    problem = kinolab.load(tmp_path / "sleigh.toml")
    assert problem.start[3] == 0.5
    plan = problem.solve(seed=1, improve=0.3)  # [s] of work: what is improved moves as truly
    assert plan.status == "solved"
    x = plan.trajectory.x
    forward = np.cos(x[:, 2]) * np.gradient(x[:, 0]) + np.sin(x[:, 2]) * np.gradient(x[:, 1])
    moves = np.abs(x[:, 3]) > 0.1
    assert np.all(np.sign(forward[moves]) == np.sign(x[moves, 3]))  # V_x is the speed forwards


def test_scenarios_name_quasi_velocities_as_any_rate(tmp_path: Path) -> None:
    limits = ["bounds.V_x=[-0.2, 0.6]", "metric.V_x=2.5", "goal.V_x=0.1"]
    problem = problem_of(tmp_path, THROUGH_90_DEGREES, *limits)
    assert problem.bounds[3].tolist() == [-0.2, 0.6]
    assert problem.weights[3] == 2.5
    assert dict(zip(problem.goal.indices, problem.goal.targets, strict=True))[3] == 0.1
    assert problem.rate_bounds[0].tolist() == [-2.0, 2.0]  # x_dot still has its own limit


def test_a_goal_at_rest_asks_quasi_velocities_to_be_zero(tmp_path: Path) -> None:
    goal = problem_of(tmp_path, THROUGH_90_DEGREES, "goal.at_rest=true").goal
    wanted = dict(zip(goal.indices, goal.targets, strict=True))
    assert (wanted[3], wanted[4]) == (0.0, 0.0)


def test_rates_that_are_no_states_name_those_that_are(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        problem_of(tmp_path, THROUGH_90_DEGREES, "start.x_dot=0.5", "goal.V_q=1.0")
    assert "V_q" in str(caught.value)
    assert "Did you mean 'V_x'?" in str(caught.value)
    with pytest.raises(InputError, match="Give one of V_x, theta_dot instead"):
        problem_of(tmp_path, THROUGH_90_DEGREES, "start.x_dot=0.5")
