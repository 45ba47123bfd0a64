"""What moves a machine's shape, and how far, in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.analyze.diagnose.narrow_passage.motion_per_coordinate import motion_per_coordinate
from tests.analyze.diagnose.scenarios import PENDULUM
from tests.support import OPEN, problem_of


def test_a_coins_roll_moves_nothing(tmp_path: Path) -> None:
    """Its heading moves its rim, at R = 0.25 m."""
    problem = problem_of(tmp_path, OPEN)
    assert motion_per_coordinate(problem, []) == pytest.approx([1, 1, 0.25, 0, 0, 0], abs=1e-6)


def test_a_roll_that_the_goal_asks_for_matters(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN, "goal.phi=1")
    assert motion_per_coordinate(problem, [])[3] > 0


def test_a_pendulums_angle_moves_its_bob_and_its_rod(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, PENDULUM)
    # [m]: l and the rod's radius
    assert motion_per_coordinate(problem, []) == pytest.approx([1.02, 0.0], abs=1e-4)


def test_an_attitude_moves_a_hull_by_its_length() -> None:
    """A quaternion's entry changes by half of the angle."""
    problem = kinolab.load("submarine_corridor")
    far = motion_per_coordinate(problem, [problem.start])
    first = problem.model.attitudes["R"]
    assert far[:3] == pytest.approx(1.0, abs=1e-6)
    assert len(set(far[first : first + 4].tolist())) == 1
    assert far[first] > 0
    assert np.all(far[problem.model.nq :] == 0)
