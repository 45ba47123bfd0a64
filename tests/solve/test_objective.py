"""Plans of least cost, against closed forms and an independent collocation."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.analyze.diagnose.verification_summary import verification_sentences
from kinolab.runs import check_run
from kinolab.search import Budget
from kinolab.simulation.reference import price, resimulate
from kinolab.solve.cheaper import Cheapening
from kinolab.solve.improve import MOST_SECONDS, PlanImprover
from kinolab.solve.plan import PlanResult
from kinolab.trajopt import cheapened
from kinolab.verification import verify
from tests.solve.test_several_goals import puck
from tests.support import needs, problem_of

BLOCK = """
from kinolab.dynamics import Body, Box, Force, System, length, move

def block() -> System:
    x = length("x", speed=10.0)
    f = move(x, 0, 0)
    b = Body("block", f, mass=1.0, shape=Box(0.2, 0.2, 0.2))
    return System("block", bodies=[b], inputs=[Force("push", on=b, along=f.x, limit=5.0)])
"""
PUSHED = """
schema = 1
title = "A block is pushed"
[system]
file = "block.py:block"
[bounds]
x = [-5.0, 5.0]
[start]
x = 0.0
[goal]
x = 1.0
at_rest = true
tolerance = 0.01
[objective]
effort = 1.0
max_time = 2.0
"""
CART = """
from kinolab.dynamics import (
    Body, Box, Force, Sphere, System, angle, length, move, rot_y, toward,
)

def cart_pole() -> System:
    x, theta = length("x", speed=10.0), angle("theta", speed=20.0)
    cart = move(x, 0, 0)
    c = Body("cart", cart, mass=1.0, shape=Box(0.3, 0.2, 0.1))
    bob = Body("bob", cart @ rot_y(theta) @ move(0, 0, -0.5), mass=0.3, shape=Sphere(0.05))
    push = Force("push", on=c, along=cart.x, limit=20.0)
    return System("cart_pole", bodies=[c, bob], gravity=toward("-z", 9.81), inputs=[push])
"""
SWUNG = """
schema = 1
title = "A pole is swung up"
[system]
file = "cart.py:cart_pole"
[bounds]
x = [-2.0, 2.0]
[goal]
x = 1.0
theta = 3.141592653589793
at_rest = true
tolerance = 0.05
[objective]
effort = 1.0
max_time = 2.0
[planner]
improve = 15
"""


def block(folder: Path, *overrides: str) -> kinolab.Problem:
    (folder / "block.py").write_text(BLOCK, encoding="utf-8")
    return problem_of(folder, PUSHED, *overrides, name="pushed.toml")


def test_a_block_that_has_two_seconds_takes_the_effort_of_a_cubic(tmp_path: Path) -> None:
    """From rest to rest over d in T the least integral of u^2 is 12 d^2 / T^3."""
    plan = block(tmp_path).solve(improve=2)
    assert plan.status == "solved"
    assert plan.duration == pytest.approx(2.0, abs=1e-6)
    assert plan.cost == pytest.approx(12 / 2**3, rel=0.01)


def test_time_and_effort_are_weighed_against_each_other(tmp_path: Path) -> None:
    """12 / T^3 + w T is least where T^4 = 36 / w."""
    plan = block(tmp_path, "objective.time=1.0", "objective.max_time=20.0").solve(improve=2)
    duration = 36**0.25
    assert plan.duration == pytest.approx(duration, rel=0.02)
    assert plan.cost == pytest.approx(12 / duration**3 + duration, rel=0.01)


def test_a_block_that_slides_there_by_itself_costs_nothing(tmp_path: Path) -> None:
    sliding = ("start.x_dot=1.0", "goal.x_dot=1.0", "goal.at_rest=false")
    problem = block(tmp_path, *sliding)
    t = np.linspace(0.0, 1.0, 21)
    coasting = resimulate(problem, t, np.zeros((20, 1)))
    assert verify(problem, coasting).passed
    assert price(problem, coasting) == 0.0
    assert not list(cheapened(problem, coasting, lambda: False))
    pushed = problem.solve(seed=1, improve=2)
    assert pushed.status == "solved"
    assert pushed.cost is not None
    assert 0.0 <= pushed.cost <= 1e-3


def test_a_motion_that_takes_too_long_does_not_pass(tmp_path: Path) -> None:
    slow = block(tmp_path, "objective.max_time=20.0").solve(improve=2)
    assert slow.trajectory is not None
    assert slow.duration > 2.0
    checks = {check.name: check for check in verify(block(tmp_path), slow.trajectory).checks}
    assert not checks["duration"].passed
    assert all(check.passed for name, check in checks.items() if name != "duration")


def test_only_a_quicker_motion_may_take_all_of_the_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is no plan while it takes longer than it may; else half of it is to make it cheap."""
    limits = []

    def noted(self: PlanImprover, found: PlanResult, _: Budget) -> PlanResult:
        limits.append(self.request.time_limit)
        return replace(found, status="nearest")

    monkeypatch.setattr(PlanImprover, "plan", noted)
    for most in ("0.3", "1000.0"):
        block(tmp_path, f"objective.max_time={most}").solve("rrt_fast", seed=1, time_limit=8.0)
    assert limits == [4.0, 8.0, 4.0]


def test_a_motion_that_cannot_be_short_enough_is_told_so(tmp_path: Path) -> None:
    """A block of 1 kg takes 2 sqrt(1 m / 5 N 1 kg) = 0.894 s with 5 N."""
    problem = block(tmp_path, "objective.max_time=0.3")
    plan = problem.solve("rrt_fast", seed=1, improve=1.0, time_limit=2.0)
    assert plan.status == "verification_failed"
    assert any(
        "raise [objective] max_time, which is 0.3 s" in sentence
        for sentence in verification_sentences(problem, plan)
    )


def test_cheapening_goes_on_while_that_saves_a_twentieth(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    saved = [0.5, 0.06, 0.04, 0.5]
    monkeypatch.setattr(Cheapening, "_cheapen", lambda *_: saved.pop(0))
    plan = block(tmp_path).solve("rrt_fast", seed=1, improve="auto")
    assert saved == [0.5]
    assert plan.statistics["improvement_seconds"] == MOST_SECONDS
    assert plan.statistics["last_half_gain"] == 0.04


def test_what_may_become_cheaper_is_told_so(tmp_path: Path) -> None:
    plan = block(tmp_path).solve("rrt_fast", seed=1, improve=0.5)
    assert plan.statistics["improvement_unfinished"] == 1.0
    assert "cheaper" in str(plan)


def test_a_report_that_tells_another_cost_does_not_pass(tmp_path: Path) -> None:
    block(tmp_path)
    plan = block(tmp_path).solve(improve=2)
    run = plan.save(tmp_path / "run")
    assert check_run(run).passed
    report = run / "report.json"
    told = f'"cost": {plan.cost}'
    text = report.read_text(encoding="utf-8")
    assert told in text
    report.write_text(text.replace(told, f'"cost": {0.9 * (plan.cost or 0.0)}'), encoding="utf-8")
    assert "cost" in {check.name for check in check_run(run).failures}


@pytest.mark.search
@needs("casadi")
def test_a_cart_swings_its_pole_up_with_the_effort_that_collocation_finds(tmp_path: Path) -> None:
    """The best of several local optima of Ipopt's, all of which a search may find.

    Source: Kelly, An introduction to trajectory optimization, SIAM Review 59(4), 2017, section 6.
    """
    (tmp_path / "cart.py").write_text(CART, encoding="utf-8")
    plan = problem_of(tmp_path, SWUNG, name="swung.toml").solve()
    assert plan.status == "solved"
    assert plan.cost is not None
    optima = _optima(np.random.default_rng(0))
    assert plan.cost >= 0.999 * min(optima)
    assert min(abs(plan.cost / one - 1.0) for one in optima) <= 0.01


def _optima(random: np.random.Generator, steps: int = 40) -> list[float]:
    """Return local optima of the same problem, by multiple shooting with CasADi and Ipopt."""
    import casadi as ca

    def change(x, u):  # type: ignore[no-untyped-def]
        c, s = ca.cos(x[1]), ca.sin(x[1])
        heavy = 1.0 + 0.3 * (1 - c * c)
        faster = (0.15 * s * x[3] ** 2 + u + 0.3 * 9.81 * c * s) / heavy
        turned = -(0.15 * c * s * x[3] ** 2 + u * c + 1.3 * 9.81 * s) / (0.5 * heavy)
        return ca.vertcat(x[2], x[3], faster, turned)

    opti, h = ca.Opti(), 2.0 / steps
    x, u = opti.variable(4, steps + 1), opti.variable(1, steps)
    for k in range(steps):
        end = x[:, k]
        for _ in range(2):
            a = change(end, u[k])
            b = change(end + h / 4 * a, u[k])
            c = change(end + h / 4 * b, u[k])
            d = change(end + h / 2 * c, u[k])
            end = end + h / 12 * (a + 2 * b + 2 * c + d)
        opti.subject_to(x[:, k + 1] == end)
    opti.subject_to(opti.bounded(-20, u, 20))
    opti.subject_to(opti.bounded(-2, x[0, :], 2))
    last = opti.parameter(4)
    opti.subject_to(x[:, 0] == 0)
    opti.subject_to(x[:, steps] == last)
    opti.minimize(h * ca.sumsqr(u))
    opti.solver("ipopt", {"print_time": 0, "ipopt.print_level": 0, "ipopt.sb": "yes"})
    found, share = [], np.linspace(0.0, 1.0, steps + 1)
    for trial in range(12):
        end = np.array([1.0, np.pi * (-1) ** trial, 0.0, 0.0])
        opti.set_value(last, end)
        opti.set_initial(x, np.outer(end, share) + (trial > 1) * random.normal(size=(4, steps + 1)))
        opti.set_initial(u, 5.0 * (trial > 1) * random.normal(size=(1, steps)))
        try:
            found.append(float(opti.solve().value(opti.f)))
        except RuntimeError:
            continue
    return found


def test_kpiece_bounds_further_trees_by_what_a_motion_costs(tmp_path: Path) -> None:
    pushed = "\n[goal]\nx = 3.0\ny = 1.0\nat_rest = true\ntolerance = 0.2\n"
    weighed = "[objective]\neffort = 1.0\ntime = 0.1\n"
    problem = puck(tmp_path, pushed + weighed)
    first, best = (
        problem.solve("kpiece_fast", seed=11, improve=seconds, optimize=False) for seconds in (0, 1)
    )
    assert first.cost is not None
    assert best.cost is not None
    assert best.status == "solved"
    assert best.cost < 0.9 * first.cost  # the first further motion costs a tenth less, or is none


@pytest.mark.search
def test_a_pendulum_is_swung_up_with_no_more_energy_than_it_has_above() -> None:
    """No motor does less than 2 m g l; collocation by CasADi and Ipopt comes to 19.6200 J, too.

    A motor that never brakes comes as near to it as one likes, if it has the time.
    """
    upright = {"theta": np.pi, "at_rest": True, "tolerance": 0.02}
    problem = kinolab.load(
        {
            "system": "pendulum",
            "goal": upright,
            "objective": {"energy": 1.0, "max_time": 6.0},
            "planner": {"improve": 8.0},
        }
    )
    plan = problem.solve(seed=1)
    assert plan.status == "solved"
    assert plan.cost is not None
    least = 2 * 9.81
    assert 0.999 * least <= plan.cost <= 1.01 * least  # the tolerances take some of it


@pytest.mark.search
def test_sst_s_cost_falls_with_its_work(tmp_path: Path) -> None:
    """More iterations of the same search have all motions of fewer."""
    pushed = "\n[goal]\nx = 3.0\ny = 1.0\nat_rest = true\ntolerance = 0.2\n"
    problem = puck(tmp_path, pushed + "[objective]\neffort = 1.0\ntime = 0.1\n")
    found = [
        problem.solve("sst", seed=11, improve=1e3, optimize=False, max_iterations=most).cost
        for most in (20_000, 60_000, 180_000)
    ]
    assert None not in found
    assert found == sorted(found, key=lambda cost: -(cost or 0.0))
    assert found[-1] < found[0]


@pytest.mark.parametrize("planner", ["sst", "ao_rrt", "kpiece_fast"])
def test_searches_that_compare_costs_find_nothing_that_takes_too_long(
    planner: str, tmp_path: Path
) -> None:
    easy = block(tmp_path, "goal.tolerance=0.2")
    plan = easy.solve(planner, seed=11, improve=0.5, optimize=False)
    assert plan.status == "solved"
    assert plan.duration <= 2.0 + 1e-9
