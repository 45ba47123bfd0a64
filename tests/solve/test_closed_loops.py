"""Machines whose loops close, and arms on strings, are planned for like all others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import kinolab
from kinolab import cli
from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from tests import loops
from tests.machines import four_bar_by_multipliers
from tests.support import detail, failed

Array = NDArray[np.float64]

RIDE = """\
schema = 1
title = "A bicycle rides ahead"
[system]
name = "whipple"
[world]
bounds = { x = [-2, 12], y = [-3, 3] }
ground = "plane"
[start]
theta_R_dot = 16.666666666666668
[goal]
x = 5.0
y = 0.2
tolerance = 0.3
at_rest = false
[integration]
step = 0.05
[planner]
name = "rrt"
improve = 0
"""


@pytest.fixture
def linkage(tmp_path: Path) -> PlanningTask:
    """A four-bar linkage whose crank turns from 1 rad to 2 rad."""
    return kinolab.load(four_bar_scenario(tmp_path))


def four_bar_scenario(folder: Path) -> Path:
    a, b, c, _ = loops.four_bar_state(1.0)
    text = loops.section("start", {"a": a, "b": b, "c": c})
    text += "[goal]\na = 2.0\ntolerance = 0.1\nat_rest = true\n"
    return loops.written(folder, loops.four_bar(), text)


def arm_scenario(folder: Path) -> Path:
    text = loops.section("start", {"s": float(loops.hung_arm_place(np.array(0.0))), "a": 0.0})
    text += "[goal]\na = 0.25\ntolerance = 0.05\nat_rest = true\n[integration]\nstep = 0.05\n"
    return loops.written(folder, loops.hung_arm(), text)


def planned(problem: PlanningTask, planner: str) -> Trajectory:
    found = problem.solve(planner=planner, seed=1, max_iterations=20_000, optimize=False)
    assert found.status == "solved", found.message
    assert found.trajectory is not None
    return found.trajectory


@pytest.mark.parametrize("planner", ["auto", "rrt", "kpiece"])
def test_a_linkage_is_planned_for_and_obeys_freudensteins_equation(
    planner: str, linkage: PlanningTask
) -> None:
    trajectory = planned(linkage, planner)
    assert abs(trajectory.x[-1, 0] - 2.0) <= 0.1
    missed = loops.freudenstein(trajectory.x[:, 0], trajectory.x[:, 2])
    assert np.abs(missed).max() < 1e-12  # rounding
    assert np.sin(trajectory.x[:, 2]).min() > 0  # the rocker stays above


@pytest.mark.parametrize("planner", ["auto", "rrt", "kpiece"])
def test_an_arm_on_a_driven_string_is_planned_for(planner: str, tmp_path: Path) -> None:
    problem = kinolab.load(arm_scenario(tmp_path))
    s, a = planned(problem, planner).x[:, :2].T
    assert np.abs(loops.string_length(s, a) - loops.STRING).max() < 1e-9  # [m]
    assert abs(a[-1] - 0.25) <= 0.05


def test_a_bicycle_with_its_front_wheel_on_the_ground_is_planned_for(tmp_path: Path) -> None:
    (tmp_path / "ride.toml").write_text(RIDE, encoding="utf-8")
    problem = kinolab.load(tmp_path / "ride.toml")
    trajectory = planned(problem, "rrt")
    wheel = [body.name for body in problem.system.bodies].index("front wheel")
    height, axle = problem.model.frames(trajectory.x)[:, wheel, [11, 9]].T
    # A disk whose axle points upwards by that share has its centre so high above its lowest point.
    assert np.abs(height - 0.35 * np.sqrt(1 - axle**2)).max() < 1e-9  # [m]


def test_the_command_line_plans_a_linkage_to_the_end(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Optimised for a while, drawn, and checked from its files."""
    path, run = four_bar_scenario(tmp_path), tmp_path / "run"
    options = ["--max-iterations", "2000", "--set", "planner.improve=0.3", "--out", str(run)]
    assert cli.run([str(path), *options]) == 0
    assert "checks passed" in capsys.readouterr().out
    pictures = {"animation.gif", "scene.html"}
    assert pictures <= {file.name for file in run.iterdir()}
    assert cli.run(["check", str(run)]) == 0


@pytest.mark.parametrize("entry", [1, 2])
def test_a_row_whose_loop_is_open_is_refused_by_name(entry: int, linkage: PlanningTask) -> None:
    trajectory = planned(linkage, "rrt")
    x = trajectory.x.copy()
    x[3, entry] += 1e-7  # [rad], which opens the loop by about as many metres
    certificate = verify(linkage, replace(trajectory, x=x))
    assert failed(certificate) == {"constraints"}
    assert "the loop along" in detail(certificate, "constraints")


def test_a_long_motion_drifts_off_no_loop(linkage: PlanningTask) -> None:
    """Half a minute of fast turns: DOP853 alone opens the loop by 3e-10 m, and ever more."""
    problem = replace(linkage, start=loops.four_bar_state(1.0, 4.0))
    t = np.arange(0.0, 30.0, 0.5)
    motion = resimulate(problem, t, np.zeros((len(t) - 1, 1)))
    assert np.abs(loops.freudenstein(motion.x[:, 0], motion.x[:, 2])).max() < 1e-12  # rounding
    energies = np.sum(problem.model.energy(motion.x), axis=0)
    assert np.ptp(energies) < 1e-6 * energies[0]  # nothing pushes, nothing rubs


def test_every_entry_of_the_residual_has_a_name() -> None:
    model = four_bar_by_multipliers().model()
    names = ("loop x", "loop y", "loop x again")
    assert model.residual_names == 2 * names
    assert model.constraint_residual(model.rest()).shape == (6,)


def test_a_linkage_passes_a_wall_soon_and_with_the_room_that_planners_keep() -> None:
    """A long run knows a motion of 1.06 s; 1.3 to 1.5 s came of motions that wrongly collided."""
    found = kinolab.load("five_bar_table").solve(seed=1, improve=2.0)  # [s] of work
    assert found.cost is not None
    assert found.cost <= 1.15
    assert found.certificate is not None
    assert found.certificate.margin is not None
    assert found.certificate.margin.clearance >= 0.005  # [m]
