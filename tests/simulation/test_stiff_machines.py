"""Stiff machines: [integration] method = "rosenbrock" wherever a method is used, and its order."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import kinolab
from kinolab.analyze.execute.conditions import Conditions
from kinolab.cli import run
from kinolab.dynamics.codegen.methods import METHODS
from kinolab.problem import PlanningTask
from kinolab.runs import read_run
from kinolab.show.scene.driving import driving_of
from kinolab.simulation import Propagator
from kinolab.simulation.machine import states_under
from kinolab.simulation.reference import DivergedError, follow, resimulate
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.solve.plan import CENTRE_TOLERANCE
from kinolab.trajectory import Trajectory
from tests.executions import execute
from tests.outsiders import SKID, skid_steered, written
from tests.support import failed, within

DISCRETE = 'truth = "discrete"'


@pytest.fixture
def robot(tmp_path: Path) -> PlanningTask:
    return kinolab.load(written(tmp_path, skid_steered(), SKID))


def discrete(folder: Path, *overrides: str) -> PlanningTask:
    path = written(folder, skid_steered(), SKID)
    return kinolab.load(path, overrides=(f"integration.{DISCRETE}", *overrides))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_robot_that_must_slide_to_turn_is_planned_for_at_a_coarse_step(
    robot: PlanningTask, seed: int
) -> None:
    """And certified by DOP853, which knows nothing of the method."""
    plan = robot.solve(seed=seed)
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert not failed(plan.certificate)


@pytest.mark.parametrize("planner", ["rrt", "kpiece", "sst", "est"])
def test_planners_of_ompl_and_compiled_ones_move_it_by_the_same_step(
    robot: PlanningTask, planner: str
) -> None:
    plan = robot.solve(planner=planner, seed=1, max_iterations=500)
    assert plan.trajectory is None or np.isfinite(plan.trajectory.x).all()
    propagator, generator = Propagator(robot), np.random.default_rng(0)
    u = generator.uniform(*robot.model.control_bounds.T)
    reached, _ = propagator.step(robot.start.tolist(), u.tolist(), robot.step)
    model = robot.model
    assert np.array_equal(reached, model.step(robot.start, u, robot.step, method="rosenbrock"))
    assert np.array_equal(reached, states_under(robot, u[None])[1])
    assert not np.allclose(reached, model.step(robot.start, u, robot.step), atol=1e-4)


def test_the_front_doors_method_has_order_two(tmp_path: Path) -> None:
    """Each substep twice as short divides the error by 4, against SciPy's Radau."""
    problem = discrete(tmp_path)
    u = np.array([6.0, 2.0])
    exact = solve_ivp(
        problem.model.rate_under(u), (0.0, 0.5), problem.start, "Radau", rtol=1e-11, atol=1e-13
    ).y[:, -1]

    def error(substeps: int) -> float:
        problem = discrete(tmp_path, f"integration.substeps={substeps}")
        t = problem.step * np.arange(11.0)
        return float(np.abs(resimulate(problem, t, np.tile(u, (10, 1))).x[-1] - exact).max())

    coarse, middle, fine = map(error, (100, 200, 400))
    assert coarse < 1e-3  # [m], [rad], and per second; it has gone about 0.2 m
    assert np.log2([coarse / middle, middle / fine]) == pytest.approx([2.0, 2.0], abs=0.25)


def test_decay_is_followed_at_any_step(tmp_path: Path) -> None:
    """At rest a small slide across dies within 1/137 s: a step leaves |R(-6.9)| = 0.13 of it.

    R(z) = (1 + (1 - 2 g) z + (1/2 - 2 g + g^2) z^2) / (1 - g z)^2 with g = 1 - sqrt(1/2), of which
    the last term of the numerator is 0; RK4 leaves |1 + z + z^2/2 + z^3/6 + z^4/24| = 58 of it.
    """
    problem = discrete(tmp_path)
    slide = problem.start.copy()
    entry = problem.model.state_names.index("y_dot")
    slide[entry] = 1e-6  # [m/s], where tanh is straight
    z, g = -problem.step * 0.7 * 9.81 / 0.05, 1.0 - 0.5**0.5
    after = states_under(problem, np.zeros((1, 2)), slide)[1, entry]
    assert after / 1e-6 == pytest.approx((1 + (1 - 2 * g) * z) / (1 - g * z) ** 2, rel=1e-6)
    wild = states_under(problem, np.zeros((1, 2)), slide, "rk4", 1)[1, entry]
    assert wild / 1e-6 == pytest.approx(1 + z + z**2 / 2 + z**3 / 6 + z**4 / 24, rel=1e-6)


def test_a_discrete_problem_is_its_own_map_to_the_end(tmp_path: Path) -> None:
    """Searched, made exact with derivatives of the map, verified, and stored."""
    problem = discrete(tmp_path, "planner.improve=1")
    plan = problem.solve(seed=1)
    assert plan.status == "solved"
    assert plan.goal_distance < CENTRE_TOLERANCE
    trajectory = plan.trajectory
    assert trajectory is not None
    again = problem.model.steps(
        problem.start, trajectory.u, np.diff(trajectory.t), method="rosenbrock"
    )
    assert np.allclose(trajectory.x, again, atol=1e-9)
    spoiled = replace(
        trajectory, x=problem.model.steps(problem.start, trajectory.u, np.diff(trajectory.t))
    )
    assert "dynamics" in failed(kinolab.verify(problem, spoiled))
    (one,) = execute(problem, trajectory, Conditions(tracked=False), runs=1).runs
    assert (one.outcome, one.deviation < 1e-9) == ("reached", True)


def test_derivatives_of_the_step_hold_for_a_stiff_machine() -> None:
    """Against central differences of ``model.step``, of entries of tanh that is nearly straight."""
    model = skid_steered().model()
    x, u, h = model.rest(), np.array([0.3, 0.1]), 0.05
    step = partial(model.step, method="rosenbrock", substeps=2)
    after, slopes = StepSensitivities(model, METHODS["rosenbrock"], 2).linearized(
        x[None], u[None], h
    )
    assert np.allclose(after[0], step(x, u, h), atol=1e-13)
    for i, e in enumerate(np.eye(model.nx) * 1e-6):
        assert np.allclose(
            slopes[0][:, i], (step(x + e, u, h) - step(x - e, u, h)) / 2e-6, atol=1e-6
        )
    for i, e in enumerate(np.eye(model.nu) * 1e-6):
        column = (step(x, u + e, h) - step(x, u - e, h)) / 2e-6
        assert np.allclose(slopes[0][:, model.nx + i], column, atol=1e-6)


def test_a_page_drives_it_by_the_same_step(robot: PlanningTask) -> None:
    MiniRacer = pytest.importorskip("py_mini_racer").MiniRacer
    states = np.array([robot.start, robot.start])
    names = robot.model.state_names, robot.model.control_names
    driving = driving_of(robot, Trajectory(np.array([0.0, 0.05]), states, np.zeros((1, 2)), *names))
    assert driving.facts["method"] == "rosenbrock"
    context = MiniRacer()
    try:
        context.eval(f"var machine = {driving.code}")
        call = "[...machine.step(x, [5, 1], 0.025, undefined, 'rosenbrock', 2)]"
        moved = context.eval(f"var x = {robot.start.tolist()}; JSON.stringify({call})")
        moved = np.fromstring(moved.strip("[]"), sep=",")
    finally:
        context.close()
    expected = robot.model.step(robot.start, [5, 1], 0.025, method="rosenbrock", substeps=2)
    assert np.allclose(moved, expected, atol=1e-12)


def test_plan_simulate_takes_the_method(tmp_path: Path) -> None:
    path, out = written(tmp_path, skid_steered(), SKID), tmp_path / "run"
    (tmp_path / "u.csv").write_text("t,left,right\n0,6,2\n")
    arguments = ["--inputs", str(tmp_path / "u.csv"), "--duration", "0.5", "--no-animation"]
    discretely = ["--set", f"integration.{DISCRETE}", "--out", str(out), "--quiet"]
    assert run(["simulate", str(path), *arguments, *discretely]) == 0
    problem, stored = discrete(tmp_path), read_run(out).trajectory
    expected = problem.model.steps(
        problem.start, np.tile([6.0, 2.0], (10, 1)), np.full(10, 0.05), method="rosenbrock"
    )
    assert np.allclose(stored.x, expected, atol=1e-12)


def test_long_intervals_of_a_fast_machine_end_with_a_message_however_many_they_are() -> None:
    """A pendulum that whirls, for 30 hours: each of its half minutes takes some thousand steps.

    All that are allowed have been made long after the first, and long before the last.
    """
    model = kinolab.systems.get("pendulum").model()
    t = np.linspace(0.0, 108_000.0, 3601)
    told = r"beyond t = \d{5}\.\d s: .* or more than 2000000 in all"
    with within(120), pytest.raises(DivergedError, match=told):
        follow(model, np.array([0.0, 100.0]), t, np.zeros((3600, model.nu)), np.ones(2))
