"""What a machine demands is kept where a step begins: inputs jump there, and forces with them."""

from __future__ import annotations

import numpy as np
import pytest

from tests.gripping_coin import grip, gripping_maze
from tests.search.tree.test_tree import COMPILED, grown

ROUNDING = 1e-9  # [N^2]


@pytest.mark.parametrize("name", COMPILED)
def test_no_motion_of_a_tree_slips_where_it_begins(name: str) -> None:
    problem = gripping_maze()
    tree = grown(name, problem, 3000)
    nodes = np.arange(1, int(tree.size[0]))
    assert len(nodes) > 100
    left = grip(tree.x[tree.parent[nodes]], tree.u[nodes])
    assert left.min() >= -ROUNDING
    assert left.min() < 0.2 * left.max()  # and some of them nearly do


@pytest.mark.parametrize("name", COMPILED)
def test_a_coin_with_little_friction_gets_through_the_maze(name: str) -> None:
    """Its motion is verified, which looks at every instant."""
    problem = gripping_maze("planner.improve=0")
    most = {"max_iterations": 200_000, "time_limit": 600.0, "optimize": False}
    found = problem.solve(planner=name, seed=2, **most)
    assert found.status == "solved", found.message
    assert found.trajectory is not None
    assert grip(found.trajectory.x[:-1], found.trajectory.u).min() >= -ROUNDING
