"""Plans in the benchmark's format, judged by its own models and tolerances."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import kinolab
from kinolab import cli
from kinolab.runs import check_run, result_text, write_run
from kinolab.trajectory import Trajectory
from tests.scenario.dynobench.test_environments import PARK, centre, written
from tests.scenario.dynobench.wheel import depth, environment, measures, needs_wheel
from tests.support import plan

LIMITS = {"start": 1e-9, "goal": 0.03, "jump": 1e-9, "collision": 0.0, "actions": 1e-9}


def judged(name: str, text: str) -> dict[str, float]:
    """Return what the benchmark's code says of a result."""
    problem = kinolab.load(environment(name))
    result = yaml.safe_load(text)
    x, u = np.array(result["states"]), np.array(result["actions"])
    robot, file, ends = problem.system.name, environment(name), (problem.start, centre(problem))
    collision = depth(robot, file, x)
    return measures(robot, file, x, u, problem.step, *ends) | {"collision": collision}


@needs_wheel
@pytest.mark.parametrize(
    "name",
    ["unicycle1_v0/parallelpark_0", "unicycle2_v0/parallelpark_0", "quad2d_v0/empty_0"],
)
def test_a_plan_is_accepted_by_the_benchmark(name: str, tmp_path: Path) -> None:
    """By limits stricter than its own: it allows jumps and overlaps of 0.01.

    Half a second of improvement is enough for a motion that is another one than the search's.
    """
    problem = kinolab.load(environment(name))
    found = problem.solve(seed=1, time_limit=60.0, max_iterations=2_000_000, improve=0.5)
    assert found.status == "solved"
    assert len(found.improvements) > 1
    write_run(tmp_path / "run", problem, found)
    text = (tmp_path / "run" / "result.yaml").read_text(encoding="utf-8")
    verdict = judged(name, text)
    assert all(verdict[key] <= limit for key, limit in LIMITS.items()), verdict
    assert verdict["states"] <= 1e-9
    assert verdict["goal"] < 0.03
    assert check_run(tmp_path / "run").passed


@needs_wheel
def test_the_command_line_plans_environments(tmp_path: Path) -> None:
    file = environment("unicycle1_v0/parallelpark_0")
    options = ("--json", "--no-animation", "--no-optimize", "--seed", "1")
    done = plan(file, *options, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert (report["status"], report["system"]) == ("solved", "unicycle1_v0")
    folder = tmp_path / "runs" / "parallelpark_0"
    assert (
        judged("unicycle1_v0/parallelpark_0", (folder / "result.yaml").read_text())["goal"] < 0.03
    )
    assert cli.run(["check", str(folder)]) == 0


def test_mistakes_of_an_environment_end_the_command_with_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run([str(written(tmp_path, "robots: 3\n"))]) == 2
    told = capsys.readouterr().err
    assert "park.yaml line 1: environment is missing. Give environment, robots." in told
    assert "park.yaml line 1 robots: this is no list of robots." in told


def test_a_start_that_is_impossible_is_told_by_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = PARK.replace("start: [0.7, 0.6", "start: [0.7, 9")
    assert cli.run([str(written(tmp_path, text)), "--no-animation"]) == 5
    assert "park.yaml [start]: y is 9, outside -0.5 to 2.5." in capsys.readouterr().err


def test_a_result_is_the_trajectory_with_wrapped_angles(tmp_path: Path) -> None:
    problem = kinolab.load(written(tmp_path))
    x = np.array([[0.7, 0.6, 0, 0], [0.7, 0.6, 3.5, -10.0]])
    names = (problem.model.state_names, problem.model.control_names)
    motion = Trajectory(np.array([0.0, 0.1]), x, np.array([[0.1, 1 / 3]]), *names)
    result: dict[str, Any] = yaml.safe_load(result_text(problem, motion))
    assert result["states"] == [[0.7, 0.6, 0, 0], [0.7, 0.6, 3.5 - 2 * np.pi, -10 + 4 * np.pi]]
    assert (result["actions"], result["times"], result["cost"]) == ([[0.1, 1 / 3]], [0, 0.1], 0.1)
    assert (result["start"], result["goal"]) == ([0.7, 0.6, 0, 0], [1.9, 0.2, 0, 0.6])
    counts = [result[f"num_{key}"] for key in ("states", "actions", "times")]
    assert counts == [2, 1, 2]
