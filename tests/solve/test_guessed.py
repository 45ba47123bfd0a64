"""A plan that is known serves again where the world, the start or the goal has changed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.solve import PlanResult, solve
from kinolab.solve.plan import CENTRE_TOLERANCE
from tests.support import OPEN, problem_of


@pytest.fixture(scope="module")
def table(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    return problem_of(tmp_path_factory.mktemp("table"), OPEN)


@pytest.fixture(scope="module")
def known(table: PlanningTask) -> PlanResult:
    return solve(table, "rrt_fast", seed=1, improve=0)


def test_a_motion_serves_again_from_a_start_beside_its_own(
    table: PlanningTask, known: PlanResult
) -> None:
    beside = table.start + 0.02 * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    again = solve(replace(table, start=beside), "rrt_fast", seed=1, improve=0,
                  guess=known.trajectory)  # fmt: skip
    assert again.status == "solved"
    assert (again.iterations, again.planner) == (0, "rrt_fast")
    assert again.trajectory is not None
    assert again.trajectory.x[0] == pytest.approx(beside)
    assert again.goal_distance < CENTRE_TOLERANCE


def test_the_rest_of_a_motion_serves_on_the_way(table: PlanningTask, known: PlanResult) -> None:
    assert known.trajectory is not None
    rest = known.trajectory.piece(20, len(known.trajectory.u))
    onward = solve(replace(table, start=rest.x[0]), improve=0, guess=rest)
    assert onward.status == "solved"
    assert onward.iterations == 0
    assert onward.cost is not None
    assert known.cost is not None
    assert onward.cost < known.cost


def test_where_it_does_not_fit_the_planner_searches(table: PlanningTask, known: PlanResult) -> None:
    """A wall across the motion, around which no small change leads."""
    problem = kinolab.api.Problem.of(table)
    wall = problem.with_obstacle(box=(0.1, 3.0, 1.0), position=(-0.5, 0.0, 0.5))
    found = wall.solve("rrt_fast", seed=1, improve=0, guess=known.trajectory)
    plain = wall.solve("rrt_fast", seed=1, improve=0)
    assert found.status == plain.status
    if found.iterations:  # searched for, with the same seed
        assert found.trajectory is not None
        assert plain.trajectory is not None
        assert np.array_equal(found.trajectory.u, plain.trajectory.u)


def test_a_motion_of_another_machine_is_refused(table: PlanningTask) -> None:
    swing = kinolab.load("pendulum_swingup")
    other = kinolab.simulate(swing, duration=0.5)
    with pytest.raises(InputError, match=r"^solve guess: its columns are .*, of another machine\."):
        solve(table, improve=0, guess=other)
