"""Where points of bodies shall come is drawn where it is: in the air, all of them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.show.scene.picture import Picture
from kinolab.show.scene.problem_picture import picture
from kinolab.show.scene.still import goal_ball, seen_points

ARM = Path(__file__).parents[2] / "first_afternoon" / "mobile_arm.toml"


@pytest.fixture(scope="module")
def shown() -> Picture:
    problem: PlanningTask = kinolab.load(ARM)
    (point,) = problem.goal.points
    second = replace(point, position=(1.0, 2.0, 3.0))
    problem = replace(problem, goal=replace(problem.goal, points=(point, second)))
    return picture(problem, problem.start[None])


def test_every_point_of_the_goal_has_a_ball_of_its_tolerance(shown: Picture) -> None:
    places = [point.position for point in shown.points]
    assert places == [(4.4, 1.0, 0.3), (1.0, 2.0, 3.0)]
    ball = goal_ball(shown.points[0])
    distances = np.linalg.norm(ball.vertices - np.array(places[0]), axis=1)
    np.testing.assert_allclose(distances, 0.05)  # [m]


def test_the_picture_shows_them_above_the_ground(shown: Picture) -> None:
    """A ring on the floor would be hidden below the shelf."""
    seen = seen_points(shown, shown.obstacle_meshes(), shown.machine(), ())
    assert seen[:, 2].max() >= 3.05  # [m]: the upper one's top
