"""Carrying out a plan with a machine, sensors and a world that are not quite as planned."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.analyze.execute.conditions import Conditions
from kinolab.cli import run
from kinolab.dynamics import (
    Body,
    Box,
    Force,
    System,
    Viscous,
    length,
    move,
    orient,
    parameter,
    rate,
    rotation,
)
from kinolab.dynamics.language.json.machine_file import machine_to_json
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.runs import write_run
from kinolab.solve import PlanResult
from kinolab.steering.tracker import Tracker
from kinolab.trajectory import Trajectory
from kinolab.world import box_obstacle
from tests.executions import execute
from tests.feedback_machines import cart_pole
from tests.outsiders import FURUTA, furuta, written

CART = """
schema = 1
title = "A cart that must not tip its pole"
[system]
file = "machine.json"
[world]
bounds = { x = [-1.0, 4.0] }
ground = "plane"
[bounds]
speed = [-1.0, 1.0]
[goal]
x = 2.0
at_rest = true
tolerance = 0.1
[integration]
step = 0.02
"""


@pytest.fixture(scope="module")
def problem(tmp_path_factory: pytest.TempPathFactory) -> PlanningTask:
    folder = tmp_path_factory.mktemp("cart")
    (folder / "machine.json").write_text(machine_to_json(cart_pole()))
    (folder / "cart.toml").write_text(CART)
    return kinolab.load(folder / "cart.toml")


@pytest.fixture(scope="module")
def plan(problem: PlanningTask) -> PlanResult:
    found = problem.solve(planner="rrt_fast", seed=1, max_iterations=20_000, optimize=False)
    assert found.status == "solved"
    return found


@pytest.fixture
def trajectory(plan: PlanResult) -> Trajectory:
    assert plan.trajectory is not None
    return plan.trajectory


def test_bounds_hold_references_to_less_than_the_machine_can_do(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    assert problem.model.control_bounds.tolist() == [[-1.0, 1.0]]
    assert problem.whole is not None
    assert problem.whole.control_bounds.tolist() == [[-2.0, 2.0]]
    assert np.abs(trajectory.references).max() <= 1.0
    x, r = np.array([0.0, 0.1, 0.2, 0.3]), np.array([0.5])
    # the same gains
    assert np.array_equal(problem.model.plant_inputs(x, r), problem.whole.plant_inputs(x, r))


def test_the_machine_that_was_planned_for_follows_its_plan(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    """Both are the differential equation's motion, to the errors of the two integrators."""
    (one,) = execute(problem, trajectory, Conditions(), runs=1).runs
    assert one.outcome == "reached"
    assert one.deviation < 1e-6


def test_feedback_along_the_plan_makes_up_for_wrong_parameters(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    wrong = Conditions(parameters=0.05)
    closed = execute(problem, trajectory, wrong, runs=20)
    assert closed.reached == 20
    tracker = Tracker.along(problem, trajectory)
    assert tracker.gains.shape == (len(trajectory.u) + 1, 1, 4)  # the last one holds its end
    worst = max(run.deviation for run in closed.runs)
    assert worst > 1e-3  # the machines do differ


def test_the_same_seed_carries_it_out_in_the_same_way(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    conditions = Conditions(parameters=0.05, noise=0.01, disturbance=0.02)
    first, again, other = (
        execute(problem, trajectory, conditions, runs=2, seed=seed) for seed in (3, 3, 4)
    )
    assert np.array_equal(first.runs[1].x, again.runs[1].x)
    assert not np.array_equal(first.runs[0].x[:50], first.runs[1].x[:50])
    assert not np.array_equal(first.runs[0].x[:50], other.runs[0].x[:50])


def test_parameters_are_drawn_within_their_share(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    runs = execute(problem, trajectory, Conditions(parameters=0.1), runs=40).runs
    nominal = {n: v for n, v in problem.system.parameter_values.items() if n != "g"}  # it stays
    shares = np.array([[run.parameters[n] / v - 1.0 for n, v in nominal.items()] for run in runs])
    assert np.abs(shares).max() <= 0.1
    assert (np.ptp(shares, axis=0) > 0.1).all()  # each of them


def test_what_stands_in_the_way_is_run_into(problem: PlanningTask, trajectory: Trajectory) -> None:
    wall = box_obstacle("wall", (0.1, 1.0, 2.0), (1.5, 0.0, 1.0))
    blocked = replace(problem, world=replace(problem.world, obstacles=(wall,)))
    (one,) = execute(blocked, trajectory, Conditions(), runs=1).runs
    assert one.outcome == "collided"
    assert 0.9 < one.x[-1][0] < 1.5  # the cart's front is 0.25 m ahead, the pole's end may lean
    assert len(one.x) < len(trajectory.x)


def test_a_goal_that_is_not_reached_is_missed(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    short = replace(
        trajectory,
        t=trajectory.t[:10],
        x=trajectory.x[:10],
        u=trajectory.u[:9],
        references=trajectory.references[:9],
    )
    (one,) = execute(problem, short, Conditions(), runs=1).runs
    assert one.outcome == "missed"
    assert one.excess > 1.0


def test_shares_are_shares() -> None:
    with pytest.raises(InputError) as caught:
        Conditions(parameters=-0.1, noise=2.0, disturbance=float("nan"))
    for name in ("--parameters", "--noise", "--disturbance"):
        assert name in str(caught.value)


CARRIAGE = """
schema = 1
title = "A carriage on rails"
[system]
file = "machine.json"
[world]
ground = "plane"
[bounds]
x = [-1.0, 6.0]
[goal]
x = 5.0
[integration]
step = 0.1
"""


@pytest.fixture
def carriage(tmp_path: Path) -> tuple[PlanningTask, Trajectory]:
    """1 kg, pushed for a second and braked for one, in closed form; drag is not known to it."""
    x, c = length("x", speed=2.0), parameter("c", 0.0, "N s/m")
    frame = move(x, 0, 0.3)
    box = Body("box", frame, mass=parameter("m", 1.0, "kg"), shape=Box(0.4, 0.3, 0.2))
    inputs = [Force("push", on=box, along=frame.x, limit=2.0)]
    machine = System("carriage", bodies=[box], inputs=inputs, efforts=[Viscous(rate(x), c)])
    (tmp_path / "machine.json").write_text(machine_to_json(machine))
    (tmp_path / "carriage.toml").write_text(CARRIAGE)
    t = np.linspace(0.0, 2.0, 21)
    gone = np.where(t < 1.0, t**2 / 2, 1.0 - (2.0 - t) ** 2 / 2)
    states = np.stack([gone, np.minimum(t, 2.0 - t)], axis=1)
    u = np.where(t[:-1] < 0.99, 1.0, -1.0)[:, None]
    plan = Trajectory(t, states, u, ("x", "x_dot"), ("push",))
    return kinolab.load(tmp_path / "carriage.toml"), plan


def test_what_ends_at_rest_stays_there_though_it_was_braked_to_the_end(
    carriage: tuple[PlanningTask, Trajectory],
) -> None:
    (one,) = execute(*carriage, Conditions(built={"m": 1.1}), runs=1).runs
    assert one.outcome == "missed"  # the goal is elsewhere, so that it goes on
    assert len(one.x) > len(carriage[1].x)
    assert np.abs(one.x[-1] - (1.0, 0.0)).max() < 0.02


def test_what_the_plan_did_not_know_shows_without_feedback(
    carriage: tuple[PlanningTask, Trajectory],
) -> None:
    """Pushed alike, with drag: v' = u - c v in closed form."""
    c, plan = 0.4, carriage[1]
    (alone,) = execute(*carriage, Conditions(built={"c": c}, tracked=False), runs=1).runs
    end = (2.0 * np.exp(-c) - 1.0 - np.exp(-2.0 * c)) / c
    assert alone.x[len(plan.u), 1] == pytest.approx(end, abs=1e-4)
    (led,) = execute(*carriage, Conditions(built={"c": c}), runs=1, large=0.02).runs
    assert led.deviation < alone.deviation / 5


def test_a_parameter_that_does_not_exist_is_refused(
    carriage: tuple[PlanningTask, Trajectory],
) -> None:
    with pytest.raises(InputError, match="drag"):
        execute(*carriage, Conditions(built={"drag": 1.0}))


def test_machines_that_nobody_can_build_are_drawn_again() -> None:
    """Two moments of inertia of a thin disk must add up to the third: half of all draws fail."""
    m, J = parameter("m", 1.0, "kg"), parameter("J", 1.0, "kg m^2")
    plate = Body("plate", orient(rotation("R", speed=1.0)), mass=m, inertia=(J, J, 2.0))
    with pytest.raises(InputError):
        System("plate", bodies=[plate]).with_parameters(J=0.9)
    generator, conditions = np.random.default_rng(1), Conditions(parameters=0.05)
    drawn = [conditions.machine(System("plate", bodies=[plate]), generator) for _ in range(20)]
    assert all(1.0 <= machine.parameter_values["J"] <= 1.05 for machine in drawn)


def test_a_plan_without_steps_cannot_be_carried_out(
    problem: PlanningTask, trajectory: Trajectory
) -> None:
    still = replace(
        trajectory,
        t=trajectory.t[:1],
        x=trajectory.x[:1],
        u=trajectory.u[:0],
        references=trajectory.references[:0],
    )
    with pytest.raises(InputError, match="it has no steps"):
        execute(problem, still, Conditions())


def test_plan_execute_counts_and_draws(
    problem: PlanningTask, plan: PlanResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_run(tmp_path, problem, plan)
    arguments = ["execute", str(tmp_path), "--parameters", "0.05", "--runs", "10", "--json"]
    assert run([*arguments, "--quiet"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == json.loads((tmp_path / "execution.json").read_text())
    assert (printed["runs"], printed["reached"], len(printed["each"])) == (10, 10, 10)
    assert (tmp_path / "execution.png").read_bytes().startswith(b"\x89PNG")
    write_run(tmp_path, problem, plan)  # another plan: what was executed is gone
    assert not (tmp_path / "execution.json").exists()
    assert run(["execute", str(tmp_path), "--noise", "-1"]) == 2
    assert "--noise" in capsys.readouterr().err
    assert run(["execute", str(tmp_path), "--set", "mass"]) == 2
    assert "there is no '=' in it" in capsys.readouterr().err


def test_an_approximate_plan_is_said_not_to_reach_the_goal(
    problem: PlanningTask, plan: PlanResult, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said, arguments = "the plan itself does not reach the goal", ("--runs", "1", "--no-picture")
    for status, told in (("solved", False), ("approximate", True), ("verification_failed", True)):
        write_run(tmp_path, problem, replace(plan, status=status, message="Not all the way."))
        assert run(["execute", str(tmp_path), *arguments]) == 0
        assert (f"{said}: Not all the way." in capsys.readouterr().out) == told


def test_leaving_the_workspace_is_no_success(problem: PlanningTask, trajectory: Trajectory) -> None:
    fenced = replace(problem, world=replace(problem.world, bounds={"x": (-1.0, 1.5)}))
    (one,) = execute(fenced, trajectory, Conditions(), runs=1).runs
    assert one.outcome == "strayed"
    assert one.x[-1][0] > 1.5 - 1.0  # a pole that leans ahead leaves it first
    assert len(one.x) < len(trajectory.x)


@pytest.mark.parametrize("seed", [1, 3, 4])
def test_a_perfect_machine_repeats_its_plan_at_whatever_step_it_was_searched(
    seed: int, tmp_path: Path
) -> None:
    """With gains along the plan and without: nothing is wrong for them to correct.

    What is left are the errors of two integrators, up to 1e-9 of a scale in a step, times the
    growth of errors along a swing-up. A plan as it was searched takes two or three times as long
    as an optimised one, so that they grow more.
    """
    problem = kinolab.load(written(tmp_path, furuta(), FURUTA))
    found = problem.solve(planner="auto", seed=seed, max_iterations=400_000, optimize=False)
    trajectory = found.trajectory
    assert trajectory is not None
    for conditions in (Conditions(), Conditions(tracked=False)):
        (one,) = execute(problem, trajectory, conditions, runs=1).runs
        assert one.outcome == "reached"
        assert one.deviation < 1e-6


def test_drag_that_the_step_of_the_search_cannot_follow_is_followed(
    carriage: tuple[PlanningTask, Trajectory],
) -> None:
    """v' = u - c v with c h = 10, where the step of the search runs away: v = u / c in the end."""
    c, (problem, plan) = 100.0, carriage
    (alone,) = execute(problem, plan, Conditions(built={"c": c}, tracked=False), runs=1).runs
    assert alone.outcome == "missed"
    assert alone.x[1, 1] == pytest.approx((1.0 - np.exp(-10.0)) / c, rel=1e-6)
    assert alone.x[9, 1] == pytest.approx(1.0 / c, rel=1e-6)


def test_a_problem_of_discrete_steps_is_carried_out_in_them(
    carriage: tuple[PlanningTask, Trajectory],
) -> None:
    """Euler's map of v' = u, x' = v: x lags behind by half a step of speed."""
    problem, plan = carriage
    settings = {"truth": "discrete", "method": "euler"}
    integration = problem.scenario.integration.model_copy(update=settings)
    scenario = problem.scenario.model_copy(update={"integration": integration})
    stepped = replace(problem, scenario=scenario)
    (alone,) = execute(stepped, plan, Conditions(tracked=False), runs=1).runs
    k = np.arange(11)
    assert np.allclose(alone.x[:11, 0], 0.01 * k * (k - 1) / 2, atol=1e-12)


def _slider(*, gain: object = 1.0) -> System:
    x = length("x", -5.0, 5.0, speed=5.0)
    frame = move(x, 0, 0)
    body = Body("slider", frame, mass=1.0)
    push = Force("push", on=body, along=frame.x, limit=1.0)
    return System("slider", bodies=[body], inputs=[push], efforts=[Viscous(rate(x), gain)])


def _on_rails(system: System, folder: Path) -> tuple[PlanningTask, Trajectory]:
    (folder / "machine.json").write_text(machine_to_json(system))
    (folder / "s.toml").write_text(
        'schema = 1\ntitle = "t"\n[system]\nfile = "machine.json"\n'
        "[goal]\nx = 0.1\ntolerance = 0.5\n[integration]\nstep = 0.1\n"
    )
    motion = Trajectory(
        t=np.array([0.0, 0.1]), x=np.zeros((2, 2)), u=np.zeros((1, 1)),
        state_names=("x", "x_dot"), control_names=("push",),
    )  # fmt: skip
    return kinolab.load(folder / "s.toml"), motion


@pytest.mark.parametrize("damping", [1.0, parameter("c", 0.0, "N s/m")])
def test_where_no_parameter_can_vary_nothing_is_run(damping: object, tmp_path: Path) -> None:
    """A machine of numbers has none, and a share of 0 is 0: all runs would reach the goal."""
    problem, motion = _on_rails(_slider(gain=damping), tmp_path)
    with pytest.raises(InputError, match="--parameters: slider has no parameter to vary"):
        execute(problem, motion, Conditions(parameters=0.5), runs=3)
    assert sum(execute(problem, motion, Conditions(noise=0.01), runs=3).counts.values()) == 3


def test_a_parameter_that_is_built_otherwise_varies(tmp_path: Path) -> None:
    problem, motion = _on_rails(_slider(gain=parameter("c", 0.0, "N s/m")), tmp_path)
    conditions = Conditions(parameters=0.5, built={"c": 2.0})
    drawn = {run.parameters["c"] for run in execute(problem, motion, conditions, runs=5).runs}
    assert len(drawn) == 5
    assert all(1.0 <= c <= 3.0 for c in drawn)
