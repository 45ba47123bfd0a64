"""The margin of a motion is its smallest clearance, wherever between two knots that is."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

from kinolab import cli
from kinolab.dynamics import Body, Drive, Sphere, System, length, move
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate, verify
from kinolab.verification.between_samples.clearance_margin import ClearanceMargin
from tests.support import OPEN, failed, problem_of

Capture = pytest.CaptureFixture[str]

PASSING = """
schema = 1
title = "A puck passes a ball"
[system]
file = "machine.json"
[start]
x_dot = 1.0
[goal]
x = 2.0
tolerance = 0.5
[integration]
step = 0.05
"""
BALL = """
[[world.obstacle]]
name = "{name}"
sphere = 0.2
position = [{x}, {y}, 0.0]
"""
RADII = 0.1 + 0.2  # [m] of puck and ball
REFINED = 1e-7  # [m] above the smallest clearance, at most


def passing(folder: Path, *balls: tuple[str, float, float], beside: bool = False) -> PlanningTask:
    """Return a puck that glides along x past balls, and perhaps another puck that stands beside."""
    x, y = length("x", -9, 9, speed=2.0), length("y", -9, 9, speed=2.0)
    bodies = [Body("puck", move(x, 0, 0), mass=1.0, shape=Sphere(0.1))]
    bodies.append(Body("other", move(1.2, y, 0), mass=1.0, shape=Sphere(0.1)))
    inputs = [Drive("push", on=x, limit=2.0), Drive("pull", on=y, limit=2.0)]
    pairs = [("puck", "other")] if beside else []
    system = System("puck", bodies=bodies, inputs=inputs, collisions=pairs)
    folder.mkdir(exist_ok=True)
    (folder / "machine.json").write_text(machine_to_json(system), encoding="utf-8")
    text = PASSING + "".join(BALL.format(name=name, x=x, y=y) for name, x, y in balls)
    return problem_of(folder, text, "start.y=0.6" if beside else "start.y=-8.0")


def glide(problem: PlanningTask, times: list[float]) -> Certificate:
    """Verify the motion at 1 m/s along x, with knots at some times."""
    t = np.array(times)
    x = np.tile(problem.start, (len(t), 1))
    x[:, [k for k, name in enumerate(problem.model.state_names) if name in ("x", "time")]] = t[
        :, None
    ]
    names = problem.model.state_names, problem.model.control_names
    return verify(problem, Trajectory(t, x, np.zeros((len(t) - 1, 2)), *names))


def test_the_smallest_clearance_is_the_distance_whatever_the_world_asks_for(tmp_path: Path) -> None:
    """A puck passes 0.5 m from a ball; [world] clearance keeps 0.05 m of the gap of 0.2 m."""
    problem = passing(tmp_path, ("ball", 1.0, 0.5))
    kept = problem_of(
        tmp_path, problem.scenario.origin.file.read_text(), "start.y=-8.0", "world.clearance=0.05"
    )
    margins = [glide(given, [0.05 * k for k in range(41)]).margin for given in (problem, kept)]
    for margin, required in zip(margins, (0.0, 0.05), strict=True):
        assert margin is not None
        assert margin.required == required
        assert margin.clearance + margin.required == pytest.approx(0.5 - RADII, abs=1e-3)
    assert "150 mm more than [world] clearance asks for" in str(margins[1])
    assert "more than" not in str(margins[0])


@pytest.mark.parametrize("times", [[0.0, 2.0], [0.0, 0.7, 2.0], [0.0, 1.0, 2.0]])
def test_the_margin_is_the_smallest_clearance_between_knots(
    times: list[float], tmp_path: Path
) -> None:
    """The balls are passed at 0.5 m and, 0.4 s later, at 0.45 m; at the knots there is more."""
    balls = (("first", 0.93, 0.5), ("second", 1.33, -0.45))
    certificate = glide(passing(tmp_path, *balls), times)
    assert certificate.passed
    margin = certificate.margin
    assert margin is not None
    assert margin.clearance == pytest.approx(0.45 - RADII, abs=REFINED)
    # Next to its minimum the distance grows with half the square of the time, over 0.45 m.
    assert margin.time == pytest.approx(1.33, abs=math.sqrt(2 * 0.45 * REFINED))
    assert margin.beside == ("puck – second",)
    assert str(margin).startswith("smallest clearance 150 mm at t = 1.3")


def test_of_two_bodies_the_clearance_is_what_lies_between_them(tmp_path: Path) -> None:
    """The other puck stands at (1.2, 0.6)."""
    margin = glide(passing(tmp_path, beside=True), [0.0, 2.0]).margin
    assert margin is not None
    assert margin.clearance == pytest.approx(0.6 - 0.2, abs=REFINED)
    assert margin.time == pytest.approx(1.2, abs=1e-3)
    assert [set(pair.split(" – ")) for pair in margin.beside] == [{"puck", "other"}]


def test_an_obstacle_that_is_nearer_than_a_body_is_what_is_told(tmp_path: Path) -> None:
    """The ball is passed with 0.3 m to spare, the other puck with 0.4 m."""
    margin = glide(passing(tmp_path, ("ball", 0.7, -0.6), beside=True), [0.0, 2.0]).margin
    assert margin is not None
    assert margin.clearance == pytest.approx(0.6 - RADII, abs=REFINED)
    assert margin.beside == ("puck – ball",)


@pytest.mark.parametrize("clearance", [0.0, 0.05])
def test_of_an_obstacle_that_moves_too(tmp_path: Path, clearance: float) -> None:
    """A ball begins 0.5 m beside the puck, goes along with it and away from it at 0.1 m/s."""
    rises = 'motion = { position = ["t", "0.5 + 0.1*t", "0"], rpy = ["0", "0", "0"] }'
    passing(tmp_path)
    text = PASSING + f'[[world.obstacle]]\nname = "ball"\nsphere = 0.2\n{rises}\n'
    problem = problem_of(tmp_path, text, "start.y=-8.0", f"world.clearance={clearance}")
    margin = glide(problem, [0.0, 2.0]).margin
    assert margin is not None
    assert margin.required == pytest.approx(problem.world.clearance)
    assert margin.clearance + margin.required == pytest.approx(0.5 - RADII, abs=1e-3)
    assert margin.beside == ("puck – ball",)
    assert ("asks for" in str(margin)) == bool(clearance)


def test_there_is_no_margin_in_an_empty_world(tmp_path: Path) -> None:
    certificate = glide(passing(tmp_path), [0.0, 2.0])
    assert certificate.passed
    assert certificate.margin is None


def test_there_is_no_margin_where_something_touches(tmp_path: Path) -> None:
    certificate = glide(passing(tmp_path, ("ball", 1.0, 0.25)), [0.0, 2.0])
    assert failed(certificate) == {"collision"}
    assert certificate.margin is None


# --- what is reported ---

AT_REST = ("goal.psi=0.5", "goal.at_rest=true", "goal.tolerance=0.3")
QUICK = ["--max-iterations", "20000", "--no-animation", "--quiet"]


def ran(folder: Path, *overrides: str) -> dict[str, object]:
    """Plan for the coin beside a wall, and return the report."""
    wall = BALL.format(name="ball", x=-0.5, y=-1.0)
    (folder / "table.toml").write_text(OPEN + wall)
    options = [part for override in overrides for part in ("--set", override)]
    out = ["--out", str(folder / "run")]
    assert cli.run([str(folder / "table.toml"), *options, *QUICK, *out]) == 0
    report: dict[str, object] = json.loads((folder / "run" / "report.json").read_text())
    return report


def test_the_report_says_how_small_the_clearance_is_when_and_beside_what(
    tmp_path: Path, capsys: Capture
) -> None:
    report = ran(tmp_path)
    margin = report["margin"]
    assert isinstance(margin, dict)
    assert set(margin) == {"clearance", "time", "beside", "required"}
    assert 0.0 < margin["clearance"] < 1.0 - 0.2 - 0.025  # [m], as at the start
    assert 0.0 <= margin["time"] <= report["duration"]  # type: ignore[operator]
    assert margin["beside"] == ["coin – ball"]
    capsys.readouterr()
    assert cli.run(["check", str(tmp_path / "run")]) == 0
    time = round(margin["time"], 4)
    smallest = f"{1000 * margin['clearance']:.3g} mm at t = {time:.6g} s (coin – ball)"
    assert f"  smallest clearance {smallest}" in capsys.readouterr().out.splitlines()


def test_the_distance_from_the_goal_is_told_in_each_unit(tmp_path: Path, capsys: Capture) -> None:
    """A goal of position, heading and speeds: metres, radians and radians per second."""
    report = ran(tmp_path, *AT_REST, 'planner.name="auto"')
    parts = report["goal_distance_by_unit"]
    assert isinstance(parts, dict)
    assert set(parts) == {"m", "rad", "rad/s"}
    x = np.load(tmp_path / "run" / "trajectory.npz")["x"][-1]
    assert parts["m"] == pytest.approx(math.hypot(x[0], x[1]), rel=1e-9, abs=1e-15)
    assert parts["rad"] == pytest.approx(
        abs(math.remainder(x[2] - 0.5, 2 * math.pi)), rel=1e-9, abs=1e-15
    )
    assert parts["rad/s"] == pytest.approx(math.hypot(x[4], x[5]), rel=1e-9, abs=1e-15)
    assert report["goal_distance"] == pytest.approx(math.hypot(*parts.values()), rel=1e-9)
    said = ", ending {m:.3g} m, {rad:.3g} rad and {rate:.3g} rad/s from the goal's centre, "
    assert said.format(rate=parts["rad/s"], **{k: parts[k] for k in ("m", "rad")}) in (
        capsys.readouterr().out
    )


def test_the_distance_from_a_goal_of_lengths_is_in_metres(tmp_path: Path, capsys: Capture) -> None:
    report = ran(tmp_path)
    assert report["goal_distance_by_unit"] == {"m": report["goal_distance"]}
    assert f", ending {report['goal_distance']:.3g} m from the goal's centre, " in (
        capsys.readouterr().out
    )


def test_large_distances_are_told_in_metres_and_times_to_a_tenth_of_a_millisecond() -> None:
    far = ClearanceMargin(1.3701, 5.81551e-9, ("cart – shelf",), required=0.5)
    assert str(far) == (
        "smallest clearance 1.87 m, 1.37 m more than [world] clearance asks for, at t = 0 s "
        "(cart – shelf)"
    )
