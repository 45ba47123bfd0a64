"""A world of which obstacles have moved: told by a second engine, FCL, and without a new grid."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinolab.problem.moved import with_obstacles_at
from kinolab.world.collision.clearance_bound import ClearanceBound
from kinolab.world.collision.collision_scene import collision_scene
from kinolab.world.distances import distance_field_cache
from tests.support import OPEN, problem_of

WORLD = """
[[world.obstacle]]
name = "crate"
box = [0.3, 0.3, 0.6]
position = [2.0, 3.0, 0.3]

[[world.obstacle]]
name = "post"
cylinder = [0.1, 1.0]
position = [-2.0, 0.0, 0.5]
"""


def test_clearance_is_that_of_where_obstacles_are_now(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    task = problem_of(tmp_path, OPEN + WORLD)
    bodies = task.bodies
    collision_scene(bodies, task.world)  # which has its grid now

    def refused(*_: object) -> None:
        raise AssertionError("a grid is built anew")

    monkeypatch.setattr(distance_field_cache, "distance_field", refused)
    rng = np.random.default_rng(3)
    for _ in range(40):
        place = (*rng.uniform(-2.0, 2.0, size=2), 0.3)
        task = with_obstacles_at(task, {"crate": place})
        bound = ClearanceBound(collision_scene(bodies, task.world))
        x = task.start.copy()
        x[:3] = rng.uniform(-2.0, 2.0, size=3)
        poses, ends = task.placement(x)
        true = float(task.checker().clearances(poses[None], ends[None], 9.0)[0])
        found = bound.within(poses, ends, 9.0)
        assert found <= max(true, 0.0) + 1e-6
        assert bool(found > 0.0) is (not task.checker().collides(poses, ends))
