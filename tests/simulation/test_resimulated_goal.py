"""Where the true motion ends, told quickly: as scipy's integrator tells it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kinolab
from kinolab.problem import PlanningTask
from kinolab.simulation.resimulated_goal import resimulated_violation
from tests.support import OPEN, problem_of


def ended(problem: PlanningTask, t: np.ndarray, u: np.ndarray) -> np.ndarray:
    x = problem.start
    for k, held in enumerate(u):
        rate = lambda _, x, held=held: problem.model.f(x, held)  # noqa: E731
        x = solve_ivp(rate, t[k : k + 2], x, rtol=1e-12, atol=1e-12).y[:, -1]
    return x


@pytest.mark.parametrize("share", [0.5, 0.9999, 1.0001, 3.0])
def test_a_motion_ends_as_far_outside_as_the_differential_equation_says(
    share: float, tmp_path: Path
) -> None:
    random, t = np.random.default_rng(0), 0.05 * np.arange(41)
    u = random.uniform([-1.0, -0.5], [1.0, 0.5], (40, 2))
    x, y = ended(problem_of(tmp_path, OPEN), t, u)[:2]
    goal = (f"goal.x={float(x + 0.1 * share)}", f"goal.y={float(y)}", "goal.tolerance=0.1")
    problem = problem_of(tmp_path, OPEN, *goal, 'integration.method="euler"')
    assert resimulated_violation(problem, u) == pytest.approx(share, abs=1e-5)


def test_a_motion_that_cannot_be_followed_is_nowhere_near(table: PlanningTask) -> None:
    assert resimulated_violation(table, np.array([[np.nan, 0.0]])) == np.inf


def test_who_ends_far_outside_is_told_without_scipy(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A search may come into a goal that the truth misses a thousand times."""
    goal = ("goal.x=5.0", "goal.y=0.0", "goal.tolerance=0.1")
    problem = problem_of(tmp_path, OPEN, *goal)
    monkeypatch.delattr("kinolab.simulation.resimulated_goal.resimulate")
    u = np.zeros((10, 2))  # it stays where it is
    assert resimulated_violation(problem, u) == pytest.approx((5.0 - problem.start[0]) / 0.1)


def test_a_motion_into_the_goal_through_a_wall_is_nowhere_near(tmp_path: Path) -> None:
    """The coin rolls straight on; where it is after 2 s, it can only be behind the wall."""
    u = np.tile([0.2, 0.0], (40, 1))
    through = problem_of(tmp_path, OPEN)
    end = ended(through, 0.05 * np.arange(41), u)
    middle = (float(through.start[0]) + float(end[0])) / 2
    goal = (f"goal.x={float(end[0])}", "goal.y=0.0", "goal.tolerance=0.1")
    wall = f"world.obstacle=[{{ box = [0.1, 4.0, 1.0], position = [{middle}, 0.0, 0.5] }}]"
    assert resimulated_violation(problem_of(tmp_path, OPEN, *goal), u) < 1e-6
    assert resimulated_violation(problem_of(tmp_path, OPEN, *goal, wall), u) == np.inf


def test_a_motion_that_cannot_be_replayed_is_nowhere_near() -> None:
    """A pendulum that stands upright, as far as it can: errors grow as exp(sqrt(g / l) t)."""
    upright = ("start.theta=3.141592653589793", "world.obstacle=[]")
    problem = kinolab.load("pendulum_swingup", overrides=upright)
    rate = np.sqrt(9.81)  # [1/s] of a pendulum of 1 m
    short, long = (np.zeros((round(np.log(times) / rate / 0.05), 1)) for times in (1e4, 1e8))
    assert resimulated_violation(problem, short) <= 1.0
    assert resimulated_violation(problem, long) == np.inf
