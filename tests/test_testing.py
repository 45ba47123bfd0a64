"""The assertions that kinolab offers for tests of one's own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from kinolab.scenario import builtin_scenarios
from kinolab.testing import assert_collision_free, assert_dynamically_feasible
from tests.conftest import Solved, Solver
from tests.support import OPEN, WALL, problem_of

SLOW = "marionette_stage"  # 57 states: a minute
SCENARIOS = [
    pytest.param(n, marks=pytest.mark.long) if n == SLOW else n for n in builtin_scenarios()
]


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_scenario_is_solved_by_a_free_and_feasible_motion(name: str, solved: Solver) -> None:
    found = solved(name)
    assert found.plan.status == "solved", found.plan.message
    assert_collision_free(found.problem, found.trajectory)
    assert_dynamically_feasible(found.problem, found.trajectory)


def test_a_motion_into_a_wall_is_not_free_and_the_assertion_says_when(
    short: Solved, tmp_path: Path
) -> None:
    middle = short.trajectory.x[len(short.trajectory.x) // 2]
    x, y = middle[:2]
    wall = WALL.replace("3.0, 0.0, 0.5", f"{x}, {y}, 0.5").replace("0.1, 4.0", "0.1, 0.1")
    blocked = problem_of(tmp_path, OPEN + wall)
    with pytest.raises(AssertionError, match=r"at t = [0-9.]+ s coin \w+ wall"):
        assert_collision_free(blocked, short.trajectory)
    assert_dynamically_feasible(blocked, short.trajectory)  # walls are no matter of dynamics


def test_a_bent_motion_is_not_feasible_and_the_assertion_says_where(short: Solved) -> None:
    x = short.trajectory.x.copy()
    x[3, 1] += 1e-3
    bent = replace(short.trajectory, x=x)
    with pytest.raises(AssertionError, match=r"FAILED dynamics .* at t = 0\.(15|2) s y is"):
        assert_dynamically_feasible(short.problem, bent)


def test_all_that_is_infeasible_is_said_at_once(short: Solved) -> None:
    x, u = short.trajectory.x.copy(), short.trajectory.u.copy()
    x[0, 0] += 0.1
    u[2, 0] = 3.0
    with pytest.raises(AssertionError) as caught:
        assert_dynamically_feasible(short.problem, replace(short.trajectory, x=x, u=u))
    for name in ("start", "dynamics", "inputs"):
        assert f"FAILED {name}" in str(caught.value)
