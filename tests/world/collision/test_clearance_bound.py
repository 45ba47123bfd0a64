"""Certified room against FCL and against distances that are known."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.distances.triangle_gaps import TOUCHING_MARGIN

SCENARIOS = (
    "rolling_disk_maze",
    "vehicle_parking",
    "crane_factory",
    "submarine_corridor",
    "diffdrive_warehouse",
)
POSES = 3000


def room_of(problem: PlanningTask) -> ClearanceBound:
    return ClearanceBound(
        collision_scene(
            problem.bodies,
            problem.world,
            cables=problem.cables,
            self_pairs=problem.system.collisions,
        )
    )


def states(problem: PlanningTask) -> np.ndarray:
    random = np.random.default_rng(1)
    x = random.uniform(*problem.sampling_bounds.T, (POSES, problem.model.nx))
    for first in problem.model.attitudes.values():
        q = random.normal(size=(POSES, 4))
        x[:, first : first + 4] = q / np.linalg.norm(q, axis=1, keepdims=True)
    return x


@pytest.mark.parametrize("name", SCENARIOS)
def test_no_pose_is_called_free_that_fcl_calls_in_collision(name: str) -> None:
    """And none in collision that is free, but for the margin."""
    problem = kinolab.load(name)
    room, checker = room_of(problem), problem.checker()
    for x in states(problem):
        placed = problem.placement(x)
        free = room.within(*placed, 1e-9) > 0.0
        assert not (free and checker.collides(*placed))
        assert free or checker.clearance(*placed) <= 1.5 * TOUCHING_MARGIN


@pytest.mark.parametrize("name", SCENARIOS)
def test_room_is_the_clearance_where_it_is_worked_out(name: str) -> None:
    problem = kinolab.load(name)
    room, checker = room_of(problem), problem.checker()
    for x in states(problem)[: POSES // 5]:
        placed = problem.placement(x)
        known = checker.clearance(*placed)
        if known > 2 * TOUCHING_MARGIN:
            exact = room.within(*placed, 0.3)
            assert exact == pytest.approx(
                min(known - TOUCHING_MARGIN, 0.3), abs=1.1 * TOUCHING_MARGIN
            )
            assert room.within(*placed, 0.3, 0.02) <= known


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_machine_that_is_pushed_against_an_obstacle_is_refused_before_fcl_sees_it_touch(
    name: str,
) -> None:
    """The gaps that FCL calls touching are a few micrometres wide."""
    problem = kinolab.load(name)
    room, checker, random = room_of(problem), problem.checker(), np.random.default_rng(2)
    upright, met = name in ("crane_factory", "submarine_corridor"), 0
    for x in states(problem)[: POSES // 5]:
        poses, ends = problem.placement(x)
        push = random.normal(size=3) * [1.0, 1.0, upright]
        push /= np.linalg.norm(push)
        poses, ends = poses.reshape(-1, 3, 4).copy(), ends.reshape(-1, 2, 3).copy()

        def pushed(way: float, poses=poses, ends=ends, push=push):  # type: ignore[no-untyped-def]
            moved = poses.copy()
            moved[:, :, 3] += way * push
            return moved.reshape(-1, 12), (ends + way * push).reshape(-1, 6)

        way, free = 0.0, room.within(*pushed(0.0), 0.5)
        if not 0.0 < free < 0.4:
            continue
        for _ in range(100):
            way += max(free, 1e-7)
            free = room.within(*pushed(way), 0.5)
            if free < 1e-6 or way > 5.0:
                break
        if 0.0 < free < 1e-6:
            met += 1
            assert not checker.collides(*pushed(way))
    assert met > 5
