"""Signed gaps are those of plane geometry, and agree with the verifier's own collision library."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints
from kinolab.trajopt.nlp.path_constraints import Samples
from tests.support import OPEN, WALL, problem_of

RADIUS, HALF = 0.25, 0.025  # [m] of the coin: radius, half thickness
FACE = 3.0 - 0.05  # [m] where the wall's face towards the coin is


def at(problem: PlanningTask, *states: list[float]) -> Samples:
    x = np.array(states, dtype=float)
    count = len(x)
    u = np.zeros((count, problem.model.nu))
    return Samples(np.arange(count), np.zeros(count), x, u)


@pytest.fixture(scope="module")
def walled(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    return problem_of(tmp_path_factory.mktemp("walled"), OPEN + WALL, "world.ground=none")


@pytest.mark.parametrize("x", [2.4, 2.69, 2.75, 2.9])
def test_the_gap_to_a_wall_is_the_distance_to_its_face_negative_inside(
    walled: PlanningTask, x: float
) -> None:
    rows = CollisionConstraints(walled, 0.0).rows(at(walled, [x, 0, 0, 0, 0, 0]), 1.0)
    assert rows.value == pytest.approx([FACE - x - RADIUS], abs=1e-8)
    assert rows.dx[0, :2] == pytest.approx([-1.0, 0.0], abs=1e-8)


def test_a_gap_follows_the_turn_of_a_coin_as_its_outline_does(walled: PlanningTask) -> None:
    """From above the coin is a rectangle: R |cos psi| + b |sin psi| towards the wall."""
    psi = 0.4
    rows = CollisionConstraints(walled, 0.0).rows(at(walled, [2.5, 0, psi, 0.3, 0, 0]), 1.0)
    reach = RADIUS * np.cos(psi) + HALF * np.sin(psi)
    slope = RADIUS * np.sin(psi) - HALF * np.cos(psi)
    assert rows.value == pytest.approx([FACE - 2.5 - reach], abs=1e-8)
    assert rows.dx[0] == pytest.approx([-1, 0, slope, 0, 0, 0], abs=1e-7)


@pytest.mark.parametrize(
    "name", ["rolling_disk_maze", "vehicle_parking", "crane_factory", "motorcycle_chicane"]
)
def test_what_touches_has_no_gap_and_what_is_free_has_the_certified_one(name: str) -> None:
    """The checker asks FCL; its own clearance is proved, and 3e-5 m short at most."""
    problem = kinolab.load(name)
    obstacles, checker = CollisionConstraints(problem, 0.0), problem.checker()
    generator = np.random.default_rng(3)
    for x in generator.uniform(*problem.sampling_bounds.T, (60, problem.model.nx)):
        gap = float(obstacles.rows(at(problem, list(x)), 10.0).value.min(initial=np.inf))
        assert obstacles.free(x[None]) == (gap > 1e-12)  # [m], rounding
        placement = problem.placement(x)
        assert checker.collides(*placement) == (gap <= 1e-5)
        clearance = checker.clearance(*placement)
        if 1e-4 < clearance < 0.2:
            assert gap >= clearance - 1e-9
