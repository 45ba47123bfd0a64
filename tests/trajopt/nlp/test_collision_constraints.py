"""Distances of three balls on a plane from each other, by a closed form."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from kinolab.dynamics import Body, Force, Sphere, System, length, move
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.numerics.arrays import Array
from kinolab.problem import PlanningTask
from kinolab.trajopt.nlp.collision_constraints import CollisionConstraints
from kinolab.trajopt.nlp.path_constraints import Samples
from tests.support import problem_of

RADII = (0.1, 0.2, 0.3)
PAIRS = list(combinations(range(3), 2))
SCENARIO = """
schema = 1
title = "Three balls"
[system]
file = "balls.json"
[start]
x0 = -2.0
x1 = 0.0
x2 = 2.0
[goal]
x0 = 0.0
tolerance = 9.0
"""


@pytest.fixture
def balls(tmp_path: Path) -> PlanningTask:
    places = [[length(f"{c}{k}", -9.0, 9.0, speed=9.0) for c in "xy"] for k in range(3)]
    bodies = [
        Body(f"ball {k}", move(*place, 0), mass=1.0, shape=Sphere(radius))
        for k, (place, radius) in enumerate(zip(places, RADII, strict=True))
    ]
    push = Force("push", on=bodies[0], along=bodies[0].frame.x, limit=1.0)
    kept = [(f"ball {a}", f"ball {b}") for a, b in PAIRS]
    machine = System("balls", bodies=bodies, inputs=[push], collisions=kept)
    (tmp_path / "balls.json").write_text(machine_to_json(machine))
    return problem_of(tmp_path, SCENARIO)


def test_bodies_of_a_machine_part_along_the_line_between_them(balls: PlanningTask) -> None:
    names = list(balls.model.coordinate_names)
    q = np.random.default_rng(1).uniform(-1.0, 1.0, size=(20, 6))
    x: Array = np.hstack([q, np.zeros_like(q)])
    nothing = np.zeros(20)
    at = Samples(np.arange(20), nothing, x, nothing[:, None])
    found = CollisionConstraints(balls, clearance=0.05, near=1e9).rows(at, reach=1e9)
    assert len(found.value) == len(PAIRS) * len(x)
    for k in range(20):
        place = [q[k, [names.index(f"x{b}"), names.index(f"y{b}")]] for b in range(3)]
        rows = np.flatnonzero(found.knot == k)
        for row, (a, b) in zip(rows, PAIRS, strict=True):
            apart = place[b] - place[a]
            gap = np.linalg.norm(apart) - RADII[a] - RADII[b]
            assert found.value[row] == pytest.approx(gap - 0.05, abs=1e-7)
            slopes = np.zeros(12)
            for sign, body in ((-1.0, a), (1.0, b)):
                entries = [names.index(f"x{body}"), names.index(f"y{body}")]
                slopes[entries] = sign * apart / np.linalg.norm(apart)
            np.testing.assert_allclose(found.dx[row], slopes, atol=1e-6)
