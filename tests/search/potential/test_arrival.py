"""The last motion into the goal: found by shooting, judged like any other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab.problem import PlanningTask
from kinolab.simulation import Propagator, ZeroOrderHold
from kinolab.steering.goal_connection import GoalConnection
from tests.support import OPEN, WALL, problem_of

Array = NDArray[np.float64]


def arrival(problem: PlanningTask) -> GoalConnection:
    steps = round(2.0 / problem.step)
    return GoalConnection(problem, steps, Propagator(problem), lambda: False)


def in_goal(problem: PlanningTask) -> Array:
    return problem.model.project(problem.sample_goal(np.random.default_rng(0), spread=0.0))


@pytest.mark.parametrize(
    ("name", "shift"),
    [
        ("crane_factory", {"l": -1.0}),
        ("crane_factory", {"l": -0.5, "theta_x": 0.03}),
        ("diffdrive_warehouse", {"x": -0.5}),
        ("diffdrive_warehouse", {"x": -1.2, "y": 0.1}),
        ("submarine_corridor", {"x": -2.0, "y": -0.8}),
    ],
)
def test_from_beside_the_goal_a_motion_ends_in_it(name: str, shift: dict[str, float]) -> None:
    problem = kinolab.load(name)
    x = in_goal(problem)
    x[problem.model.nq :] = 0.0
    for entry, value in shift.items():
        x[problem.model.state_names.index(entry)] += value
    motion = arrival(problem).inputs(x)
    assert motion is not None
    lower, upper = problem.model.control_bounds.T
    for u, reached in motion:
        x = problem.model.step(x, u, problem.step)
        assert reached == pytest.approx(x, abs=1e-9)
        assert (u >= lower).all()
        assert (u <= upper).all()
    assert problem.goal_excess(x) <= 1.0


def test_a_motion_through_a_wall_is_not_taken(tmp_path: Path) -> None:
    """A wall across the whole table, between the coin and a goal 1 m behind it."""
    wall = WALL.replace("4.0, 1.0", "10.0, 1.0")
    problem = problem_of(tmp_path, OPEN + wall, "start.x=2.5", "goal.x=3.5", "goal.tolerance=0.1")
    assert arrival(problem).inputs(problem.start) is None


def test_a_search_that_must_end_does_not_shoot(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN)
    ended = GoalConnection(problem, 20, Propagator(problem), lambda: True)
    assert ended.inputs(problem.start) is None


@pytest.mark.parametrize("name", ["crane_factory", "diffdrive_warehouse", "submarine_corridor"])
def test_goal_residuals_vanish_in_the_middle_of_the_goal_and_are_fractions_of_tolerances(
    name: str,
) -> None:
    """Their largest is the goal's own excess; attitudes are smooth in place of exact: 1 % here."""
    problem, generator = kinolab.load(name), np.random.default_rng(1)
    middle = in_goal(problem)
    assert np.abs(problem.goal_residual(middle)).max() < 1e-6
    for _ in range(20):
        x = problem.sample_goal(generator)
        errors, attitudes = problem.goal_residual(x), problem.goal.parts
        plain = np.abs(errors[: len(problem.goal.indices)]).max()
        turned = max((a.error(x) / a.tolerance for a in attitudes), default=0.0)
        assert max(plain, turned) == pytest.approx(problem.goal_excess(x), rel=1e-9)
        for k, attitude in enumerate(attitudes):
            vector = errors[len(problem.goal.indices) + 3 * k :][:3]
            turn = attitude.error(x) / attitude.tolerance
            assert np.linalg.norm(vector) == pytest.approx(turn, rel=0.01)


def test_a_rollout_is_the_model_s_own_steps(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN)
    x, u = problem.start, np.array([0.7, -0.2])
    end = ZeroOrderHold(problem).end(x, u, 7)
    for _ in range(7):
        x = problem.model.step(x, u, problem.step)
    assert end is not None
    assert end.tobytes() == x.tobytes()
    held = ZeroOrderHold(problem).end_of(problem.start, np.array([u, -u]), 3)
    x = problem.start
    for row in (u, -u):
        for _ in range(3):
            x = problem.model.step(x, row, problem.step)
    assert held is not None
    assert held.tobytes() == x.tobytes()
