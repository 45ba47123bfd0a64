"""Curves of wheeled machines: tangents are headings, bends are within reach, ends are ends."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinolab.problem import PlanningTask
from kinolab.steering import Steering
from kinolab.steering.plane_curves import PlanePaths

Scenes = Callable[..., PlanningTask]
Array = np.ndarray

ROLLING = ("car", "coin", "drive")
TIGHTEST = np.tan(0.6) / 2.7  # [1/m] of a car whose wheels turn by 0.6 rad, 2.7 m apart


def all_ways(problem: PlanningTask, x0: Array, x1: Array) -> list[list[object]]:
    known = ways(problem)
    return [*known.paths(x0, x1), *known.detours(x0, x1)]


def ways(problem: PlanningTask) -> PlanePaths:
    found = Steering(problem).family
    assert isinstance(found, PlanePaths)
    return found


def poses(problem: PlanningTask, seed: int) -> tuple[Array, Array]:
    generator = np.random.default_rng(seed)
    x0, x1 = np.zeros((2, problem.model.nx))
    x0[:3], x1[:3] = generator.uniform([-3, -3, -3], [3, 3, 3], (2, 3))
    return x0, x1


def along(path: object, count: int = 1201) -> Array:
    share = np.linspace(0, 1, count)
    return path(share, np.ones(count), np.zeros(count))  # type: ignore[operator,no-any-return]


@pytest.mark.parametrize("machine", ROLLING)
@pytest.mark.parametrize("seed", range(6))
def test_every_way_leads_from_the_beginning_to_the_end_without_a_gap(
    machine: str, seed: int, scenes: Scenes
) -> None:
    problem = scenes(machine)
    x0, x1 = poses(problem, seed)
    found = all_ways(problem, x0, x1)
    assert found
    for paths in found:
        here = x0[: paths_width(problem)]
        for path in paths:
            rows = along(path, 3)
            assert rows[0] == pytest.approx(here, abs=1e-6)
            here = rows[-1]
        assert here[:2] == pytest.approx(x1[:2], abs=1e-6)
        turned = (here[2] - x1[2] + np.pi) % (2 * np.pi) - np.pi
        assert turned == pytest.approx(0.0, abs=1e-6)


def paths_width(problem: PlanningTask) -> int:
    """How many coordinates come first in the state and are those of the paths."""
    return len(Steering(problem).family.coordinates)


@pytest.mark.parametrize("machine", ROLLING)
@pytest.mark.parametrize("seed", range(6))
def test_every_way_points_along_the_heading_or_against_it(
    machine: str, seed: int, scenes: Scenes
) -> None:
    """Chords of a thousandth of the way are parallel to the heading in their middle."""
    problem = scenes(machine)
    for paths in all_ways(problem, *poses(problem, seed)):
        for path in paths:
            rows = along(path)
            step, heading = np.diff(rows[:, :2], axis=0), (rows[1:, 2] + rows[:-1, 2]) / 2
            aside = step[:, 1] * np.cos(heading) - step[:, 0] * np.sin(heading)
            assert np.abs(aside).max() < 2e-4 * max(1.0, np.hypot(*step.T).sum())


@pytest.mark.parametrize("seed", range(10))
def test_a_car_drives_no_curve_that_its_steering_does_not_reach(seed: int, scenes: Scenes) -> None:
    """And where it stands on its steering, tan(delta) / L is the curve's bend."""
    car = scenes("car")
    for paths in all_ways(car, *poses(car, seed)):
        for path in paths:
            rows = along(path)
            gone = np.hypot(*np.diff(rows[:, :2], axis=0).T)
            assert np.abs(rows[:, 3]).max() <= 0.6
            if gone.sum() < 1e-3:
                continue  # only the steering moves
            turned = np.diff(rows[:, 2])
            assert (np.abs(turned) <= TIGHTEST * gone * (1 + 1e-3) + 1e-9).all()
            bend = np.tan((rows[1:, 3] + rows[:-1, 3]) / 2) / 2.7
            assert np.abs(turned) == pytest.approx(np.abs(bend) * gone, abs=2e-3 * gone.max())


def test_the_tightest_circle_of_a_car_is_a_little_wider_than_the_steering_allows(
    scenes: Scenes,
) -> None:
    radius = ways(scenes("car")).radius
    assert 1 / TIGHTEST < radius < 1.2 / TIGHTEST
    assert ways(scenes("drive")).radius == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_a_car_is_led_straight_into_the_end(seed: int, scenes: Scenes) -> None:
    """Forward and back, over quarters of the tightest circle's radius."""
    car = scenes("car")
    x0, x1 = poses(car, seed)
    along_end = np.array([np.cos(x1[2]), np.sin(x1[2])])
    led = set()
    for paths in ways(car).detours(x0, x1):
        rows = along(paths[-1], 9)
        if np.abs(rows[:, 3]).max() == 0.0 and np.ptp(rows[:, 2]) == 0.0:
            led.add(round(float((rows[-1, :2] - rows[0, :2]) @ along_end) / ways(car).radius, 6))
    assert led == {0.25, 0.5, 1.0, -0.25, -0.5, -1.0}


def test_turned_wheels_are_straightened_before_a_smooth_curve(scenes: Scenes) -> None:
    car = scenes("car")
    x0, x1 = np.zeros((2, 7))
    x0[3], x1[0] = 0.4, 10.0
    first, smooth = next(ways(car).paths(x0, x1))
    assert along(first, 3)[:, 3] == pytest.approx([0.4, 0.2, 0.0])
    assert np.ptp(along(first)[:, :3]) == 0.0
    assert along(smooth)[[0, -1], :3] == pytest.approx(np.array([[0, 0, 0], [10.0, 0, 0]]))


def test_a_car_turns_its_wheels_where_it_stands(scenes: Scenes) -> None:
    car = scenes("car")
    x0 = np.zeros(7)
    x1 = np.array([0, 0, 0, 0.3, 0, 0, 0])
    ((path,),) = list(ways(car).paths(x0, x1))
    rows = along(path, 5)
    assert rows[:, :3] == pytest.approx(np.zeros((5, 3)))
    assert rows[:, 3] == pytest.approx(np.linspace(0, 0.3, 5))


@pytest.mark.parametrize("machine", ROLLING)
def test_from_a_pose_to_itself_there_is_nothing_to_do(machine: str, scenes: Scenes) -> None:
    problem = scenes(machine)
    x = np.zeros(problem.model.nx)
    assert all(paths == [] for paths in ways(problem).paths(x, x))
    assert list(Steering(problem).steer(x, x)) == []


@pytest.mark.parametrize("turn", [np.pi, -np.pi, np.pi / 2, 3.5 * np.pi])
def test_a_robot_turns_on_the_spot_the_short_way(turn: float, scenes: Scenes) -> None:
    drive = scenes("drive")
    x1 = np.zeros(7)
    x1[2] = turn
    for (path,) in ways(drive).paths(np.zeros(7), x1):
        rows = along(path, 50)
        assert np.abs(rows[:, :2]).max() == 0.0
        assert np.abs(rows[:, 2]).max() <= np.pi + 1e-9


def test_wheels_are_straightened(scenes: Scenes) -> None:
    car = scenes("car")
    x = np.array([1.0, 2, 3, 0.4, 5, 0, 0])
    assert ways(car).straightened(x) == pytest.approx([1, 2, 3, 0, 5, 0, 0], abs=1e-15)
    assert x[3] == 0.4
