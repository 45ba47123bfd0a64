"""Stiff machines get a stable method where a scenario names none, quick motions short steps."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

import kinolab
from kinolab.dynamics import (
    WORLD,
    Body,
    Box,
    Coulomb,
    Force,
    Sphere,
    System,
    Torque,
    Viscous,
    angle,
    length,
    move,
    rate,
    rot_y,
    toward,
)
from kinolab.loading import find_scenario
from kinolab.scenario import builtin_scenarios
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


@pytest.mark.parametrize("name", builtin_scenarios())
def test_a_scenario_that_says_its_steps_or_has_stable_ones_keeps_them(name: str) -> None:
    problem = kinolab.load(name)
    assert problem.scenario.integration == find_scenario(name).integration
    assert not any("instead. Give [integration]" in note for note in problem.notes)


def dart(mass: float) -> System:
    """A box on a rail that 100 N push ahead or back."""
    x = length("x", speed=100.0)
    box = Body("box", move(x), mass=mass)
    push = Force("push", on=box, along=box.frame.x, limit=100.0)
    return System("dart", bodies=[box], inputs=[push])


@pytest.mark.parametrize(("mass", "least"), [(100.0, 2.0), (0.01, 0.02)])
def test_a_quick_motion_gets_short_steps_and_is_planned_for(mass: float, least: float) -> None:
    """From rest to rest 1 m on it takes 2 sqrt(d m / F) at least, where steps were 50 ms."""
    limits = {"x": [-3.0, 3.0]}
    scenario = {"system": dart(mass), "bounds": limits, "goal": {"x": 1.0, "at_rest": True}}
    problem = kinolab.load(scenario)
    changed = "step" in problem.scenario.integration.model_fields_set
    assert changed is (least < 0.5)
    assert any("which is short for steps of 0.05 s" in note for note in problem.notes) is changed
    assert problem.scenario.integration.method == "rk4"
    plan = problem.solve(seed=1)
    assert plan.certificate is not None
    assert not failed(plan.certificate)
    assert 0.999 * least < plan.trajectory.t[-1] < 1.5 * least


def finger() -> System:
    """Three light links on a stand with motors, friction of their gears, and little inertia."""
    frame, links, motors, frictions = WORLD, list[Body](), list[Torque](), list[Coulomb]()
    for k, reach in enumerate((0.0, 0.12, 0.12)):
        q = angle(f"q{k}", speed=20.0)
        frame = frame @ move(reach, 0, 0) @ rot_y(q)
        link = Body(f"link{k}", frame @ move(0.06), mass=0.1, inertia=1e-4, shape=Sphere(0.02))
        links.append(link)
        motors.append(Torque(f"motor{k}", on=link, about=frame.y, limit=5.0))
        frictions.append(Coulomb(rate(q), 0.1, 0.1))
    gravity = toward("-z", 9.81)
    return System("finger", bodies=links, inputs=motors, efforts=frictions, gravity=gravity)


def test_a_stiff_and_quick_machine_is_planned_for_without_a_word_of_integration() -> None:
    """No method gets anywhere with the usual step; DOP853 knows nothing of either."""
    limits = {name: [-3.0, 3.0] for name in ("q0", "q1", "q2")}
    post = {"name": "post", "box": [0.02, 0.4, 0.02], "position": [0.2, 0.0, 0.12]}
    problem = kinolab.load(
        {
            "system": finger(),
            "bounds": limits,
            "world": {"obstacle": [post]},
            "start": {"q0": 0.3},
            "goal": {"q0": -1.2, "q1": 0.4, "q2": 0.3, "at_rest": True},
        }
    )
    assert {"step", "method"} <= problem.scenario.integration.model_fields_set
    assert stiffness(problem) is None
    plan = problem.solve(seed=1, improve=0, time_limit=300.0)  # on a busy computer
    assert plan.status == "solved"
    assert plan.certificate is not None
    assert not failed(plan.certificate)


def test_the_chosen_steps_follow_the_motion() -> None:
    """x'' = F - 200 x' in closed form: a step errs by less than a thousandth of a scale."""
    problem = load(sledge())
    settings = problem.scenario.integration
    x, F, h, d = np.zeros(2), np.array([100.0]), settings.step, 200.0
    after = problem.model.step(x, F, h, method=settings.method, substeps=settings.substeps)
    speed = F[0] / d * (1.0 - np.exp(-d * h))
    way = F[0] / d * h - speed / d
    assert np.abs(after - [way, speed]) / problem.scales == pytest.approx([0.0, 0.0], abs=1e-3)
