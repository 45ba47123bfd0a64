"""Repaired motions end exactly in the goal, and shortened ones take what theory says they take."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kinolab
from kinolab.numerics.work import counted_work
from kinolab.problem import PlanningTask
from kinolab.search import Budget, Outcome
from kinolab.simulation.reference import resimulate
from kinolab.solve import make_planner
from kinolab.trajectory import Trajectory
from kinolab.trajopt import make_exact, shorten, shortened
from tests.scenario.dynobench.wheel import environment, needs_wheel
from tests.support import OPEN, WALL, failed, problem_of

EXACT = 1e-6  # [SI units] from the goal's centre
PATIENCE = 20.0  # [s] of this thread's time, far more than is needed

DRIVE = """
schema = 1
title = "A robot with limited acceleration drives straight ahead"
system = { name = "unicycle2_v0" }
world.bounds = { x = [-1, 2], y = [-1, 1] }
[goal]
x = 0.8
y = 0.0
theta = 0.0
v = 0.0
w = 0.0
tolerance = 0.05
[integration]
method = "euler"
step = 0.05
truth = "discrete"
"""
PENDULUM = """
schema = 1
title = "A pendulum is lifted and held"
system = { name = "pendulum" }
[goal]
theta = 0.4
at_rest = true
tolerance = 0.1
[integration]
step = 0.05
"""


def straight_to(problem: PlanningTask, steps: int) -> Trajectory:
    """Return states on the line to the goal without any input: no motion of the machine at all."""
    end = problem.start.copy()
    end[list(problem.goal.indices)] = problem.goal.targets
    share = np.linspace(0, 1, steps + 1)[:, None]
    model = problem.model
    x = problem.start * (1 - share) + end * share
    t = problem.step * np.arange(steps + 1.0)
    return Trajectory(t, x, np.zeros((steps, model.nu)), model.state_names, model.control_names)


def repaired(problem: PlanningTask, steps: int) -> Trajectory:
    found = make_exact(problem, straight_to(problem, steps))
    assert found is not None
    certificate = kinolab.verify(problem, found)
    assert certificate.passed, [str(check) for check in certificate.failures]
    assert problem.goal_distance(found.x[-1]) < EXACT
    return found


def test_a_pendulum_comes_to_rest_exactly_where_it_must(tmp_path: Path) -> None:
    repaired(problem_of(tmp_path, PENDULUM), 60)


def test_the_stored_states_are_the_true_motion(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM)
    found = repaired(problem, 60)
    assert np.allclose(resimulate(problem, found.t, found.u).x, found.x, rtol=0, atol=1e-12)


def test_a_straight_drive_takes_the_time_of_full_thrust_and_full_brake(tmp_path: Path) -> None:
    """A double integrator over d with |a| <= A takes 2 sqrt(d / A), here 3.58 s.

    Speed stays below its limit: sqrt(d A) = 0.447 m/s of 0.5. One step more is granted for the
    steps' fixed length, 1 % for the weight of effort.
    """
    problem = problem_of(tmp_path, DRIVE)
    slow = repaired(problem, 160)
    fast = shorten(problem, slow, PATIENCE)
    assert kinolab.verify(problem, fast).passed
    assert problem.goal_distance(fast.x[-1]) < EXACT
    shortest = 2 * np.sqrt(0.8 / 0.25)
    assert shortest - problem.step <= fast.duration <= 1.01 * shortest + problem.step


def test_a_motion_is_not_made_longer(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, DRIVE)
    fast = shorten(problem, repaired(problem, 160), PATIENCE)
    assert shorten(problem, fast, PATIENCE).duration <= fast.duration


def test_without_time_the_motion_stays_as_it_is(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, DRIVE)
    given = repaired(problem, 160)
    assert shorten(problem, given, 0.0) is given


def test_a_goal_out_of_reach_is_not_repaired(tmp_path: Path) -> None:
    """A second is not enough for 0.8 m."""
    problem = problem_of(tmp_path, DRIVE)
    assert make_exact(problem, straight_to(problem, 20)) is None


def test_a_motion_through_a_wall_goes_around_it_or_is_not_repaired(tmp_path: Path) -> None:
    text = OPEN.replace("x = 0.0\n", "x = 4.0\n") + WALL
    problem = problem_of(tmp_path, text)
    found = make_exact(problem, straight_to(problem, 100))
    assert found is None or "collision" not in failed(kinolab.verify(problem, found))


BEST = {  # [s] published for the benchmark's tolerance, which is looser than an exact goal
    "quad2d_v0/empty_0": 0.97,
    "quad2d_v0/empty_1": 1.28,
}


@needs_wheel
@pytest.mark.parametrize("name", BEST)
def test_from_a_straight_line_the_published_best_cost_is_reached_or_nearly(name: str) -> None:
    """There are no obstacles; 3 % are granted, for these plans end exactly in the goal."""
    problem = kinolab.load(environment(name))
    fast = shorten(problem, repaired(problem, int(2.5 * BEST[name] / problem.step)), PATIENCE)
    assert kinolab.verify(problem, fast).passed
    assert problem.goal_distance(fast.x[-1]) < EXACT
    assert fast.duration <= 1.03 * BEST[name] + problem.step


GALLERY = ("rolling_disk_maze", "vehicle_parking")


def planned(problem: PlanningTask) -> Trajectory:
    """Return what the scenario's planner finds, which nobody has verified."""
    found = make_planner(problem, None, {}).solve(problem, 1, Budget(60.0))
    assert found.outcome is Outcome.SOLVED
    return resimulate(problem, found.t, found.u)


@pytest.mark.parametrize("name", GALLERY)
def test_a_plan_of_the_gallery_stays_true_when_it_is_repaired_and_shortened(name: str) -> None:
    problem = kinolab.load(name)
    exact = make_exact(problem, planned(problem))
    assert exact is not None
    assert problem.goal_distance(exact.x[-1]) < EXACT
    short = shorten(problem, exact, 0.3)
    assert short.duration <= exact.duration
    for trajectory in (exact, short):
        certificate = kinolab.verify(problem, trajectory)
        assert certificate.passed, [str(check) for check in certificate.failures]


@pytest.mark.parametrize("seed", [12, 13, 14])
def test_tyres_that_slip_come_to_rest_in_the_centre(seed: int) -> None:
    """What is left of their slip dies away where the robot stands; integrated anew by LSODA."""
    problem = kinolab.load("slip_steered_bay")
    result = make_planner(problem, "kpiece_fast", {}).solve(problem, seed, Budget(60.0))
    assert result.outcome is Outcome.SOLVED
    raw = resimulate(problem, result.t, result.u)
    assert problem.goal_distance(raw.x[-1]) > 1e-3
    exact = make_exact(problem, raw)
    assert exact is not None
    x = exact.x[0]
    for span, u in zip(np.diff(exact.t), exact.inputs, strict=True):
        step = solve_ivp(
            lambda _, y, u=u: problem.model.f(y, u), (0.0, span), x, "LSODA", rtol=1e-9, atol=1e-11
        )
        x = step.y[:, -1]
    assert problem.goal_distance(x) < 1e-4
    assert problem.goal_distance(exact.x[-1]) < 1e-6


def test_a_budget_that_is_over_ends_the_work(tmp_path: Path) -> None:
    """What is spent of it may be without bound, of which no part can be told."""
    problem = problem_of(tmp_path, OPEN)
    motion = make_exact(problem, straight_to(problem, 140))
    assert motion is not None
    with counted_work() as work:
        assert list(shortened(problem, motion, lambda: math.inf)) == []
    assert work.seconds < 0.01
