"""Machines that switch, optimised across their transitions: optima that calculus gives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import Trajectory
from kinolab.trajopt import shorten
from kinolab.trajopt.nlp.problem import TrajectoryProblem
from kinolab.trajopt.shortening.phases import knots_of, phases_of
from kinolab.verification import verify

SCENARIO = """\
schema = 1
title = "From here to there"
[system]
file = "machine.py:machine"
[start]
{start}
[goal]
{goal}
[planner]
name = "rrt_fast"
[integration]
step = 0.05
"""
HILL = """
from kinolab.dynamics import *


def machine():
    x = length("x", -1.0, 20.0, speed=20.0)
    cart = Body("cart", move(x, 0, 0), mass=1.0, shape=Sphere(0.1))
    return System(
        "cart",
        bodies=[cart],
        inputs=[Force("push", on=cart, along=WORLD.x, limit=1.0)],
        modes=[Mode("level"), Mode("hill", efforts=[Potential(0.5 * x)])],
        transitions=[
            Transition("up", "level", "hill", until=4.0 - x),
            Transition("down", "hill", "level", until=x - 4.0),
        ],
    )
"""
BALL = """
from kinolab.dynamics import *


def machine():
    z = length("z", -1.0, 10.0, speed=10.0)
    ball = Body("ball", move(0, 0, z), mass=1.0, shape=Sphere(0.1), touches_ground=True)
    return System(
        "ball",
        bodies=[ball],
        inputs=[Force("thrust", on=ball, along=WORLD.z, limit=(0.0, 15.0))],
        gravity=toward("-z", 9.81),
        modes=[Mode("flight")],
        transitions=[Transition("bounce", "flight", "flight", until=z, restitution=0.7)],
    )
"""


def loaded(folder: Path, source: str, start: str, goal: str) -> kinolab.Problem:
    (folder / "machine.py").write_text(source)
    (folder / "case.toml").write_text(SCENARIO.format(start=start, goal=goal))
    return kinolab.load(folder / "case.toml")


@pytest.fixture(scope="module")
def hill(tmp_path_factory: pytest.TempPathFactory) -> kinolab.Problem:
    goal = "x = 6.0\nx_dot = 0.0\ntolerance = 0.6"
    return loaded(tmp_path_factory.mktemp("hill"), HILL, "x = 0.0", goal)


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> kinolab.Problem:
    return loaded(tmp_path_factory.mktemp("ball"), BALL, "z = 1.0", "z = 0.8\ntolerance = 0.1")


def moved(problem: kinolab.Problem, u: np.ndarray) -> Trajectory:
    """Return what a machine does under inputs, one for each step of the problem."""
    return resimulate(problem, problem.step * np.arange(len(u) + 1), u.reshape(-1, 1))


@pytest.fixture(scope="module")
def climb(hill: kinolab.Problem) -> Trajectory:
    """Speed up at 0.2 m/s^2 as far as the hill, there keep that speed, and stop."""
    u = np.concatenate([np.full(127, 0.2), np.full(13, 0.5), np.full(32, -0.3)])
    found = moved(hill, u)
    assert hill.goal_excess(found.x[-1]) <= 1.0
    return found


@pytest.fixture(scope="module")
def drop(ball: kinolab.Problem) -> Trajectory:
    found = moved(ball, np.concatenate([np.full(12, 4.0), np.full(8, 9.0)]))
    assert ball.goal_excess(found.x[-1]) <= 1.0
    return found


def test_a_cart_comes_up_a_hill_as_fast_as_calculus_allows(
    hill: kinolab.Problem, climb: Trajectory
) -> None:
    """Full thrust, then full brakes, 1.5 m/s^2 on the hill.

    They must begin before its foot, where v^2 = 2 * 1.5 * 2 m^2/s^2: after a way s at 1 m/s^2,
    2 s - 2 (4 - s) = v^2.
    """
    foot = np.sqrt(2 * 1.5 * 2)
    top = np.sqrt(2 * (4 + foot**2 / 2) / 2)
    least = top + (top - foot) + foot / 1.5
    found = shorten(hill, climb, 5.0)
    assert verify(hill, found).passed
    assert np.abs(found.x[-1] - [6.0, 0.0, 1.0]).max() < 1e-6
    assert np.count_nonzero(np.diff(found.x[:, -1])) == 1
    assert least - 1e-6 < found.duration < 1.01 * least  # inputs change between steps only


def test_a_ball_falls_freely_and_rises_under_full_thrust(
    ball: kinolab.Problem, drop: Trajectory
) -> None:
    """Thrust only slows its fall; after the bounce, at 0.7 of its speed, it adds 15 - g."""
    g, v, a = 9.81, 0.7 * np.sqrt(2 * 9.81), 15.0 - 9.81
    least = np.sqrt(2 / g) + (np.sqrt(v**2 + 2 * a * 0.8) - v) / a
    found = shorten(ball, drop, 5.0)
    assert verify(ball, found).passed
    assert least - 1e-6 < found.duration < 1.01 * least


def test_transitions_are_found_where_free_fall_has_them(
    ball: kinolab.Problem, drop: Trajectory
) -> None:
    """Under 4 N a fall of 1 m takes sqrt(2 / (g - 4)), and the bounce leaves 0.7 of the speed."""
    fall, rise = phases_of(ball, drop)
    time = np.sqrt(2 / (9.81 - 4.0))
    assert abs(fall.duration - time) < 1e-9
    assert np.abs(fall.x[-1, :2] - [0.0, -(9.81 - 4.0) * time]).max() < 1e-9
    assert np.abs(rise.x[0, :2] - [0.0, 0.7 * (9.81 - 4.0) * time]).max() < 1e-9
    assert (fall.number, rise.number) == (0, 1)
    assert abs(fall.duration + rise.duration - drop.duration) < 1e-12


@pytest.mark.parametrize(("case", "motion"), [("hill", "climb"), ("ball", "drop")])
def test_a_step_across_a_transition_is_the_machines_own(
    case: str, motion: str, request: pytest.FixtureRequest
) -> None:
    """From a state a moment before the transition; derivatives are differences of such steps."""
    problem, given = request.getfixturevalue(case), request.getfixturevalue(motion)
    phases = phases_of(problem, given)
    knots, lag = knots_of(problem, phases), 1e-2 * problem.step
    k, x, u = int(knots.phases.begins[0]), knots.x.copy(), knots.u.copy()
    u[k] = 0.7
    q, v, mode = phases[0].x[-1]
    a = {"hill": 0.7, "ball": 0.7 - 9.81}[case]
    x[k] = [q - v * lag + a * lag**2 / 2, v - a * lag, mode]
    knots = replace(knots, x=x, u=u)
    local = TrajectoryProblem(problem, 0.0).transcription(knots).linearization(knots, 1.0)
    through = problem.model.step(x[k], u[k], float(knots.lengths[1]), substeps=64)
    assert np.abs(local.defects[k] + x[k + 1] - through).max() < 1e-9

    def end(change: np.ndarray) -> np.ndarray:
        moved = x.copy(), u.copy()
        moved[0][k, :2] += change[:2]
        moved[1][k] += change[2:]
        there = replace(knots, x=moved[0], u=moved[1])
        made = TrajectoryProblem(problem, 0.0).transcription(knots).linearization(there, 1.0)
        return np.asarray(made.defects[k] + x[k + 1])

    for j, change in enumerate(1e-4 * np.eye(3)):
        slope = (end(change) - end(-change)) / 2e-4
        entry = (0, 1, 3)[j]  # the mode does not vary
        assert np.abs(local.sensitivities[k][:, entry] - slope).max() < 1e-6


def test_a_walk_loses_steps_and_most_of_its_time() -> None:
    """From a search without improvement: the shortest plan known takes about 2 s."""
    problem = kinolab.load("biped_walk")
    found = problem.solve(seed=1001, optimize=False).trajectory
    assert found is not None
    short = shorten(problem, found, 6.0)
    assert verify(problem, short).passed
    assert short.duration < 0.4 * found.duration
    steps, before = (np.count_nonzero(np.diff(motion.x[:, -1])) for motion in (short, found))
    assert steps < before
