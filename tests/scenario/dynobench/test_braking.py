"""A machine whose speeds are auxiliary states comes to rest like any other."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import kinolab
from kinolab.problem import PlanningTask
from kinolab.steering.nearest_equilibrium import nearest_equilibrium
from kinolab.steering.steering import Steering
from kinolab.steering.stop_maneuver import StopManeuver
from tests.scenario.dynobench.test_environments import written

PLAIN = """\
environment: {min: [0, 0], max: [9, 9]}
robots:
  - {type: unicycle2_v0, start: [1, 2, 0, 0.4, -0.3], goal: [5, 5, 1, 0, 0]}
"""


def plain(folder: Path) -> PlanningTask:
    return kinolab.load(written(folder, PLAIN))


def test_it_can_stay_wherever_it_is(tmp_path: Path) -> None:
    problem = plain(tmp_path)
    assert problem.model.speeds.tolist() == [3, 4]
    found = nearest_equilibrium(problem, problem.start)
    assert found is not None
    np.testing.assert_allclose(found[0], [1, 2, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose(found[1], 0, atol=1e-12)


def test_it_brakes_to_an_exact_stop(tmp_path: Path) -> None:
    """From 0.4 m/s at 0.25 m/s^2: 1.6 s and 0.32 m at least."""
    problem = plain(tmp_path)
    steering = Steering(problem)
    brake = StopManeuver(problem, steering.rollout, steering.closing, steering.tracker)
    stopped = brake.stop(problem.start)
    assert stopped is not None
    assert np.abs(stopped.x[-1, 3:]).max() < 1e-9
    assert len(stopped.u) * problem.step >= 1.6


def test_a_goal_at_rest_stops_it(tmp_path: Path) -> None:
    problem = kinolab.load(written(tmp_path, PLAIN), overrides=["goal={ x = 5, at_rest = true }"])
    named = [problem.model.state_names[i] for i in problem.goal.indices]
    assert sorted(named) == ["v", "w", "x"]
