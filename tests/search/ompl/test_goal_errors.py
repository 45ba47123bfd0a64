"""How near the goal a state is, against the goal's own measure."""

from __future__ import annotations

import numpy as np
import pytest

import kinolab
from kinolab.search.ompl.goal_errors import GoalErrors

NAMES = (
    *("crane_factory", "rolling_disk_maze", "satellite_pointing", "submarine_corridor"),
    "vehicle_parking",
)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("reach", [0.999, 4.0])
def test_the_largest_share_is_the_goals_excess(name: str, reach: float) -> None:
    """Attitudes are compared by an arc cosine, whose error is some 1e-8 rad near 0."""
    problem = kinolab.load(name)
    nearness, generator, found = GoalErrors(problem, reach), np.random.default_rng(0), 0
    for spread in generator.uniform(0.1, 8.0, 300):
        x = problem.sample_goal(generator, spread)
        shares, excess = nearness.fractions(x.tolist()), problem.goal_excess(x)
        if shares is None:
            assert excess > reach - 1e-6
        else:
            found += 1
            assert len(shares) == nearness.size
            assert max(map(abs, shares)) == pytest.approx(excess, abs=1e-6)
    assert 0 < found < 300
