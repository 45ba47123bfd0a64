"""Stiff machines get a stable method where a scenario names none; all others keep theirs."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import Body, Box, Coulomb, Force, System, Viscous, length, move, rate
from kinolab.simulation import stiffness
from tests.simulation.test_stability import SLEDGE, sledge
from tests.support import failed

SAID = 'method = "rk4"\nstep = 0.05\n'


def load(machine: System, integration: str = "") -> kinolab.Problem:
    text = SLEDGE.replace(SAID, integration)
    tables = tomllib.loads(text)
    return kinolab.load({**tables, "system": machine})


def dry() -> System:
    """1 kg on a floor with 2 N of friction, straight below 1 mm/s: it fades at 2000 /s."""
    x = length("x", speed=2.0)
    box = Body("box", move(x, 0, 0.3), mass=1.0, shape=Box(0.4, 0.3, 0.2))
    push = Force("push", on=box, along=box.frame.x, limit=5.0)
    return System("dry", bodies=[box], inputs=[push], efforts=[Coulomb(rate(x), 2.0, 1e-3)])


def linked(drag: float) -> System:
    x = length("x", speed=2.0)
    box = Body("box", move(x, 0, 0.3), mass=1.0, shape=Box(0.4, 0.3, 0.2))
    push = Force("push", on=box, along=box.frame.x, limit=400.0)
    return System("linked", bodies=[box], inputs=[push], efforts=[Viscous(rate(x), drag)])


@pytest.mark.parametrize("machine", [sledge(), dry(), linked(3000.0)], ids=lambda m: m.name)
def test_a_stiff_machine_gets_steps_that_are_stable_and_a_line_that_says_so(
    machine: System,
) -> None:
    problem = load(machine)
    assert stiffness(problem) is None
    assert problem.scenario.integration.method == "rosenbrock"
    (note,) = [n for n in problem.notes if "too fast for steps" in n]
    assert "rosenbrock" in note


def test_a_stiff_machine_is_then_planned_for_and_verified() -> None:
    """By DOP853, which knows nothing of the choice."""
    plan = load(sledge()).solve(seed=1)
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert not failed(plan.certificate)


def test_what_the_scenario_says_stays() -> None:
    said = load(sledge(), SAID)
    assert (said.scenario.integration.method, said.scenario.integration.substeps) == ("rk4", 1)
    assert stiffness(said) is not None
    for one in ('method = "rk4"\n', "substeps = 2\n"):
        assert stiffness(load(sledge(), one)) is not None


@pytest.mark.parametrize("name", ["crane_factory", "pendulum_swingup", "unicycle_slalom"])
def test_a_scenario_whose_steps_are_stable_keeps_them(name: str) -> None:
    problem = kinolab.load(name)
    written = kinolab.load(name).scenario.integration
    assert problem.scenario.integration.model_fields_set == written.model_fields_set
    assert not any("too fast for steps" in note for note in problem.notes)


def test_the_chosen_steps_follow_the_motion() -> None:
    """x'' = F - 200 x' in closed form: a step errs by less than a thousandth of a scale."""
    problem = load(sledge())
    settings = problem.scenario.integration
    x, F, h, d = np.zeros(2), np.array([100.0]), settings.step, 200.0
    after = problem.model.step(x, F, h, method=settings.method, substeps=settings.substeps)
    speed = F[0] / d * (1.0 - np.exp(-d * h))
    way = F[0] / d * h - speed / d
    assert np.abs(after - [way, speed]) / problem.scales == pytest.approx([0.0, 0.0], abs=1e-3)
