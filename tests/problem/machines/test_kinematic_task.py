"""Kinematic reductions: the same motions, given velocities in place of inputs that push."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab import cli
from kinolab.errors import InputError
from kinolab.problem.machines.kinematic_task import kinematic_task

REDUCIBLE = ("rolling_disk_maze", "diffdrive_warehouse")
MINE = Path(__file__).parents[2] / "first_afternoon"
ENOUGH = 300.0  # [s] for a search, so that a busy computer may take longer


@pytest.mark.parametrize("name", [*REDUCIBLE, str(MINE / "dynamic_tractor.toml")])
def test_configurations_change_as_they_do_with_the_dynamics(name: str) -> None:
    """Rates of coordinates are w(q) v whether v is a state or an input: masses play no part."""
    problem = kinolab.load(name)
    reduced, model = kinematic_task(problem), problem.model
    generator = np.random.default_rng(1)
    for _ in range(20):
        x = problem.sample(generator)
        q, v = x[: model.nq], x[model.nq :]
        u = generator.uniform(*model.control_bounds.T)
        np.testing.assert_allclose(reduced.model.f(q, v), model.f(x, u)[: model.nq], atol=1e-12)
        np.testing.assert_allclose(reduced.frames(q), problem.frames(x), atol=1e-12)
    np.testing.assert_allclose(reduced.model.control_bounds, problem.bounds[model.nq :])


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("pendulum_swingup", "no constraint takes velocities away"),
        ("snakeboard_park", "do not accelerate it along every velocity"),
        ("falling_disk_slalom", "it has feedback or states of its own"),
    ],
)
def test_machines_without_a_reduction_are_refused_with_the_reason(name: str, reason: str) -> None:
    problem = kinolab.load(name)
    with pytest.raises(InputError, match=reason) as caught:
        problem.solve(planner="kinematic_first", time_limit=1.0)
    (mistake,) = caught.value.mistakes
    assert mistake.where == f"{name}.toml [planner] name"
    assert mistake.remedy == "Take another planner, such as auto."


def test_a_refusal_names_the_override_that_chose_the_planner() -> None:
    chosen = "planner.name=kinematic_first"
    problem = kinolab.load("pendulum_swingup", overrides=[chosen])
    with pytest.raises(InputError) as caught:
        problem.solve()
    assert caught.value.mistakes[0].where == f"--set {chosen}"


def test_the_command_line_names_the_option_that_chose_the_planner(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    options = ["--planner", "kinematic_first", "--quiet", "--out", str(tmp_path / "run")]
    assert cli.run(["pendulum_swingup", *options]) == 2
    assert capsys.readouterr().err.startswith("error: --planner: ")


def test_parameters_of_masses_are_gone_and_others_keep_their_values() -> None:
    """A coin of another mass and radius: its speed is R phi_dot, whatever it weighs."""
    changes = {"system.parameters.m": 2.0, "system.parameters.R": 0.2}
    reduced = kinematic_task(kinolab.load("rolling_disk_maze").replace(**changes))
    rates = dict(zip(reduced.model.control_names, (0.0, 0.0), strict=True)) | {"phi_dot_given": 3.0}
    assert reduced.model.f(reduced.start * 0.0, list(rates.values()))[0] == pytest.approx(0.2 * 3.0)


def test_a_machine_that_begins_in_motion_has_none() -> None:
    problem = kinolab.load("rolling_disk_maze", overrides=["start.psi_dot=0.5"])
    with pytest.raises(InputError, match="does not rest at the start"):
        kinematic_task(problem)


def test_the_dynamics_follow_a_motion_of_the_reduction_into_the_bay() -> None:
    problem = kinolab.load(MINE / "dynamic_tractor.toml")
    plan = problem.solve(planner="kinematic_first", seed=2, time_limit=ENOUGH, improve=0.0)
    assert plan.status == "solved"
    assert kinolab.verify(problem, plan.trajectory).passed
    # The goal's centre, all at rest; backing, errors of the planner's steps grow a thousandfold.
    assert problem.goal_distance(plan.trajectory.x[-1]) < 1e-2
