"""The smallest clearance above the ground of a machine that glides, or dips, at speed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import Body, Drive, Sphere, System, length, move
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.simulation.reference import resimulate
from kinolab.verification import verify

SCENARIO = """
schema = 1
title = "A ball above the ground"
[system]
file = "machine.json"
[world]
ground = "plane"
{}
[start]
x_dot = 3.0
z = 1.0
z_dot = {}
[goal]
x = 6.0
tolerance = 0.5
[integration]
step = 0.1
"""
POST = """
[[world.obstacle]]
name = "post"
sphere = 0.5
position = [3.0, 1.0, 1.0]
"""


@pytest.mark.parametrize(
    ("dip", "obstacle", "clearance", "beside"),
    [
        (0.0, "", 0.9, ("ball – ground",)),  # z stays 1, the ball's radius is 0.1
        (-1.0, "", 0.4, ("ball – ground",)),  # z = 1 - t + t^2 / 2 is 1/2 at t = 1
        (0.0, POST, 0.4, ("ball – post",)),  # passed at 1 m, less both radii
    ],
)
def test_the_smallest_clearance_is_that_of_the_nearest(
    tmp_path: Path, dip: float, obstacle: str, clearance: float, beside: tuple[str, ...]
) -> None:
    x, z = length("x", -9, 9, speed=9.0), length("z", 0, 9, speed=9.0)
    body = Body("ball", move(x, 0, z), mass=1.0, shape=Sphere(0.1))
    drives = [Drive("a_x", on=x, limit=2.0), Drive("a_z", on=z, limit=2.0)]
    (tmp_path / "machine.json").write_text(
        machine_to_json(System("ball", bodies=[body], inputs=drives))
    )
    (tmp_path / "s.toml").write_text(SCENARIO.format(obstacle, dip))
    problem = kinolab.load(tmp_path / "s.toml")
    motion = resimulate(problem, 0.1 * np.arange(21.0), np.tile([0.0, -dip], (20, 1)))
    margin = verify(problem, motion).margin
    assert margin is not None
    assert margin.clearance == pytest.approx(clearance, abs=1e-6)
    assert margin.beside == beside
    if dip or obstacle:
        assert margin.time == pytest.approx(1.0, abs=0.01)
