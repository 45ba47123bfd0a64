"""Improvement has more work for a long motion where nobody says how much, and says what it gave."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from kinolab.solve import improve
from kinolab.solve.improve import PlanImprover
from kinolab.solve.plan import Request, make_planner
from kinolab.solve.refinement import Shortening
from kinolab.trajectory import Trajectory
from tests.support import OPEN, problem_of

EACH = 0.05  # [s] of a subproblem of 500 steps


@pytest.mark.parametrize(
    ("steps", "said", "asked", "expected"),
    [
        (100, "", None, 2.0),  # 60 subproblems of 0.01 s would be 0.6 s
        (1000, "", None, 6.0),
        (10_000, "", None, 30.0),
        (1000, "planner.improve=2.0", None, 2.0),
        (1000, 'planner.improve="auto"', None, 6.0),
        (1000, "", 3.0, 3.0),
        (1000, "planner.improve=2.0", "auto", 6.0),
    ],
)
def test_the_work_is_that_of_so_many_subproblems_where_nobody_says_how_much(
    steps: int,
    said: str,
    asked: float | Literal["auto"] | None,
    expected: float,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(
        improve.trajopt, "subproblem_seconds", lambda _, motion: EACH / 500 * len(motion.u)
    )
    problem = problem_of(tmp_path, OPEN.replace("improve = 0\n", ""), *([said] if said else []))
    planner = make_planner(problem, None, {})
    request = Request(None, {}, seed=1, time_limit=10.0, max_iterations=None, anytime=False,
                      optimize=True, improve=asked)  # fmt: skip
    improver = PlanImprover(problem, planner, request, lambda: 0.0)
    t = problem.step * np.arange(steps + 1)
    x = np.tile(problem.start, (steps + 1, 1))
    names = problem.model.state_names, problem.model.plant.control_names
    motion = Trajectory(t, x, np.zeros((steps, len(names[1]))), *names)
    assert improver._work_for(motion) == pytest.approx(expected)


def test_the_gain_of_the_second_half_is_that_after_half_of_the_work(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN)
    names = problem.model.state_names, problem.model.plant.control_names
    x = np.tile(problem.start, (2, 1))
    given, short = (
        Trajectory(np.array([0.0, end]), x, np.zeros((1, len(names[1]))), *names)
        for end in (20.0, 8.0)
    )
    curve = [(0.0, 20.0), (0.4, 16.0), (1.0, 10.0), (1.2, 9.0), (1.9, 8.0)]
    assert Shortening(given, short, 2.0, curve).last_half_gain == pytest.approx(0.2)
    assert Shortening(given, given, 0.0, curve[:1]).last_half_gain == 0.0
