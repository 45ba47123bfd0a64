"""Planners that optimise guesses: what flies is planned soon, and ways around too far are left."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.concurrency.cancel import never_cancelled
from kinolab.problem import PlanningTask
from kinolab.problem.machines.kinematic_task import follows_every_path
from kinolab.search import Budget, Outcome
from kinolab.trajopt.multistart.multiple_shooting import Multistart
from tests.feedback_machines import cart_pole
from tests.planners.test_planners import bits
from tests.support import problem_of
from tests.trajopt.multistart.test_geometric_path import door, hall
from tests.trajopt.scenarios import FLY
from tests.trajopt.test_trajopt import EXACT

MOST = 30_000  # iterations, of trees or guesses
SHORT = 15.0  # [s]: at 0.5 m/s some more than through the near door, less than through the far one
ROUNDABOUT = 7  # a seed of which the first guesses lead through the far door too


@pytest.fixture
def rotor(tmp_path: Path) -> PlanningTask:
    return problem_of(tmp_path, FLY)


@pytest.mark.parametrize("name", ["auto", "shooting"])
def test_a_rotor_climbs_into_the_middle_of_the_goal(name: str, rotor: PlanningTask) -> None:
    found = rotor.solve(planner=name, seed=1, max_iterations=MOST, optimize=False)
    assert found.status == "solved"
    assert found.goal_distance < EXACT


@pytest.mark.parametrize("name", ["kpiece_fast", "rrt_fast"])
def test_trees_alone_would_not_have_got_it_there(name: str, rotor: PlanningTask) -> None:
    """Otherwise the one above would not tell of guesses."""
    found = rotor.solve(planner=name, seed=1, max_iterations=MOST, optimize=False)
    assert found.status in {"approximate", "not_found"}


@pytest.mark.parametrize("name", ["auto", "shooting"])
def test_equal_seeds_give_the_same_bits_where_a_guess_leads_there(
    name: str, rotor: PlanningTask
) -> None:
    one, other, third = (
        rotor.solve(planner=name, seed=seed, max_iterations=MOST, optimize=False)
        for seed in (2, 2, 3)
    )
    assert one.trajectory is not None
    assert bits(one) == bits(other) != bits(third)
    assert one.iterations == other.iterations


def test_a_search_that_is_interrupted_says_so(rotor: PlanningTask) -> None:
    budget = Budget(60.0, interrupted=True)
    found = planners.get("shooting")().solve(rotor, 1, budget)
    assert (found.outcome, len(found.u)) == (Outcome.INTERRUPTED, 0)
    assert found.iterations == 0


def doors(problem: PlanningTask, seed: int, below: float) -> set[str]:
    """Return through which doors the motions lead that come of the first guesses."""
    shots = Multistart(problem, 80, seed, never_cancelled, below)
    motions = [shots.next() for _ in range(2)]
    return {door(motion.x) for motion in motions if motion is not None}


def test_ways_that_cannot_be_shorter_than_a_motion_that_there_is_are_left_out(
    tmp_path: Path,
) -> None:
    problem = hall(tmp_path, "near", "far")
    assert "far" in doors(problem, ROUNDABOUT, math.inf)
    assert doors(problem, ROUNDABOUT, SHORT) == {"near"}


def test_the_budget_says_below_which_duration_a_guess_is_worth_it(tmp_path: Path) -> None:
    problem = hall(tmp_path, "near", "far")
    found, other = (
        planners.get("shooting")().solve(problem, 1, Budget(60.0, 1, below=below))
        for below in (SHORT, math.inf)
    )
    assert 0.0 < found.t[-1] < SHORT  # by words of extreme inputs, which end below it
    assert other.t[-1] > SHORT


def test_what_a_guess_asks_of_feedback_are_references() -> None:
    """Not the plant's inputs, which are of another unit: the pole would fall at once."""
    problem = kinolab.load(
        {
            "system": cart_pole(),
            "bounds": {"x": [-4.0, 4.0]},
            "goal": {"x": 2.0, "at_rest": True, "tolerance": 0.05},
            "integration": {"step": 0.05},
        }
    )
    found = problem.solve(planner="shooting", seed=1, max_iterations=20, optimize=False)
    assert found.status == "solved"
    assert found.goal_distance < 1e-4  # the goal as it was found, with step errors


def test_an_arm_follows_a_free_path_from_corner_to_corner() -> None:
    """It stands still at its corners, and inputs are within limits before anything is optimised."""
    problem = kinolab.load("panda_shelves")
    multistart = Multistart(problem, 80, 1, never_cancelled)
    assert follows_every_path(problem)
    guess = multistart._by_computed_torque()
    assert guess is not None
    low, high = problem.model.control_bounds.T
    assert ((guess.u >= low) & (guess.u <= high)).all()
    assert not problem.outside_limits(guess.x).any()
    assert problem.goal_excess(guess.x[-1]) < 1e-3
    assert guess.x[-1, 7:] == pytest.approx(np.zeros(7), abs=1e-9)
    checker = problem.checker()
    assert checker.first_collision(problem.model.frames(guess.x)) is None


def test_machines_that_cannot_follow_every_path_are_told_apart(rotor: PlanningTask) -> None:
    assert not follows_every_path(rotor)
    assert not follows_every_path(kinolab.load("five_bar_table"))
    assert not follows_every_path(kinolab.load("crane_factory"))
    assert not follows_every_path(kinolab.load("pendulum_swingup"))  # too weak to hold itself
