"""A law that is held for a step: its multiplier against closed forms, and what is said of it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import kinolab
from kinolab import systems
from kinolab.dynamics import (
    WORLD,
    Body,
    Feedback,
    Force,
    Reference,
    Regulator,
    System,
    length,
    move,
    rate,
)
from kinolab.runs import write_run
from kinolab.scenario.schema import IntegrationSection
from kinolab.simulation.held_law import largest_multiplier, law_sentence, stiff_law
from kinolab.solve import PlanResult

MASS = 2.0  # [kg]


def held(k: float, d: float) -> System:
    x, place = length("x", speed=5.0), Reference("place", limit=1.0, unit="m")
    body = Body("sledge", move(x), mass=MASS)
    push = Force("push", on=body, along=WORLD.x, limit=500.0)
    law = Feedback([place], {"push": k * (place.symbol - x) - d * rate(x)})
    return System("sledge", bodies=[body], inputs=[push], feedback=law)


@pytest.mark.parametrize(
    ("k", "d", "step"), [(40.0, 20.0, 0.1), (40.0, 20.0, 0.25), (90.0, 60.0, 0.1)]
)
def test_the_multiplier_is_that_of_the_sampled_loop(k: float, d: float, step: float) -> None:
    """The exponential of [[A, B], [0, 0]] h has the step with the input held in its first rows."""
    whole = expm(np.array([[0, 1, 0], [0, 0, 1 / MASS], [0, 0, 0]]) * step)
    loop = whole[:2, :2] - whole[:2, 2:] @ np.array([[k, d]])
    wanted = np.abs(np.linalg.eigvals(loop)).max()
    got = largest_multiplier(held(k, d).model(), IntegrationSection(step=step), step)
    assert got == pytest.approx(wanted, rel=1e-6)  # finite differences


def test_a_law_that_is_too_stiff_is_told_with_the_step_that_holds() -> None:
    """1 - d h / m for the velocity alone: -2 at d h / m = 3, and 0.25 at a quarter of the step."""
    machine = held(0.1, 60.0)
    found = stiff_law(machine.model(), IntegrationSection(step=0.1), lambda: machine)
    assert found is not None
    assert found.multiplier == pytest.approx(2.0, rel=1e-2)
    assert found.holds == pytest.approx(0.05)
    assert found.gentler is None
    assert "held for 0.1 s, it makes a deviation 2 times as large" in found.sentence
    assert "[integration] step = 0.05." in found.sentence


def test_a_regulator_is_told_how_much_gentler_it_must_be() -> None:
    x, place = length("x", speed=5.0), Reference("place", limit=1.0, unit="m")
    body = Body("sledge", move(x), mass=MASS)
    push = Force("push", on=body, along=WORLD.x, limit=20.0)
    law = Regulator([place], tracked={x: 0.02, rate(x): 0.2}, about={x: place.symbol})
    machine = System("sledge", bodies=[body], inputs=[push], feedback=law)
    settings = IntegrationSection(step=0.1)
    found = stiff_law(machine.model(), settings, lambda: machine)
    assert found is not None
    assert found.gentler is not None
    tracked = {x: 0.02 * found.gentler, rate(x): 0.2 * found.gentler}
    softer = machine.with_feedback(Regulator([place], tracked=tracked, about={x: place.symbol}))
    assert stiff_law(softer.model(), settings, lambda: softer) is None


@pytest.mark.parametrize("name", ["falling_disk", "unicycle", "motorcycle", "rolling_disk"])
def test_our_laws_hold_at_the_usual_step(name: str) -> None:
    machine = systems.get(name)
    assert stiff_law(machine.model(), IntegrationSection(), lambda: machine) is None


def test_a_law_that_pushes_the_wrong_way_is_not_called_too_stiff(tmp_path: Path) -> None:
    """m x'' = k (x - place): no step is short enough. The report of a run says the same."""
    settings = IntegrationSection()
    for machine, words in (
        (held(-40.0, -20.0), "however short its step"),
        (held(0.1, 240.0), "too stiff for its step"),
        (held(40.0, 20.0), ""),
    ):
        told = law_sentence(machine.model(), settings, lambda machine=machine: machine)
        assert words in told
        assert bool(told) == bool(words)
        problem = kinolab.load({"system": machine, "goal": {"x": 1.0}, "bounds": {"x": [-5, 5]}})
        plan = PlanResult("not_found", None, None, "rrt", 1, 1, 0.0, {})
        folder = tmp_path / str(len(told))
        write_run(folder, problem, plan)
        assert told in json.loads((folder / "report.json").read_text())["warnings"] + [""]
