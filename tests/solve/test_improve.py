"""Planners that go on after their first motion: every motion that they keep is shorter."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from kinolab import planners
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve import PlanResult
from tests.planners.test_planners import bits
from tests.support import OPEN, WALL, problem_of

improving = pytest.mark.parametrize("name", ["sst", "ao_rrt"])

ENDLESS = "planner.improve=1e6"
# of the wall; the coin's rim never limits its motion, so that what the tree grows is true
BEHIND = ("goal.x=4", "goal.tolerance=0.4", "system.parameters.mu=10")


def duration(found: PlanResult) -> float:
    assert found.trajectory is not None
    return float(found.trajectory.t[-1])


def behind_a_wall(folder: Path, improve: str = ENDLESS) -> PlanningTask:
    return problem_of(folder, OPEN + WALL, *BEHIND, improve)


@improving
def test_a_plan_is_never_longer_than_the_first_and_mostly_far_shorter(
    name: str, tmp_path: Path
) -> None:
    first = behind_a_wall(tmp_path, "planner.improve=0")
    later, shares = behind_a_wall(tmp_path), []
    for seed in range(1, 6):
        one = first.solve(planner=name, seed=seed, max_iterations=15_000, optimize=False)
        other = later.solve(planner=name, seed=seed, max_iterations=15_000, optimize=False)
        assert (one.status, other.status) == ("solved", "solved")  # the verifier agrees
        assert duration(other) <= duration(one)
        assert other.iterations == 15_000
        shares.append(duration(other) / duration(one))
    assert sorted(shares)[2] < 0.8


@improving
def test_more_iterations_never_make_a_plan_longer(name: str, tmp_path: Path) -> None:
    problem = behind_a_wall(tmp_path)
    durations = [
        duration(problem.solve(planner=name, seed=3, max_iterations=most, optimize=False))
        for most in (5000, 10_000, 20_000, 40_000)
    ]
    assert durations == sorted(durations, reverse=True)


@improving
def test_the_same_iterations_give_the_same_bits(name: str, tmp_path: Path) -> None:
    problem = behind_a_wall(tmp_path)
    one, other = (
        problem.solve(planner=name, seed=5, max_iterations=15_000, optimize=False) for _ in range(2)
    )
    assert bits(one) == bits(other)


@improving
def test_the_shortest_duration_is_nearly_found_and_never_beaten(name: str, tmp_path: Path) -> None:
    """A coin at rest that is driven straight on: half a metre at tau / (3/2 m R)."""
    problem = problem_of(tmp_path, OPEN, ENDLESS)
    acceleration = 1.0 / (1.5 * 1.0 * 0.25)  # [m/s^2]
    shortest = 0.05 * math.ceil(math.sqrt(2 * 0.5 / acceleration) / 0.05)  # [s], whole steps
    found = duration(problem.solve(planner=name, seed=1, max_iterations=50_000, optimize=False))
    assert shortest - 1e-9 <= found <= 1.25 * shortest


@improving
def test_a_search_improves_for_as_long_as_it_may(name: str, tmp_path: Path) -> None:
    problem = behind_a_wall(tmp_path, "planner.improve=0.4")
    found = problem.solve(planner=name, seed=1, time_limit=20.0, optimize=False)
    assert found.status == "solved"
    # What is loaded while it improves counts as preparation; test_time_limits has it exactly.
    assert found.timings["search"] + found.timings["prepare"] >= 0.4
    assert found.timings["search"] < 19.0  # [s] of 20


@improving
def test_improving_ends_at_the_time_limit(name: str, table: PlanningTask) -> None:
    found = table.solve(planner=name, seed=1, time_limit=0.5, optimize=False)
    assert found.status == "solved"
    assert found.timings["search"] < 20.0  # [s]; test_time_limits has it exactly


def test_without_improving_the_first_tree_is_that_of_rrt_fast(tmp_path: Path) -> None:
    problem = behind_a_wall(tmp_path, "planner.improve=0")
    ours = problem.solve(planner="ao_rrt", seed=2, max_iterations=20_000, optimize=False)
    theirs = problem.solve(planner="rrt_fast", seed=2, max_iterations=20_000, optimize=False)
    assert bits(ours) == bits(theirs)
    assert ours.statistics["nodes"] == theirs.statistics["nodes"]


@improving
def test_improvements_are_counted(name: str, tmp_path: Path) -> None:
    problem = behind_a_wall(tmp_path)
    found = planners.get(name)().solve(problem, 1, Budget(60.0, 30_000))
    assert found.statistics["improvements"] > 0
    assert found.t[-1] < found.statistics["first_duration"]
