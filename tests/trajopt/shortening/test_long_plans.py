"""Plans of a thousand steps: made short in seconds, made exact by their last part alone."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import Trajectory
from kinolab.trajopt import make_exact, shorten
from tests.support import problem_of
from tests.trajopt.test_trajopt import EXACT

STEP, FULL = 0.1, 0.25  # [s], and [m/s^2] or [rad/s^2]
SECONDS = 6.0  # of this thread's time
FAR, ASIDE, SLOW = 6.0, 3.0, 0.2  # [m], [m], [m/s]
QUARTER = 14.0  # [s] for a quarter of a turn, slower than it could be
DRIVE = f"""
schema = 1
title = "A robot with limited acceleration takes a detour"
system = {{{{ name = "unicycle2_v0" }}}}
world.bounds = {{{{ x = [-2, 8], y = [-2, 5] }}}}
[goal]
x = {FAR}
y = 0.0
theta = {{heading}}
v = 0.0
w = 0.0
tolerance = 0.1
[integration]
step = {STEP}
"""
WALL = """
[[world.obstacle]]
box = [0.2, 3.0, 1.0]
position = [3.0, 0.0, 0.5]
"""


def eased(total: float, most: float) -> list[float]:
    """Return rates of change, step by step, that carry something from rest to rest by a total."""
    speed = np.sign(total) * most
    starting = round(most / FULL / STEP)
    cruising = round((abs(total) - most**2 / FULL) / most / STEP)
    push = speed / starting / STEP
    return [push] * starting + [0.0] * cruising + [-push] * starting


def turned(sign: float) -> list[float]:
    """Return angular accelerations for a quarter of a turn from rest to rest."""
    half = round(QUARTER / 2 / STEP)
    push = sign * np.pi / 2 / (half * STEP) ** 2
    return [push] * half + [-push] * half


def detour(problem: PlanningTask) -> Trajectory:
    """Drive along three sides of a rectangle, and stop to turn at each corner."""
    rows: list[tuple[float, float]] = []
    for turn, way in ((1, ASIDE), (-1, FAR), (-1, ASIDE), (1, 0.0)):
        rows += [(0.0, a) for a in turned(turn)]
        rows += [(a, 0.0) for a in eased(way, SLOW)] if way else []
    u = np.array(rows)
    return resimulate(problem, STEP * np.arange(len(u) + 1.0), u)


def problem_with(folder: Path, *, heading: float = 0.0, wall: bool = False) -> PlanningTask:
    text = DRIVE.format(heading=heading)
    return problem_of(folder, text.replace("[goal]", WALL + "[goal]") if wall else text)


def verified(problem: PlanningTask, motion: Trajectory) -> None:
    certificate = kinolab.verify(problem, motion)
    assert certificate.passed, [str(check) for check in certificate.failures]
    assert problem.goal_distance(motion.x[-1]) < EXACT


def test_a_detour_ends_up_as_the_straight_way_in_its_least_time(tmp_path: Path) -> None:
    """A double integrator over d with |v| <= V and |a| <= A takes d / V + V / A, here 14 s."""
    problem = problem_with(tmp_path)
    given = detour(problem)
    assert given.duration > 110
    short = shorten(problem, given, SECONDS)
    verified(problem, short)
    least = FAR / 0.5 + 0.5 / FULL
    assert least - STEP <= short.duration <= 1.1 * least


def test_a_wall_in_the_straight_way_is_driven_around(tmp_path: Path) -> None:
    """The shortest way over a corner of the wall, touched by no shape, is a lower bound."""
    problem = problem_with(tmp_path, wall=True)
    given = detour(problem)
    short = shorten(problem, given, SECONDS)
    verified(problem, short)
    corner = [np.array(p) for p in ((0.0, 0.0), (3.0, 1.5), (FAR, 0.0))]
    least = sum(float(np.linalg.norm(b - a)) for a, b in pairwise(corner)) / 0.5
    assert least < short.duration < 0.4 * given.duration


def test_only_the_end_of_a_long_plan_changes_when_it_is_made_exact(tmp_path: Path) -> None:
    """The goal's heading is 0.05 rad off the plan's, which is within its tolerance."""
    problem = problem_with(tmp_path, heading=0.05)
    given = detour(problem)
    assert problem.goal_excess(given.x[-1]) < 1
    assert problem.goal_distance(given.x[-1]) > 0.04
    exact = make_exact(problem, given)
    assert exact is not None
    verified(problem, exact)
    kept = len(given.u) // 2
    assert np.array_equal(exact.x[:kept], given.x[:kept])
    assert np.array_equal(exact.u[:kept], given.u[:kept])


def test_the_same_number_of_subproblems_gives_the_same_bits(tmp_path: Path) -> None:
    problem = problem_with(tmp_path, wall=True)
    given = detour(problem)
    one, other = (shorten(problem, given, Budget(math.inf, 60).fraction()) for _ in range(2))
    assert one.duration < given.duration
    assert np.array_equal(one.x, other.x)
    assert np.array_equal(one.t, other.t)


@pytest.mark.parametrize("seconds", [0.0, 0.3])
def test_what_time_is_too_short_for_is_no_worse(seconds: float, tmp_path: Path) -> None:
    problem = problem_with(tmp_path, wall=True)
    given = detour(problem)
    short = shorten(problem, given, seconds)
    assert short is given or short.duration < given.duration
    assert kinolab.verify(problem, short).passed


def test_steps_that_are_held_keep_their_length(tmp_path: Path) -> None:
    """Planners hold inputs for whole steps of the problem: others would lead elsewhere."""
    problem = problem_with(tmp_path, heading=0.05)
    exact = make_exact(problem, detour(problem), held=True)
    assert exact is not None
    verified(problem, exact)
    assert np.diff(exact.t) == pytest.approx(STEP, abs=1e-9)
