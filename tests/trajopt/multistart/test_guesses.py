"""Guesses: how quick they may be, which way they turn, and where they begin and end."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab.problem import PlanningTask
from kinolab.trajopt.multistart.guesses import Guesses
from kinolab.trajopt.multistart.headings import turned_along
from tests.support import problem_of

Array = NDArray[np.float64]

FASTEST = 0.5  # [m/s] of the unicycle, and [rad/s]
# Share by which what is seen in 200 random states may be slower than the limit: 200 a 4 e / (3 pi)
# of them, where a = sqrt(2 e), are not slower than that along an axis; for e = 0.1 these are four.
SEEN = 0.1
ROUNDING = 1e-12
DRIVE = """
schema = 1
title = "A robot drives"
system = { name = "unicycle1_v0" }
bounds = { x = [-3, 3], y = [-3, 3] }
[start]
theta = 3.0
[goal]
x = 2.0
y = 0.0
theta = -3.0
tolerance = 0.1
"""
SPEED_UP = """
schema = 1
title = "A robot speeds up"
system = { name = "unicycle2_v0" }
bounds = { x = [-3, 3], y = [-3, 3] }
[start]
v = 0.3
[goal]
x = 2.0
tolerance = 0.1
"""
FLY = """
schema = 1
title = "A rotor turns over"
system = { name = "quad3d_v0" }
bounds = { x = [-2, 2], y = [-2, 2], z = [0, 2] }
[start]
z = 1.0
R = [0, 0, 0, 1]
[goal]
x = 1.0
y = 0.0
z = 1.0
R = [0, 0, 0.9, -0.4358898943540674]
tolerance = 0.1
"""


def guesses(problem: PlanningTask, seed: int = 1) -> Guesses:
    return Guesses(problem, np.random.default_rng(seed))


CAR = """
schema = 1
title = "A car in a hall"
system = {{ name = "{}" }}
bounds = {{ x = [0, 8], y = [0, 8] }}
[start]
x = 1.0
y = 6.0
[goal]
x = 4.0
y = 2.0
tolerance = 0.1
"""


@pytest.fixture
def drive(tmp_path: Path) -> PlanningTask:
    return problem_of(tmp_path, DRIVE)


# --- how quick ---


@pytest.mark.parametrize("distance", [0.5, 2.0])
def test_a_straight_drive_is_about_as_quick_as_the_limit_of_speed_allows(
    distance: float, drive: PlanningTask
) -> None:
    way = np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]])
    shortest = distance / FASTEST
    quickest = guesses(drive).quickest(way)
    assert shortest * (1 - ROUNDING) <= quickest <= shortest / (1 - SEEN)


def test_the_slowest_coordinate_decides_and_legs_add_up(drive: PlanningTask) -> None:
    """Turning by 2 rad takes longer than driving half a metre."""
    way = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 2.0], [1.5, 0.0, 2.0]])
    shortest = 2.0 / FASTEST + 1.0 / FASTEST
    quickest = guesses(drive).quickest(way)
    assert shortest * (1 - ROUNDING) <= quickest <= shortest / (1 - SEEN)


def test_standing_still_takes_no_time(drive: PlanningTask) -> None:
    assert guesses(drive).quickest(np.zeros((2, 3))) == 0.0


# --- where to ---


def test_straight_ways_take_the_shorter_turn(drive: PlanningTask) -> None:
    """From 3 rad to -3 rad it is 0.28 rad over the seam, not 6 rad back."""
    begin, end = guesses(drive).straight()
    assert np.array_equal(begin, drive.start)
    assert np.array_equal(end[:2], [2.0, 0.0])
    assert end[2] - begin[2] == pytest.approx(2 * np.pi - 6.0, abs=ROUNDING)


@pytest.mark.parametrize("turns", [-2, -1, 1, 3])
def test_further_turns_come_on_top_of_the_shortest(turns: int, drive: PlanningTask) -> None:
    begin, end = guesses(drive).straight([turns])
    assert end[2] - begin[2] == pytest.approx(2 * np.pi * (turns + 1) - 6.0, abs=ROUNDING)


def test_straight_ways_take_the_shorter_turn_of_attitudes_too(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, FLY)
    (first,) = problem.model.attitudes.values()
    begin, end = guesses(problem).straight()
    own, target = slice(first, first + 4), np.array(problem.goal.parts[0].target)
    assert begin[own] @ end[own] >= 0
    assert abs(end[own] @ target) == pytest.approx(1.0, abs=ROUNDING)


def test_what_the_goal_leaves_open_stays_but_speeds_vanish(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, SPEED_UP)
    begin, end = guesses(problem).straight()
    names = problem.model.state_names
    assert dict(zip(names, begin, strict=True))["v"] == 0.3
    assert dict(zip(names, end, strict=True)) == {"x": 2.0, "y": 0, "theta": 0, "v": 0, "w": 0}


@pytest.mark.parametrize("text", [DRIVE, FLY])
def test_winding_ways_keep_their_ends_but_for_whole_turns(text: str, tmp_path: Path) -> None:
    problem, vias = problem_of(tmp_path, text), set()
    straight, winding = guesses(problem).straight(), guesses(problem, 2)
    circles, (lower, upper) = problem.circular, problem.sampling_bounds.T
    for _ in range(20):
        begin, via, end = winding.winding()
        assert np.array_equal(begin, straight[0])
        assert np.array_equal(end[~circles], straight[1][~circles])
        turns = (end - straight[1])[circles] / (2 * np.pi)
        assert np.allclose(turns, np.round(turns), rtol=0, atol=ROUNDING)
        aside = np.abs(via - (begin + end) / 2)
        assert (aside <= 0.25 * (upper - lower) + ROUNDING).all()
        vias.add(via.tobytes())
    assert len(vias) == 20


# --- spread over a time ---


@pytest.mark.parametrize("text", [DRIVE, FLY])
def test_knots_lead_from_end_to_end_in_the_time_that_is_given(text: str, tmp_path: Path) -> None:
    problem = problem_of(tmp_path, text)
    way = guesses(problem).straight()
    knots = guesses(problem).knots(way, 37, 0.1)
    assert (knots.x.shape, knots.u.shape) == ((38, problem.model.nx), (37, problem.model.nu))
    assert knots.duration == pytest.approx(3.7, abs=ROUNDING)
    assert np.allclose(knots.x[[0, -1]], way, rtol=0, atol=ROUNDING)


def test_attitudes_at_knots_are_unit_quaternions(tmp_path: Path) -> None:
    """On the straight line in between they would get as short as 0.85."""
    problem = problem_of(tmp_path, FLY)
    (first,) = problem.model.attitudes.values()
    make = guesses(problem)
    for way in (make.straight(), make.winding()):
        knots = make.knots(way, 40, 0.05)
        lengths = np.linalg.norm(knots.x[:, first : first + 4], axis=1)
        assert np.allclose(lengths, 1.0, rtol=0, atol=ROUNDING)


def test_the_same_place_at_other_speeds_is_a_guess_too(tmp_path: Path) -> None:
    """Where no coordinate changes, states change evenly over the time."""
    problem = problem_of(tmp_path, SPEED_UP, "goal={ x = 0, v = 0, tolerance = 0.1 }")
    make = guesses(problem)
    knots = make.knots(make.straight(), 10, 0.1)
    v = problem.model.state_names.index("v")
    assert np.allclose(knots.x[:, v], np.linspace(0.3, 0.0, 11), rtol=0, atol=ROUNDING)


def test_inputs_are_near_the_middle_of_their_range(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, FLY)
    make = guesses(problem)
    lower, upper = problem.model.control_bounds.T
    share = (make.knots(make.straight(), 200, 0.05).u - lower) / (upper - lower)
    assert np.abs(share - 0.5).max() < 0.1  # ten standard deviations
    assert share.std() > 0


def test_cyclic_coordinates_of_a_guess_follow_from_its_velocities() -> None:
    """Wheels roll as far as they turn: in one step of a guess the two agree to second order."""
    problem = kinolab.load("diffdrive_warehouse")
    model = problem.model
    guesses = Guesses(problem, np.random.default_rng(0))
    knots = guesses.knots(guesses.straight(), 200, 0.1)
    wheels = [model.state_names.index(name) for name in ("phi_l", "phi_r")]
    speeds = [model.state_names.index(name) for name in ("phi_l_dot", "phi_r_dot")]
    rolled = np.diff(knots.x[:, wheels], axis=0)
    mean = (knots.x[1:, speeds] + knots.x[:-1, speeds]) / 2
    np.testing.assert_allclose(rolled, 0.1 * mean, atol=1e-9)  # [rad]
    assert np.abs(rolled).sum() > 1.0


def test_a_robot_turns_before_it_drives() -> None:
    """It cannot slip sideways: on the leg between its turns the heading is the leg's direction."""
    problem = kinolab.load("diffdrive_warehouse")
    begin = problem.start.copy()
    end = begin.copy()
    end[0], end[1] = begin[0] + 3.0, begin[1] + 4.0
    path = turned_along(problem, np.stack([begin, end]))
    psi = problem.model.state_names.index("psi")
    leg = int(np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).argmax())
    along = np.arctan2(4.0, 3.0)
    for heading in path[leg : leg + 2, psi]:
        assert abs(np.sin(heading - along)) < 0.02  # forward or backward
    np.testing.assert_array_equal(path[0], begin)
    assert path[-1][psi] == end[psi]


def test_a_trailer_follows_in_line(tmp_path: Path) -> None:
    """On a leg that neither the car nor its trailer may slip along both point along it."""
    problem = problem_of(tmp_path, CAR.format("car1_v0"))
    begin = problem.start.copy()
    end = begin.copy()
    end[:2] += 3.0, -4.0
    path = turned_along(problem, np.stack([begin, end]))
    leg = int(np.linalg.norm(np.diff(path[:, :2], axis=0), axis=1).argmax())
    along = np.arctan2(-4.0, 3.0)
    for x in path[leg : leg + 2]:
        assert np.abs(np.sin(x[2:4] - along)).max() < 0.02  # forward or backward
        assert x[2] == x[3]
    np.testing.assert_array_equal(path[[0, -1]], np.stack([begin, end]))


def test_what_cannot_stand_still_does_not_turn_on_the_spot(tmp_path: Path) -> None:
    """A Dubins car drives at 0.25 m/s at least."""
    problem = problem_of(tmp_path, CAR.format("unicycle1_v1"))
    path = np.array([[1.0, 6.0, 0.0], [4.0, 2.0, 0.0]])
    assert turned_along(problem, path) is path


def test_a_path_that_is_allowed_stays_as_it_is() -> None:
    """With all its whole turns: a pendulum may follow any path."""
    problem = kinolab.load("pendulum_swingup")
    path = Guesses(problem, np.random.default_rng(0)).straight([2])
    assert turned_along(problem, path) is path
