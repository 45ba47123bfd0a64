"""Motions of what hangs from ropes are made exact: a rope that collides, and one that may sway."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import kinolab
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.trajopt import make_exact
from tests.support import failed, problem_of
from tests.trajopt.test_trajopt import EXACT, repaired
from tests.verification.test_cables import SCENARIO, crane

REST = "x = 2.0\nl = 3.0\nat_rest = true\ntolerance = 0.3"
SWAYING = """
schema = 1
title = "A crane carries its load a little way and stops its sway"
system = { name = "crane" }
[bounds]
x = [1, 23]
y = [1, 13]
[start]
x = 3.0
y = 3.0
l = 7.8
[goal]
x = 5.0
y = 4.0
l = 6.8
theta_x = 0.0
theta_y = 0.0
at_rest = true
tolerance = 0.1
[integration]
step = 0.25
"""


def test_a_rope_is_led_over_a_beam_when_its_load_is_set_down_exactly(tmp_path: Path) -> None:
    """A load that went below the beam would be free, but its rope would not."""
    (tmp_path / "machine.json").write_text(machine_to_json(crane()))
    text = SCENARIO.replace("x = 2.0\ntolerance = 0.5", REST).replace('"rrt"', '"auto"')
    problem = problem_of(tmp_path, text)
    plan = problem.solve(seed=1, time_limit=60.0, optimize=False)
    assert plan.trajectory is not None
    exact = make_exact(problem, plan.trajectory)
    assert exact is not None
    assert problem.goal_distance(exact.x[-1]) < EXACT
    assert "collision" not in failed(kinolab.verify(problem, exact))
    at = {name: exact.x[:, k] for k, name in enumerate(exact.state_names)}
    over = np.abs(at["x"] - 1.0) < 0.05  # the beam is 0.1 m wide, and its top 2.05 m high
    assert over.any()
    assert (4.0 - at["l"][over] > 2.05 + 0.1).all()  # half the load hangs below


def test_a_crane_that_may_sway_stops_exactly_where_it_must(tmp_path: Path) -> None:
    """It is stiff: dozens of small steps make one of its motion."""
    repaired(problem_of(tmp_path, SWAYING), 24)
