"""The page shows where a search has been."""

from __future__ import annotations

import numpy as np

import kinolab
from kinolab.runs import facts_of_plan
from kinolab.show.scene.scenes import content_of


def test_the_tree_joins_the_places_of_the_machine_in_the_states_that_were_joined() -> None:
    """The disk's centre is above its contact, at x, y: the first two entries of the state."""
    problem = kinolab.load("rolling_disk_maze")
    plan = problem.solve(planner="rrt_fast", seed=1, max_iterations=200, optimize=False)
    assert plan.graph is not None
    tree = content_of(problem, plan.trajectory, facts_of_plan(problem, plan), plan.graph).tree
    assert tree is not None
    assert np.allclose(tree[:, :, :2], plan.graph.x[plan.graph.edges][:, :, :2])
    assert np.allclose(tree[:, :, 2], 0.25)  # [m], its radius
    assert content_of(problem, plan.trajectory, facts_of_plan(problem, plan)).tree is None
