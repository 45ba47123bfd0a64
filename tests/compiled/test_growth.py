"""Trees that compiled loops grow: every motion in them is free, and leads where it says."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.compiled import AbstractCompiledPlanner
from kinolab.compiled.planner import search_of
from kinolab.errors import InputError
from kinolab.problem import Problem
from tests.support import OPEN, problem_of

COMPILED = ("rrt_fast", "kpiece_fast")
SCENES = ("rolling_disk_maze", "vehicle_parking", "two_cranes")
MOTIONS = 100  # of a tree that are looked at
LOOKS = 50  # per step


def grown(name: str, problem: Problem, iterations: int) -> Any:
    settings = planners.get(name)()
    assert isinstance(settings, AbstractCompiledPlanner)
    growth = settings.growth(problem, search_of(problem, settings.goal_zoom, 1))
    growth.begin()
    growth.grow(iterations)
    return growth.nodes


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", COMPILED)
def test_no_motion_of_a_tree_touches_anything_on_its_way(name: str, scene: str) -> None:
    problem = kinolab.load(scene)
    tree, model = grown(name, problem, 2000), problem.model
    size, checker = int(tree.size[0]), problem.checker()
    assert size > 20
    random = np.random.default_rng(0)
    method = problem.scenario.integration.method
    for node in random.integers(1, size, MOTIONS):
        x, u = tree.x[tree.parent[node]], tree.u[node]
        for _ in range(tree.steps[node]):
            share = random.uniform(0, problem.step, LOOKS)
            for h in share:
                between = model.step(x, u, h, method=method)
                assert not checker.collides(*problem.placement(between))
            x = model.step(x, u, problem.step, method=method)
            assert not list(problem.limit_violations(x))
        np.testing.assert_allclose(x, tree.x[node], rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", COMPILED)
def test_a_full_tree_makes_room_for_a_new_one(name: str, table: Problem) -> None:
    found = (
        table.solve(planner=name, seed=1, max_iterations=3000, max_nodes=64, goal_bias=0.0)
        if name == "rrt_fast"
        else table.solve(planner=name, seed=1, max_iterations=3000, max_nodes=64)
    )
    assert found.statistics["nodes"] <= 64


@pytest.mark.parametrize("name", COMPILED)
def test_what_is_not_checked_is_refused(name: str, tmp_path: Any) -> None:
    cone = (
        '\n[[keep_out]]\nbody = "coin"\naxis = [0, 1, 0]\ndirection = [0, 0, 1]\nhalf_angle = 0.1\n'
    )
    with pytest.raises(InputError, match="cones"):
        problem_of(tmp_path, OPEN + cone).solve(planner=name, seed=1, max_iterations=10)
