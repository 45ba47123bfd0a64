"""The way to the goal from cell to cell: counted by hand, on a line and on a circle."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.numerics.struct import Record
from kinolab.problem import PlanningTask
from kinolab.search.tree import search_state
from kinolab.search.tree.kpiece.cost_to_go import (
    MAX_CELLS_PER_AXIS,
    cell_at,
    compute_cost_to_go,
    cost_to_go_grid,
)
from tests.support import OPEN, problem_of


def steps_to_goal(problem: PlanningTask, *states: tuple[float, ...]) -> list[float]:
    """Return how many cells each of some states is from the goal."""
    search, cells = search_state(problem, 1.0, 1), cost_to_go_grid(problem)
    compute_cost_to_go(Record(search), Record(cells), np.zeros(problem.model.nx))
    return [float(cells.steps[cell_at(Record(cells), np.array(x, dtype=float))]) for x in states]


def test_a_pendulum_is_led_around_the_side_that_is_open() -> None:
    """The girder closes the way up at positive angles, and the goal is where the circle closes."""
    problem = kinolab.load("pendulum_swingup")
    below, before, past = steps_to_goal(problem, (0.0, 0.0), (3.1, 0.0), (-3.1, 0.0))
    assert below == pytest.approx(MAX_CELLS_PER_AXIS / 2, abs=2)
    assert before <= 1
    assert past <= 1


def test_angles_count_the_short_way_however_often_they_have_turned() -> None:
    problem = kinolab.load("pendulum_swingup")
    once, again = steps_to_goal(problem, (-1.0, 0.0), (-1.0 + 4 * np.pi, 0.0))
    assert once == again == pytest.approx(MAX_CELLS_PER_AXIS * (np.pi - 1.0) / (2 * np.pi), abs=2)


def test_a_line_does_not_close(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN)
    (low, high), _ = problem.bounds[:2]
    goal, tolerance = float(problem.goal.targets[0]), float(problem.goal.tolerances[0])
    rest = (0.0,) * (problem.model.nx - 2)
    ends = steps_to_goal(problem, (low, 0.0, *rest), (high, 0.0, *rest))
    width = (high - low) / MAX_CELLS_PER_AXIS
    assert ends == pytest.approx(
        [(goal - tolerance - low) / width, (high - goal - tolerance) / width], abs=2
    )


@pytest.mark.parametrize("seed", range(1, 11))
def test_a_pendulum_swings_up_however_the_motion_misses_the_goal_at_first(seed: int) -> None:
    plan = kinolab.load("pendulum_swingup").solve(
        planner="kpiece_fast", seed=seed, max_iterations=10_000, time_limit=100.0, optimize=False
    )
    assert plan.status == "solved"
