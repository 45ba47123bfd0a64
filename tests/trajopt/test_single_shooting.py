"""Single shooting into the goal's centre, for machines with many states."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.concurrency.cancel import never_cancelled
from kinolab.trajopt.exact.single_shooting import end_by_single_shooting
from tests.conftest import Solved
from tests.support import coin_after


def test_a_coin_ends_in_the_centre_as_in_closed_form(short: Solved) -> None:
    """Each step of it is an arc of the coin's motion under held inputs."""
    problem, motion = short.problem, short.trajectory
    assert np.hypot(*motion.x[-1, :2]) > 1e-3
    made = end_by_single_shooting(problem, motion, never_cancelled)
    assert made is not None
    assert made.duration == motion.duration
    assert np.hypot(*made.x[-1, :2]) < 1e-6
    for x, u, span, after in zip(made.x, made.u, np.diff(made.t), made.x[1:], strict=False):
        assert np.abs(coin_after(x, u, np.array([span]))[0] - after).max() < 1e-7
    assert kinolab.verify(problem, made).passed


def test_who_cancels_gets_nothing(short: Solved) -> None:
    assert end_by_single_shooting(short.problem, short.trajectory, lambda: True) is None


@pytest.mark.long
def test_a_puppet_ends_where_it_was_sent() -> None:
    problem = kinolab.load("marionette_stage")
    plan = problem.solve(seed=1)
    assert plan.status == "solved"
    assert plan.goal_distance < 1e-6
    assert kinolab.verify(problem, plan.trajectory).passed
