"""States of a goal that places points of bodies."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.trajopt.multistart.guesses import Guesses

ARM = Path(__file__).parents[1] / "first_afternoon" / "mobile_arm.toml"


@pytest.fixture(scope="module")
def arm() -> PlanningTask:
    return kinolab.load(ARM)


def test_states_of_the_goal_have_the_point_where_it_is_wanted(arm: PlanningTask) -> None:
    """Within its tolerance of 5 cm, wherever the robot stands, within limits, and at rest."""
    generator = np.random.default_rng(0)
    states = arm.sample_goals(generator, np.ones(200))
    inside = [arm.goal_excess(x) <= 1 + 1e-9 for x in states]
    assert np.mean(inside) > 0.95  # a few starts end at limits of the arm
    lower, upper = arm.bounds.T
    assert ((states >= lower - 1e-9) & (states <= upper + 1e-9)).all()
    assert np.ptp(states[:, 0]) > 0.5  # [m]: from many sides


def test_one_state_at_a_time_is_drawn_alike(arm: PlanningTask) -> None:
    generator = np.random.default_rng(1)
    excesses = [arm.goal_excess(arm.sample_goal(generator)) for _ in range(20)]
    assert np.median(excesses) <= 1.0


def test_a_guess_ends_with_the_point_in_its_place(arm: PlanningTask) -> None:
    """Not where the machine starts, as if the goal left everything free."""
    begin, end = Guesses(arm, np.random.default_rng(0)).straight()
    assert arm.goal_distance(end) < 1e-6  # [m]
    assert arm.goal_distance(begin) > 1.0
