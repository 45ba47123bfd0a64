"""What is missing in the goal is nothing there, and its derivative is its slope."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinolab.trajopt.nlp.goal_constraint import GoalConstraint
from tests.support import OPEN, problem_of

TURNED = 2 * np.pi


def test_an_angle_may_end_at_the_nearest_of_its_turns(tmp_path: Path) -> None:
    text = OPEN.replace("tolerance = 0.5", "psi = 0.2\ntolerance = 0.5")
    problem = problem_of(tmp_path, text)
    end = np.array([0.0, 0.0, 3 * TURNED + 0.3, 0.0, 0.0, 0.0])
    miss = GoalConstraint(problem, end).residual(end)
    assert np.abs(miss).sum() == pytest.approx(0.1, abs=1e-12)


def test_points_of_bodies_are_led_to_their_targets(tmp_path: Path) -> None:
    """The coin's rim point (R, 0, 0) is at x + R cos phi, R - R sin phi above the ground."""
    text = OPEN.split("[goal]", maxsplit=1)[0] + (
        '[[goal.point]]\nbody = "coin"\nat = [0.25, 0, 0]\n'
        "position = [1.0, 0, 0.25]\ntolerance = 0.1\n"
    )
    problem = problem_of(tmp_path, text)
    ends, phi = GoalConstraint(problem, problem.start), 0.3
    x = np.array([0.4, 0.0, 0.0, phi, 0.0, 0.0])
    radius = 0.25
    expected = [0.4 + radius * np.cos(phi) - 1.0, 0.0, -radius * np.sin(phi)]
    assert ends.residual(x) == pytest.approx(expected, abs=1e-12)
    slopes = ends.jacobian(x)
    assert slopes[:, 0] == pytest.approx([1, 0, 0], abs=1e-8)
    assert slopes[:, 3] == pytest.approx(
        [-radius * np.sin(phi), 0, -radius * np.cos(phi)], abs=1e-8
    )
