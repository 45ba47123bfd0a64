"""Searches before anything is improved: a detour is not improved while a shorter way is known."""

from __future__ import annotations

import re

import kinolab
from kinolab.solve.improve import FIRST_SEARCHES

STICKY = "system.parameters.mu=10"  # a rim that never limits the motion


def test_a_maze_is_not_gone_through_by_the_first_detour() -> None:
    """The first search goes 20 s; one of the next finds a way about half as long, improved then."""
    problem = kinolab.load("rolling_disk_maze", overrides=[STICKY])
    plan = problem.solve(seed=1)
    made = [(one.by, one.duration) for one in plan.improvements]
    assert made[0][0] == "search"
    assert made[1][0] == "search"
    assert made[1][1] < 0.6 * made[0][1]
    assert plan.trajectory.duration < made[1][1]
    assert 1 <= plan.statistics["further_searches"] <= FIRST_SEARCHES + 10


def test_the_summary_says_when_more_improvement_would_pay() -> None:
    plan = kinolab.load("rolling_disk_maze", overrides=[STICKY]).solve(seed=1, improve=0.4)
    assert plan.statistics["improvement_unfinished"] == 1.0
    used = r"all 0\.4 s for improving it were used(, and the second half .*)?; "
    assert re.search(f"{used}--set planner.improve=2", str(plan))
