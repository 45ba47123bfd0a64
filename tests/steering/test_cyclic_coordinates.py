"""Which entries of the state do not matter: by what a person sees, and by the motion itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.steering import cyclic_coordinates
from tests.scenes import true_states

Scenes = Callable[..., PlanningTask]

POINT = (
    '\n[[goal.point]]\nbody = "coin"\nat = [0.25, 0, 0]\nposition = [0, 0, 0.5]\ntolerance = 0.1\n'
)
AXIS = (
    '\n[[goal.direction]]\nbody = "coin"\naxis = [1, 0, 0]\ntarget = [0, 0, 1]\ntolerance = 0.2\n'
)
CONE = '\n[[keep_out]]\nbody = "coin"\naxis = [1, 0, 0]\ndirection = [0, 0, 1]\nhalf_angle = 0.3\n'


def names(problem: PlanningTask) -> set[str]:
    return {
        n
        for n, free in zip(problem.model.state_names, cyclic_coordinates(problem), strict=True)
        if free
    }


@pytest.mark.parametrize(
    ("machine", "free"),
    [
        ("car", {"phi"}),
        ("drive", {"phi_l", "phi_r"}),
        ("coin", {"phi"}),
        ("crane", set()),
        ("pendulum", set()),
        ("two_cranes", set()),
        ("submarine", set()),
        ("cart", set()),
    ],
)
def test_only_the_rotation_of_wheels_is_ignorable(
    machine: str, free: set[str], scenes: Scenes
) -> None:
    assert names(scenes(machine)) == free


def test_a_snakeboards_rotor_and_steering_matter() -> None:
    """Its bar is seen from everywhere; the rotation of its wheels is not."""
    assert names(kinolab.load("snakeboard_park")) == {"s"}


@pytest.mark.parametrize("wish", ["goal.phi=1.0", "bounds.phi=[-9.0, 9.0]"])
def test_a_goal_or_a_limit_makes_a_wheels_rotation_matter(wish: str, scenes: Scenes) -> None:
    assert names(scenes("coin", wish)) == set()


@pytest.mark.parametrize("wish", [POINT, AXIS, CONE])
def test_a_goal_or_a_cone_of_a_point_or_an_axis_of_the_wheel_makes_it_matter(
    wish: str, scenes: Scenes
) -> None:
    assert names(scenes("coin", text=wish)) == set()


def test_a_heading_that_only_steers_a_force_matters(scenes: Scenes) -> None:
    """A round puck looks the same at every heading, and glides the same without thrust."""
    assert names(scenes("puck")) == set()


@pytest.mark.parametrize("machine", ["car", "drive", "coin"])
def test_what_is_ignorable_changes_no_motion_of_the_rest(machine: str, scenes: Scenes) -> None:
    problem = scenes(machine)
    free, generator = cyclic_coordinates(problem), np.random.default_rng(3)
    x = problem.sample_goal(generator)
    turned = np.where(free, x + 1.7, x)
    u = generator.uniform(*problem.model.control_bounds.T, (5, problem.model.nu))
    one, other = (true_states(problem, start, u) for start in (x, turned))
    assert one[:, ~free] == pytest.approx(other[:, ~free], abs=1e-9)
