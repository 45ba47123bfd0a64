"""States, guesses and pictures of a goal that says where an axis points."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from kinolab.problem import PlanningTask
from kinolab.show.scene.problem_picture import picture
from kinolab.trajopt.multistart.guesses import Guesses
from tests.support import problem_of

Array = NDArray[np.float64]

TURN = """
schema = 1
title = "A telescope turns"
system = { name = "satellite" }
[goal]
at_rest = true
tolerance = 0.01
[[goal.direction]]
body = "telescope"
axis = "x"
target = [-0.6, 0.8, 0.0]
tolerance = 0.02
"""
SUN = """
[[keep_out]]
body = "telescope"
axis = "x"
direction = [0.0, 0.0, 1.0]
half_angle = 0.4
"""
SWING = """
schema = 1
title = "A bob points up, as far as a hinge lets it"
system = { name = "pendulum" }
[goal]
theta_dot = 0.0
[[goal.direction]]
body = "bob"
axis = "x"
target = [0.0, 0.0, 1.0]
"""


def axis_of(problem: PlanningTask, x: Array) -> Array:
    (target,) = problem.goal.directions
    pose = problem.frames(x)[target.body].reshape(3, 4)
    return np.asarray(pose[:, :3] @ target.axis)


def test_all_states_of_the_goal_point_at_their_target(tmp_path: Path) -> None:
    """Exactly, up to rounding; about the axis they are turned at random."""
    problem, generator = problem_of(tmp_path, TURN), np.random.default_rng(0)
    one_by_one = np.array([problem.sample_goal(generator) for _ in range(20)])
    at_once = problem.sample_goals(generator, np.ones(20))
    for states in (one_by_one, at_once):
        np.testing.assert_allclose(
            [axis_of(problem, x) for x in states], np.tile([-0.6, 0.8, 0.0], (20, 1)), atol=1e-12
        )
        assert max(problem.goal_excess(x) for x in states) <= 1.0
        assert np.ptp([problem.frames(x)[0, 10] for x in states]) > 1.5  # of z along the world's z


@pytest.mark.parametrize("target", [(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.6, -0.8)])
def test_a_guess_ends_after_the_least_turn_to_the_target(
    target: tuple[float, float, float], tmp_path: Path
) -> None:
    """Half a turn about some axis where the target is behind, none where it is ahead."""
    problem = problem_of(tmp_path, TURN, f"goal.direction.1.target={list(target)}")
    end = Guesses(problem, np.random.default_rng(0)).straight()[1]
    np.testing.assert_allclose(axis_of(problem, end), target, atol=1e-12)
    angle = 2 * np.arccos(min(1.0, abs(end[3])))
    assert angle == pytest.approx(np.arccos(target[0]), abs=1e-7)


def test_an_attitude_with_a_target_of_its_own_stays_there(tmp_path: Path) -> None:
    text = TURN.replace("at_rest = true", "R = [0.0, 0.0, 0.6, 0.8]\nat_rest = true")
    problem = problem_of(tmp_path, text)
    end = Guesses(problem, np.random.default_rng(0)).straight()[1]
    np.testing.assert_allclose(end[:4], [0.0, 0.0, 0.6, 0.8], atol=1e-15)


def test_a_machine_without_attitudes_has_states_of_its_goal_as_before(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, SWING)
    x = problem.sample_goals(np.random.default_rng(0), np.ones(50))
    assert np.ptp(x[:, 0]) > 4.0  # [rad]; the hinge is anywhere


def test_a_picture_shows_where_an_axis_shall_and_must_not_point(tmp_path: Path) -> None:
    """A cone each, longer than the machine; no ghost, for the goal leaves the attitude open."""
    problem = problem_of(tmp_path, TURN + SUN)
    shown = picture(problem, problem.start[None])
    wanted, forbidden = shown.cones
    assert (wanted.forbidden, forbidden.forbidden) == (False, True)
    assert wanted.direction == pytest.approx((-0.6, 0.8, 0.0))
    assert (wanted.half_angle, forbidden.half_angle) == (0.02, 0.4)
    assert wanted.length == forbidden.length > 2.85  # [m] from the centre to the end of a wing
    assert shown.goal is None


def test_a_clearance_widens_what_plans_keep_out_of_and_nothing_else(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, TURN + SUN.replace("half_angle", "clearance = 0.1\nhalf_angle"))
    (cone,) = problem.keep_outs
    frames = problem.frames(problem.start)
    aside = (np.cos(0.45), np.sin(0.45), 0.0)  # [rad] from the axis; its direction stays apart
    looking = replace(cone, direction=aside)
    assert cone.half_angle == pytest.approx(0.5)
    assert looking.angle(frames) < looking.half_angle
    assert looking.angle(frames) > looking.forbidden.half_angle == pytest.approx(0.4)
    shown = picture(problem, problem.start[None])
    assert shown.cones[1].half_angle == pytest.approx(0.4)
