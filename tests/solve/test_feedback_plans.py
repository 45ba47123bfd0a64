"""Plans of a machine with feedback: references are searched for, what follows them is checked."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.cli import run
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.runs import check_run, read_run, write_run
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.solve import PlanResult
from kinolab.trajectory import Trajectory
from kinolab.verification import verify
from tests.feedback_machines import cart_pole

SCENARIO = """
schema = 1
title = "A pole under a beam"
[system]
file = "machine.json"
[world]
bounds = { x = [-1.0, 6.0] }
ground = "plane"
[[world.obstacle]]
name = "beam"
box = [0.2, 1.0, 0.2]
position = [2.5, 0.0, 1.48]
[goal]
x = 5.0
at_rest = true
tolerance = 0.1
[integration]
step = 0.02
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("cart_pole")
    (place / "machine.json").write_text(machine_to_json(cart_pole()))
    (place / "cart.toml").write_text(SCENARIO)
    return place


@pytest.fixture(scope="module")
def problem(folder: Path) -> PlanningTask:
    return kinolab.load(folder / "cart.toml")


@pytest.fixture(scope="module")
def plan(problem: PlanningTask) -> PlanResult:
    return problem.solve(planner="rrt_fast", seed=1, max_iterations=20_000, improve=0.5)


@pytest.fixture
def trajectory(plan: PlanResult) -> Trajectory:
    assert plan.status == "solved"
    assert plan.trajectory is not None
    return plan.trajectory


def failures(problem: PlanningTask, trajectory: Trajectory) -> set[str]:
    return {check.name for check in verify(problem, trajectory).failures}


def test_a_plan_carries_inputs_and_the_references_they_follow(trajectory: Trajectory) -> None:
    assert trajectory.control_names == ("push",)
    assert trajectory.reference_names == ("speed",)
    assert np.array_equal(trajectory.inputs, trajectory.references)
    assert np.abs(trajectory.u).max() <= 20.0
    assert np.abs(trajectory.references).max() <= 2.0
    header = trajectory.to_csv().splitlines()[0]
    assert header == "t,x,theta,x_dot,theta_dot,push,reference.speed"


def test_the_motion_cannot_be_replayed_without_its_feedback(problem: PlanningTask) -> None:
    """The pole falls with sqrt((M + m) g / M l) = 3.5/s: errors grow by e^(3.5 T)."""
    searched = problem.solve(planner="rrt_fast", seed=1, max_iterations=20_000, optimize=False)
    trajectory = searched.trajectory
    assert trajectory is not None
    checks = {check.name: check for check in verify(problem, trajectory).checks}
    assert checks["error growth"].value < 100.0
    assert trajectory.duration * 3.5 > np.log(1e6)
    plain = Trajectory(*(getattr(trajectory, n) for n in ("t", "x", "u", "state_names")), ("push",))
    plant = problem.model.plant
    open_loop = replace(problem, model=plant, whole=plant, machine=plant.machine)
    assert "error growth" in failures(open_loop, plain)


def test_inputs_that_the_law_does_not_give_are_found(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    u = trajectory.u.copy()
    u[len(u) // 2] = np.clip(u[len(u) // 2] + 0.01, -20, 20.0) - 0.005
    assert failures(problem, replace(trajectory, u=u)) >= {"feedback", "dynamics"}


def test_references_beyond_their_limits_are_found(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    references = trajectory.references.copy()
    references[3] = 2.5
    assert "inputs" in failures(problem, replace(trajectory, references=references))


def test_a_run_is_checked_from_its_files_with_its_law(
    problem: PlanningTask, plan: PlanResult, tmp_path: Path
) -> None:
    write_run(tmp_path, problem, plan)
    law = json.loads((tmp_path / "assets" / "feedback.json").read_text())
    assert law["is"] == "Feedback"  # gains and all: nothing is designed again
    assert "feedback" not in json.loads((tmp_path / "assets" / "machine.json").read_text())
    assert check_run(tmp_path).passed
    again = read_run(tmp_path).trajectory
    assert plan.trajectory is not None
    assert np.array_equal(again.references, plan.trajectory.references)
    with np.load(tmp_path / "trajectory.npz") as tables:
        assert tables["u"].shape == plan.trajectory.u.shape
        assert tables["reference_names"].tolist() == ["speed"]


def test_a_law_that_was_changed_is_noticed(
    problem: PlanningTask, plan: PlanResult, tmp_path: Path
) -> None:
    write_run(tmp_path, problem, plan)
    file = tmp_path / "assets" / "feedback.json"
    law = json.loads(file.read_text())
    name, tree = law["law"][0]
    law["law"][0] = [name, {"expression": ["mul", 1.01, tree["expression"]]}]
    file.write_text(json.dumps(law))
    assert {"files", "feedback"} <= {check.name for check in check_run(tmp_path).failures}
    file.write_text("{}")
    with pytest.raises(InputError, match=r"feedback\.json: the key 'references' is missing"):
        check_run(tmp_path)


def test_references_are_shortened_and_made_exact(plan: PlanResult, trajectory: Trajectory) -> None:
    """The search ends 0.1 from the goal; the references that follow it are optimised."""
    assert plan.improvements[0].by == "search"
    assert len(plan.improvements) > 1
    assert plan.goal_distance < 1e-6
    assert trajectory.duration < plan.improvements[0].duration


def test_derivatives_hold_the_law_over_a_step() -> None:
    model, h, nudge = cart_pole().model(), 0.05, 1e-6
    x, r = np.array([0.1, 0.02, 0.1, 0.05]), np.array([0.2])
    after, tangents = StepSensitivities(model, METHODS["rk4"], 2).linearized(x[None], r[None], h)
    assert np.allclose(after[0], model.step(x, r, h, substeps=2), atol=1e-14)

    def moved(z: np.ndarray) -> np.ndarray:
        return model.step(z[:4], z[4:5], float(z[5]), substeps=2)

    z = np.concatenate([x, r, [h]])
    expected = [(moved(z + d) - moved(z - d)) / (2 * nudge) for d in nudge * np.eye(6)]
    assert np.allclose(tangents[0], np.transpose(expected), rtol=1e-7, atol=1e-7)


def test_derivatives_of_several_steps_ask_the_law_in_each() -> None:
    model, h, nudge = cart_pole().model(), 0.15, 1e-6
    x, r = np.array([0.1, 0.02, 0.1, 0.05]), np.array([0.2])
    after, tangents = StepSensitivities(model, METHODS["rk4"], 2, acts=3).linearized(
        x[None], r[None], h
    )

    def moved(z: np.ndarray) -> np.ndarray:
        state = z[:4]
        for _ in range(3):
            state = model.step(state, z[4:5], float(z[5]) / 3, substeps=2)
        return state

    z = np.concatenate([x, r, [h]])
    assert np.allclose(after[0], moved(z), atol=1e-14)
    expected = [(moved(z + d) - moved(z - d)) / (2 * nudge) for d in nudge * np.eye(6)]
    assert np.allclose(tangents[0], np.transpose(expected), rtol=1e-7, atol=1e-7)
    once = StepSensitivities(model, METHODS["rk4"], 6).after(x[None], r[None], h)
    assert np.abs(once[0] - after[0]).max() > 1e-4  # a law that is held for longer is another one


def test_a_simulation_takes_references(folder: Path, tmp_path: Path) -> None:
    table = tmp_path / "speeds.csv"
    table.write_text("t,reference.speed\n0,1.0\n2,0\n")
    out = tmp_path / "out"
    arguments = ["simulate", str(folder / "cart.toml"), "--inputs", str(table)]
    assert run([*arguments, "--duration", "12", "--out", str(out), "--no-animation"]) == 0
    lines = (out / "trajectory.csv").read_text().splitlines()
    end = dict(zip(lines[0].split(","), lines[-1].split(","), strict=True))
    assert abs(float(end["theta"])) < 1e-2
    assert abs(float(end["x_dot"])) < 1e-2
    assert 1.0 < float(end["x"]) < 3.0
