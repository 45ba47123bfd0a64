"""Trees below the duration of a known motion find shorter ones; counted work ends them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.numerics.work import counted_work
from kinolab.planners.kpiece_fast import BOUND_FRACTION
from kinolab.problem import PlanningTask
from kinolab.search import Budget, Outcome, SearchResult
from kinolab.simulation.reference import resimulate
from kinolab.solve import PlanResult
from kinolab.solve.cost_bound import cost_bounded, guessing
from kinolab.solve.plan import CENTRE_TOLERANCE
from tests.support import problem_of

WORK = 0.4  # [s]
WALL = """
schema = 1
title = "A wall across a hall, open at one end and at a door that is hardly wider than the robot"
system = { name = "unicycle2_v0" }
bounds = { x = [0, 4], y = [-4, 6] }
[start]
x = 1.0
y = 4.0
[goal]
x = 3.0
y = 4.0
tolerance = 0.1
[[world.obstacle]]
box = [0.3, 1.7, 1.0]
position = [2.0, 5.15, 0.0]
[[world.obstacle]]
box = [0.3, 6.7, 1.0]
position = [2.0, 0.35, 0.0]
"""


@pytest.fixture(scope="module")
def maze() -> PlanningTask:
    return kinolab.load("rolling_disk_maze")


@pytest.fixture(scope="module")
def plan(maze: PlanningTask) -> PlanResult:
    """From a motion of trees: that in flat outputs is short already."""
    return maze.solve(seed=1, planner="kpiece_fast", improve=0.6)  # [s] of work: as with more


def searched(
    problem: PlanningTask, name: str, below: float, seed: int = 1, seconds: float = WORK
) -> SearchResult:
    with counted_work() as work:
        budget = Budget(seconds, improve=seconds, below=below, clock=lambda: work.seconds)
        found = planners.make(name, {}).solve(problem, seed, budget)
    assert work.seconds < 2 * seconds
    return found


def test_a_motion_below_a_bound_takes_a_good_deal_less(maze: PlanningTask) -> None:
    first = planners.make("kpiece_fast", {}).solve(maze, 1, Budget(30.0, improve=0.0)).t[-1]
    found = searched(maze, "kpiece_fast", first)
    assert found.outcome is Outcome.SOLVED
    assert found.t[-1] < BOUND_FRACTION * first


@pytest.mark.parametrize(("name", "seconds"), [("kpiece_fast", 0.4), ("sst", 0.4), ("ao_rrt", 4.0)])
def test_a_motion_below_a_bound_takes_less_than_the_bound(
    name: str, seconds: float, maze: PlanningTask
) -> None:
    """Without a bound sst and ao_rrt find motions of 36 to 40 s and 29 to 32 s first."""
    found = searched(maze, name, 28.0, seconds=seconds)
    assert found.outcome is Outcome.SOLVED
    assert found.t[-1] < 28.0


def test_what_trees_below_a_bound_find_leads_into_the_goal(maze: PlanningTask) -> None:
    found = searched(maze, "kpiece_fast", 30.0)
    motion = resimulate(maze, found.t, found.u)  # by another integrator
    assert maze.goal_excess(motion.x[-1]) <= 1.0
    assert found.statistics["improvements"] >= 1.0


def test_nothing_is_found_below_a_bound_that_nothing_can_meet(maze: PlanningTask) -> None:
    """The shortest motion known takes 6.9 s."""
    assert searched(maze, "kpiece_fast", 1.0).outcome is not Outcome.SOLVED


def test_counted_work_and_not_the_clock_ends_them(maze: PlanningTask) -> None:
    first, second = (searched(maze, "kpiece_fast", 40.0, seed=3) for _ in range(2))
    assert first.u.tobytes() == second.u.tobytes()
    assert first.iterations == second.iterations


def test_the_improvement_begins_with_what_they_find(plan: PlanResult) -> None:
    """The first one is below the first bound."""
    made = [(one.by, one.duration) for one in plan.improvements]
    assert [by for by, _ in made[:3]] == ["search", "repair", "repair"]
    assert made[2][1] < BOUND_FRACTION * made[0][1]
    assert np.all(np.diff([duration for _, duration in made[1:-1]]) < 0)


def test_the_first_motion_ends_in_the_centre_before_others_are_sought(plan: PlanResult) -> None:
    first, repaired, *_ = plan.improvements
    assert (first.by, repaired.by) == ("search", "repair")
    assert first.goal_distance > CENTRE_TOLERANCE >= repaired.goal_distance


def test_only_the_motions_of_compiled_trees_are_shortened_by_others(maze: PlanningTask) -> None:
    settings = {"min_steps": 2, "max_steps": 30}
    held = cost_bounded(maze, planners.make("auto", settings))
    assert held is not None
    assert {name: getattr(held, name) for name in settings} == settings
    for name in ("rrt", "prm", "potential_field", "shooting"):
        assert cost_bounded(maze, planners.make(name, {})) is None


def test_trees_that_find_nothing_end_when_patience_does(maze: PlanningTask) -> None:
    with counted_work() as work:
        budget = Budget(10.0, improve=10.0, below=1.0, patience=0.1, clock=lambda: work.seconds)
        planners.make("kpiece_fast", {}).solve(maze, 1, budget)
    assert 0.1 <= work.seconds < 0.2


def test_guesses_below_a_bound_go_the_short_way_through_a_narrow_door(tmp_path: Path) -> None:
    """Around the wall it is at least 14 m, which take 28 s; most trees find that way."""
    problem = problem_of(tmp_path, WALL)
    searcher = guessing(problem, planners.make("auto", {}))
    assert searcher is not None
    for seed in (1, 2, 3):
        found = searcher.solve(problem, seed, Budget(60.0, below=28.0, improve=0.0))
        assert found.outcome is Outcome.SOLVED
        motion = resimulate(problem, found.t, found.u)
        crossing = motion.x[np.diff(np.sign(motion.x[:, 0] - 2.0), append=0.0) != 0, 1]
        assert (np.abs(crossing - 4.0) < 0.3).all()


def test_guesses_are_those_of_auto(maze: PlanningTask) -> None:
    assert guessing(maze, planners.make("kpiece_fast", {})) is None


@pytest.mark.parametrize("name", ["biped_walk", "marionette_stage"])  # transitions; many states
def test_there_are_no_guesses_where_optimisation_is_dear(name: str) -> None:
    assert guessing(kinolab.load(name), planners.make("auto", {})) is None
