"""Plans that keep back what feedback needs are proved for all machines within some bounds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import Body, Force, Sphere, System, Viscous, length, move, parameter, rate
from kinolab.errors import InputError
from kinolab.runs import check_run
from kinolab.verification.tube.proof import Prover
from tests.closed_loops import executed, outside


def cart() -> System:
    m, c = parameter("m", 2.0, "kg"), parameter("c", 0.5, "N s/m")
    x = length("x", -5.0, 5.0, speed=2.0)
    frame = move(x)
    body = Body("cart", frame, mass=m, shape=Sphere(0.1))
    push = Force("push", on=body, along=frame.x, limit=1.0)
    return System("cart", bodies=[body], inputs=[push], efforts=[Viscous(rate(x), c)])


def problem(**robust: Any) -> kinolab.Problem:
    table: dict[str, Any] = {
        "system": cart(),
        "goal": {"x": 2.0, "at_rest": True, "tolerance": 0.05},
        "integration": {"step": 0.05},
        "planner": {"improve": 1.0},
    }
    return kinolab.load(table | ({"robust": robust} if robust else {}))


@pytest.fixture(scope="module")
def plans() -> tuple[kinolab.Plan, kinolab.Plan]:
    """A plan of least time, and one that is proved at 5 %."""
    return problem().solve(seed=1), problem(parameters=0.05).solve(seed=1)


def test_a_plan_that_keeps_something_back_is_proved_where_the_fastest_is_not(
    plans: tuple[kinolab.Plan, kinolab.Plan],
) -> None:
    fastest, robust = plans
    assert not fastest.prove(5.0).proved
    assert robust.claim is not None
    assert robust.claim.proved
    assert robust.exit_code == 0
    assert fastest.duration is not None
    assert robust.duration is not None
    assert robust.duration <= 1.5 * fastest.duration


def test_machines_within_the_bounds_do_as_was_proved(
    plans: tuple[kinolab.Plan, kinolab.Plan],
) -> None:
    """The integrator shares nothing with the tube; the goal is where the scenario says."""
    plan = plans[1]
    assert plan.claim is not None
    assert plan.trajectory is not None
    asked, tube = plan.claim.asked, plan.claim.proof.tube
    prover = Prover(plan.claim.problem, plan.trajectory, large=plan.claim.proof.large)
    for seed in range(10):
        states = executed(prover, asked, seed, corner=seed % 2 == 0)
        assert (outside(tube, states) <= 1e-9 * prover.problem.scales).all()
        assert abs(states[-1, 0] - 2.0) <= 0.05


def test_the_run_has_the_claim_and_it_is_proved_again(
    plans: tuple[kinolab.Plan, kinolab.Plan], tmp_path: Any
) -> None:
    folder = plans[1].save(tmp_path / "run")
    (found,) = (c for c in check_run(folder).checks if c.name == "tube")
    assert found.passed
    assert np.isfinite(found.value)


@pytest.mark.parametrize(
    ("robust", "words"),
    [
        ({"parameters": 1.5}, "a share, 0 or more, below 1"),
        ({"parameters": {"q": 0.1}}, "no parameter is called 'q'"),
        ({"noise": -0.1}, "a share, 0 or more, below 1"),
    ],
)
def test_senseless_bounds_are_refused(robust: dict[str, Any], words: str) -> None:
    with pytest.raises(InputError, match=words):
        problem(**robust).solve(seed=1)


def test_machines_that_switch_are_refused_before_anything_is_searched_for() -> None:
    walk = kinolab.load("biped_walk", overrides=["robust.parameters=0.01"])
    with pytest.raises(InputError, match="plan execute"):
        walk.solve(seed=1)
