"""Certified room against FCL and against distances that are known."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.problem import Problem
from kinolab.world.certified import MARGIN, Room, surroundings

SCENARIOS = ("rolling_disk_maze", "vehicle_parking", "crane_factory", "submarine_corridor")
POSES = 3000


def room_of(problem: Problem) -> Room:
    return Room(
        surroundings(
            problem.bodies,
            problem.world,
            cables=problem.cables,
            self_pairs=problem.system.collisions,
        )
    )


def states(problem: Problem) -> np.ndarray:
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
        assert free or checker.clearance(*placed) <= 1.5 * MARGIN


@pytest.mark.parametrize("name", SCENARIOS)
def test_room_is_the_clearance_where_it_is_worked_out(name: str) -> None:
    problem = kinolab.load(name)
    room, checker = room_of(problem), problem.checker()
    for x in states(problem)[: POSES // 5]:
        placed = problem.placement(x)
        known = checker.clearance(*placed)
        if known > 2 * MARGIN:
            exact = room.within(*placed, 0.3)
            assert exact == pytest.approx(min(known - MARGIN, 0.3), abs=1.1 * MARGIN)
            assert room.within(*placed, 0.3, 0.02) <= known
