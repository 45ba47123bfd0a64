"""A descent goes on for a while before it counts as stuck: its lowest point is what is reported."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from kinolab.numerics.arrays import Array
from kinolab.search import Budget
from kinolab.search.potential.descent import Ending, PartialMotion
from kinolab.search.potential.random_walk_escapes import RandomWalkEscapes
from tests.support import OPEN, problem_of


class Bowl:
    """A field whose potential is the square of x - 0.25 m, and 1 m."""

    def potential(self, states: Array) -> Array:
        """Return it at states (n, nx)."""
        return 1.0 + (states[:, 0] - 0.25) ** 2


class Overshooting:
    """A descent that comes past the lowest point and is stuck 0.1 m behind it."""

    def follow(self, trail: PartialMotion, _: Any, __: Any) -> Ending:
        """Go to 0.2, 0.26 and 0.35 m."""
        for x in (0.2, 0.26, 0.35):
            state = trail.end.copy()
            state[0] = x
            trail.add(np.zeros(2), state)
        return Ending.MINIMUM


def test_the_minimum_that_is_reported_is_the_lowest_point_of_the_descent(tmp_path: Any) -> None:
    problem = problem_of(tmp_path, OPEN)
    parts: Any = (Bowl(), Overshooting(), None, None, 0, lambda _: True)
    escapes = RandomWalkEscapes(*parts)
    ending, nearest = escapes.search(problem, np.random.default_rng(0), Budget(60.0))
    assert ending is Ending.MINIMUM
    place = escapes.statistics(problem)
    assert place["minimum_x"] == 0.26
    assert place["minimum_potential"] == pytest.approx(1.0001)
    # the motion ends where it is nearest to the goal, which is at x = 0
    assert nearest.end[0] == 0.2
