"""Improvement has more work for a long motion where nobody says how much, and says what it gave."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from kinolab.solve.improve import PlanImprover, _last_half_gain
from kinolab.solve.plan import Request, make_planner
from kinolab.trajectory import Trajectory
from tests.support import OPEN, problem_of


@pytest.mark.parametrize(
    ("steps", "said", "asked", "expected"),
    [
        (100, "", None, 2.0),
        (200, "", None, 2.0),
        (600, "", None, 6.0),
        (5000, "", None, 10.0),
        (600, "planner.improve=2.0", None, 2.0),
        (600, 'planner.improve="auto"', None, 6.0),
        (600, "", 3.0, 3.0),
        (600, "planner.improve=2.0", "auto", 6.0),
    ],
)
def test_the_work_grows_with_the_way_where_nobody_says_how_much(
    steps: int, said: str, asked: float | Literal["auto"] | None, expected: float, tmp_path: Path
) -> None:
    problem = problem_of(tmp_path, OPEN.replace("improve = 0\n", ""), *([said] if said else []))
    planner = make_planner(problem, None, {})
    request = Request(None, {}, seed=1, time_limit=10.0, max_iterations=None, anytime=False,
                      optimize=True, improve=asked)  # fmt: skip
    improver = PlanImprover(problem, planner, request, lambda: 0.0)
    t = problem.step * np.arange(steps + 1)
    x = np.tile(problem.start, (steps + 1, 1))
    names = problem.model.state_names, problem.model.plant.control_names
    motion = Trajectory(t, x, np.zeros((steps, len(names[1]))), *names)
    improver._growth = improver._growth_for(motion)
    assert improver._seconds == pytest.approx(expected)


def test_the_gain_of_the_second_half_is_that_after_half_of_the_work() -> None:
    gains = [(0.0, 20.0), (0.4, 16.0), (1.0, 10.0), (1.2, 9.0), (1.9, 8.0)]
    assert _last_half_gain(gains, 2.0) == pytest.approx(0.2)
    assert _last_half_gain(gains[:3], 2.0) == 0.0
    assert _last_half_gain([], 2.0) == 0.0
