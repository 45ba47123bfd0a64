"""Steps that are too long for a stiff machine are said to be, and what they make up is no plan."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab import systems
from kinolab.analyze.diagnose import diagnosis
from kinolab.analyze.examine import examine
from kinolab.cli import run
from kinolab.dynamics import (
    Body,
    Box,
    Force,
    Potential,
    System,
    Viscous,
    length,
    move,
    rate,
)
from kinolab.problem import PlanningTask
from kinolab.runs import write_run
from kinolab.scenario import builtin_scenarios
from kinolab.scenario.schema import IntegrationSection
from kinolab.search import Budget
from kinolab.simulation import stiffness
from kinolab.solve.attempt import attempt
from kinolab.solve.plan import make_planner
from tests.outsiders import SKID, skid_steered, written

RK4 = 'integration.method="rk4"'
EULER = 'integration.method="euler"'
DEFAULT = IntegrationSection()
FADES = 0.7 * 50.0 * 9.81 / 0.05 * (0.2**2 + 0.25**2) / 4.0  # [1/s] of turning on the spot
STIFF = "Something in this machine changes within "

SLEDGE = """
schema = 1
title = "A sledge in honey"
[system]
file = "machine.json"
[world]
ground = "plane"
[bounds]
x = [-1.0, 6.0]
[goal]
x = 5.0
tolerance = 0.05
[integration]
method = "rk4"
step = 0.05
[planner]
name = "rrt_fast"
improve = 0
"""


def robot(folder: Path, *overrides: str) -> PlanningTask:
    return kinolab.load(written(folder, skid_steered(), SKID), overrides=overrides)


def sledge() -> System:
    """1 kg with 200 N s/m of drag: speeds fade at 200 /s."""
    x = length("x", speed=2.0)
    box = Body("box", move(x, 0, 0.3), mass=1.0, shape=Box(0.4, 0.3, 0.2))
    push = Force("push", on=box, along=box.frame.x, limit=400.0)
    return System("sledge", bodies=[box], inputs=[push], efforts=[Viscous(rate(x), 200.0)])


@pytest.mark.parametrize(("method", "stable"), [(RK4, 2.785), (EULER, 2.0)])
def test_what_settles_fastest_bounds_the_step(method: str, stable: float, tmp_path: Path) -> None:
    """Friction against turning on the spot, in closed form: tanh is straight at rest."""
    found = stiffness(robot(tmp_path, method))
    assert found is not None
    assert found.rate == pytest.approx(FADES, rel=1e-3)
    assert found.limit == pytest.approx(stable / FADES, rel=1e-3)
    assert found.sentence.startswith(STIFF)
    enough = math.ceil(0.05 * FADES / stable)
    told = f"steps below {stable / FADES:.2g} s ([integration] substeps = {enough})"
    assert f'{told}, or method = "rosenbrock".' in found.sentence


@pytest.mark.parametrize("method", [RK4, EULER])
def test_the_bound_is_where_a_small_slide_begins_to_grow(method: str, tmp_path: Path) -> None:
    problem = robot(tmp_path, method)
    found = stiffness(problem)
    assert found is not None
    turning = problem.start.copy()
    entry = problem.model.state_names.index("psi_dot")
    turning[entry] = 1e-6  # [rad/s]
    shares = {}
    for share in (0.99, 1.01):
        h = share * found.limit
        after = problem.model.step(turning, np.zeros(2), h, method=found.method)
        shares[share] = abs(after[entry]) / turning[entry]
    assert shares[0.99] < 1.0 < shares[1.01]


def test_shorter_steps_and_implicit_ones_are_called_stable(tmp_path: Path) -> None:
    assert stiffness(robot(tmp_path, RK4, "integration.step=0.0158")) is None
    assert stiffness(robot(tmp_path, RK4, "integration.step=0.0159")) is not None
    assert stiffness(robot(tmp_path, RK4, "integration.substeps=4")) is None
    few = stiffness(robot(tmp_path, RK4, "integration.substeps=3"))
    assert few is not None
    assert "at substeps of 0.0167 s: it needs substeps below 0.016 s" in few.sentence
    assert stiffness(robot(tmp_path)) is None


def test_what_is_stiff_only_where_a_search_came_to_is_found_there(tmp_path: Path) -> None:
    """A spring k x^4 on 1 kg swings at sqrt(12 k) x: at 35 /s at the limit, at 104 /s there."""
    x = length("x", speed=2.0)
    box = Body("box", move(x, 0, 0.3), mass=1.0, shape=Box(0.4, 0.3, 0.2))
    push = Force("push", on=box, along=box.frame.x, limit=1.0)
    spring = System("spring", bodies=[box], inputs=[push], efforts=[Potential(100.0 * x**4)])
    text = SLEDGE.replace("[-1.0, 6.0]", "[-1.0, 1.0]").replace("x = 5.0", "x = 0.5")
    problem = kinolab.load(written(tmp_path, spring, text))
    assert stiffness(problem) is None
    found = stiffness(problem, np.array([[3.0, 0.0], [3.0, 1.0]]))
    assert found is not None
    assert found.rate == pytest.approx(3.0 * np.sqrt(1200.0))


@pytest.mark.parametrize("name", sorted(builtin_scenarios()))
def test_no_scenario_of_ours_has_steps_that_are_too_long(name: str) -> None:
    problem = kinolab.load(name)
    assert stiffness(problem) is None
    checked = examine(System.of(problem.system), problem.scenario.integration).laws
    held = [law.holds for law in checked if "stable" in law.law]  # in each mode
    assert held
    assert all(held)


def stable(name: str, settings: IntegrationSection) -> bool:
    """Whether examining a machine of ours finds that steps are short enough."""
    checked = examine(systems.get(name), settings).laws
    return all(law.holds for law in checked if "stable" in law.law)


SHORT_STEPS = {"marionette", "slip_steered"}  # strings as stiff as real ones, and tyres that hold


@pytest.mark.parametrize("name", [name for name in systems.names() if name not in SHORT_STEPS])
def test_no_machine_of_ours_is_stiff_at_the_step_that_scenarios_have_by_default(name: str) -> None:
    assert stable(name, DEFAULT)


def test_tyres_that_hold_are_stiff_for_all_but_implicit_steps() -> None:
    assert not stable("slip_steered", IntegrationSection(method="rk4"))
    assert stable("slip_steered", IntegrationSection(method="rosenbrock"))


def test_plan_examine_says_which_steps_are_too_long(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, skid_steered(), SKID)
    assert run(["examine", str(path)]) == 0
    capsys.readouterr()
    path.write_text(SKID.replace("rosenbrock", "rk4"))
    assert run(["examine", str(path)]) == 7
    (line,) = " ".join(capsys.readouterr().out.split()).split(" BROKEN ")[1:]
    assert "rk4 is stable at steps of 0.05 s" in line
    assert "it needs steps below 0.016 s ([integration] substeps = 4), or method =" in line


def test_a_search_with_unstable_steps_is_blamed_on_them_and_not_on_limits(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """RK4 turns each speed into 291 times the opposite: every motion passes the speed limit."""
    monkeypatch.setattr(diagnosis, "PASSAGE_SECONDS", 0.5)
    problem = kinolab.load(written(tmp_path, sledge(), SLEDGE))
    plan = problem.solve(seed=1, max_iterations=20_000)
    assert plan.status in {"approximate", "not_found"}
    assert "x_dot" in plan.rejections["limit"]
    found = kinolab.diagnose(problem, plan)
    assert found.sentences[0].startswith(STIFF)
    assert "needs steps below 0.014 s" in found.sentences[0]
    assert not any("limit, x" in sentence for sentence in found.sentences)
    assert {retry.change: retry.solved for retry in found.retries} == {"method": True, "step": True}
    assert found.to_json()["stiffness"]["rate"] == pytest.approx(200.0)


def test_what_unstable_steps_made_up_is_not_stored(tmp_path: Path) -> None:
    """Under some inputs found the true motion passes the limit on psi_dot; it is not to blame."""
    problem = robot(tmp_path, RK4)
    searcher = make_planner(problem, None, {})  # one search each: a whole plan would search on
    plans = [attempt(problem, searcher, seed, Budget(60.0)) for seed in range(1, 6)]
    made_up = [plan for plan in plans if plan.status != "solved"]
    assert made_up
    for k, plan in enumerate(made_up):
        assert plan.trajectory is None
        assert plan.certificate is None
        assert plan.message.startswith(f"What was found is no motion of this machine. {STIFF}")
        assert "psi_dot" not in plan.message
        write_run(tmp_path / f"run{k}", problem, plan)
        assert not (tmp_path / f"run{k}" / "trajectory.csv").exists()
