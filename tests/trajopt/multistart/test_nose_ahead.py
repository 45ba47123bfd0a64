"""Guesses turn a machine whose nose must lead along each leg of their path."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from kinolab.trajopt.multistart.headings import turned_for_requirements
from tests.support import problem_of

OPEN_SKY = """
schema = 1
title = "A helicopter in the open"
system = { name = "helicopter" }
[bounds]
x = [-50, 50]
y = [-50, 50]
z = [0, 20]
[start]
z = 5.0
[goal]
x = 20.0
z = 5.0
tolerance = 0.5
[integration]
step = 0.05
"""
BETA, DRIFT = 0.4, 2.0  # [rad], [m/s]: of the machine's own requirement


def test_the_nose_points_along_each_leg_that_is_flown_fast(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN_SKY)
    legs = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 20.0], [0.0, 20.0]])  # [m]: ahead, left, back
    path = np.repeat(problem.start[None], len(legs), axis=0)
    path[:, :2] = legs
    seconds = 4.0  # [s] for each leg: 5 m/s

    made = turned_for_requirements(problem, path, lambda _: seconds)

    np.testing.assert_array_equal(made[[0, -1]], path[[0, -1]])
    for begin, end in itertools.pairwise(made):
        moved = (end - begin)[:2]
        if not moved.any():
            continue  # a turn on the spot
        x, y, z, w = begin[3:7]
        nose = np.array([1 - 2 * (y * y + z * z), 2 * (x * y + z * w)])  # first column of R
        ahead, aside = (
            nose @ moved / seconds,
            abs(nose[0] * moved[1] - nose[1] * moved[0]) / seconds,
        )
        assert aside <= (ahead + DRIFT) * np.tan(BETA) + 1e-9
    assert len(made) > len(path)


def test_a_slow_leg_may_be_flown_sideways(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, OPEN_SKY)
    path = np.repeat(problem.start[None], 2, axis=0)
    path[1, 1] = 5.0
    np.testing.assert_array_equal(turned_for_requirements(problem, path, lambda _: 10.0), path)
