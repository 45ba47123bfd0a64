"""Executions that fail for reasons that were built in: the reason that is named is the true one."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest

from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.execution import Executor
from kinolab.analyze.execute.execution_diagnosis import diagnose_execution
from kinolab.analyze.execute.execution_report import summary_lines
from kinolab.cli import run
from kinolab.dynamics import (
    Body,
    Disk,
    System,
    Torque,
    angle,
    length,
    move,
    parameter,
    rate,
    rot_y,
    zero,
)
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.errors import InputError
from kinolab.runs import write_run
from kinolab.solve import PlanResult
from kinolab.steering.tracker import Tracker
from tests.analyze.execute.failing_plans import CASES, GROUND, REST, FailingPlan, carriage
from tests.executions import execute

RUNS = 12


@pytest.mark.parametrize("reason", CASES)
def test_the_reason_that_is_named_is_the_true_one(reason: str) -> None:
    case = CASES[reason]
    problem, plan = case.made()
    executor = Executor(problem, plan, case.conditions, **case.options)
    execution = executor.tally(map(executor.run, range(case.runs)))
    diagnosis = diagnose_execution(executor, execution)
    assert re.search(case.summary, "\n".join(summary_lines(problem, execution)))
    assert re.search(case.diagnosis, " ".join(diagnosis.sentences))
    for made in execution.runs:
        assert (made.failure is None) == (made.outcome == "reached")
        if made.failure is not None:
            assert made.failure.outcome == made.outcome
            assert made.failure.time == pytest.approx(0.05 * made.failure.step, abs=0.051)


def test_too_weak_a_motor_is_named_without_a_diagnosis() -> None:
    """It is what the runs themselves tell."""
    case = CASES["a motor is too weak for the mass"]
    problem, plan = case.made()
    executor = Executor(problem, plan, case.conditions, **case.options)
    execution = executor.tally(map(executor.run, range(case.runs)))
    assert "more of push than there is" in "\n".join(summary_lines(problem, execution))


def test_a_box_hits_the_wall_when_it_is_there() -> None:
    """Its front is 0.2 m ahead, the wall begins at 1.205 m. Without feedback m x'' = u."""
    case = CASES["a wall is too near"]
    problem, plan = case.made()
    conditions = Conditions(built={"m": 0.8}, tracked=False)
    (one,) = execute(problem, plan, conditions, runs=1).runs
    t = np.linspace(0.0, 2.0, 41)
    x = np.where(t < 1.0, t**2 / 2, 1.0 - (2.0 - t) ** 2 / 2) / 0.8
    assert one.failure is not None
    assert one.failure.step == int(np.argmax(x >= 1.005))
    assert one.failure.time == pytest.approx(t[one.failure.step])
    assert one.failure.bodies == ("box", "wall")


def test_gravity_and_what_the_machine_keeps_do_not_vary() -> None:
    machine = carriage(height="r").changed(keep=("r", "c"))
    assert machine_from_json(machine_to_json(machine)).keep == ("r", "c")
    conditions = Conditions(parameters=0.1)
    assert conditions.shares(machine.with_parameters(c=1.0)) == {"m": 0.1}
    chosen = Conditions(parameters=0.1, vary={"r": 0.2}, keep=("m",))
    assert chosen.shares(machine) == {"r": 0.2}
    with pytest.raises(InputError, match="no parameter is called 'R'"):
        carriage().changed(keep=("R",))


def test_what_varies_or_stays_is_a_parameter_and_not_both() -> None:
    problem, plan = CASES["a wall is too near"].made()
    with pytest.raises(InputError, match="--vary: no parameter is called 'mass'"):
        execute(problem, plan, Conditions(vary={"mass": 0.1}))
    with pytest.raises(InputError, match="--track: no coordinate is called 'phi'"):
        execute(problem, plan, Conditions(noise=0.1, track=("phi",)))
    with pytest.raises(InputError, match="--keep m: m is also given to --vary"):
        Conditions(vary={"m": 0.1}, keep=("m",))
    with pytest.raises(InputError, match="--vary m: 2 is no share"):
        Conditions(vary={"m": 2.0})


def test_one_more_parameter_that_is_kept_leaves_the_others_as_they_were() -> None:
    system = carriage(height="r").with_parameters(c=1.0)
    drawn = [
        Conditions(parameters=0.1, keep=keep).machine(system, np.random.default_rng(3))
        for keep in ((), ("r",))
    ]
    one, other = (machine.parameter_values for machine in drawn)
    assert one["m"] == other["m"]
    assert one["r"] != other["r"] == 0.3


def test_how_far_a_wheel_has_rolled_is_not_tracked_unless_asked(wheeled: FailingPlan) -> None:
    problem, plan = wheeled.made()
    names = problem.model.state_names
    left, asked = (Tracker.along(problem, plan, asked=which) for which in ((), ("phi",)))
    assert left.weights[names.index("phi")] == 0.0
    assert np.abs(left.gains[..., names.index("phi")]).max() < 1e-9
    assert asked.weights[names.index("phi")] > 0.0
    assert left.weights[names.index("x")] > 0.0


@pytest.fixture
def wheeled() -> FailingPlan:
    """A wheel that rolls on its radius, with its turn as a coordinate."""
    x, phi = length("x", -9.0, 9.0, speed=4.0), angle("phi", speed=20.0)
    r, m = parameter("r", 0.25, "m"), parameter("m", 1.0, "kg")
    hub = move(x, 0, r)
    wheel = Body(
        "wheel", hub @ rot_y(phi), mass=m, inertia=(m * r**2 / 4, m * r**2 / 2, m * r**2 / 4),
        shape=Disk(r, 0.05, axis="y"), touches_ground=True,
    )  # fmt: skip
    system = System(
        "wheel",
        bodies=[wheel],
        constraints=[zero(rate(x) - r * rate(phi), "rolling")],
        inputs=[Torque("motor", on=wheel, about=hub.y, limit=2.0)],
    )
    return FailingPlan(system, GROUND + REST.format(0.2), Conditions(noise=0.1), "")


def test_the_command_names_reasons_in_all_that_it_writes(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = CASES["a wheel is larger than its shape"]
    problem, plan = case.made()
    found = PlanResult("solved", plan, None, "rrt", 1, 1, 0.0, {"search": 0.0})
    write_run(tmp_path, problem, found)
    asked = ["--vary", "r=0.1,m=0.01", "--runs", str(RUNS), "--quiet"]
    assert run(["execute", str(tmp_path), *asked]) == 0
    said = capsys.readouterr().out
    assert "varied: m by up to 1 %; r by up to 10 %" in said
    assert re.search(r"\d collided at the start: box – ground \(run \d+: box is pressed into", said)
    assert "Cylinder(r, …)" in said
    rows = [*csv.DictReader((tmp_path / "execution.csv").read_text().splitlines())]
    failed = [row for row in rows if row["outcome"] == "collided"]
    assert {(row["why"], row["time"]) for row in failed} == {("box – ground", "0.0")}
    assert all(float(row["r"]) < 0.3 for row in failed)  # the axle is lower, the disk is not
    report = json.loads((tmp_path / "execution.json").read_text())
    assert report["varied"] == {"m": 0.01, "r": 0.1}
    assert report["failures"][0]["cause"] == "box – ground"
    assert run(["execute", str(tmp_path), "--vary", "r", "--quiet"]) == 2
    assert "'r' is no name with a share" in capsys.readouterr().err
