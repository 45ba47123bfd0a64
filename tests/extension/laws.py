"""What holds of a machine with a word from outside the package, as of every other one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import kinolab
from kinolab.dynamics import Model, System
from kinolab.dynamics.language.json.machine_file import machine_from_json, machine_to_json
from kinolab.dynamics.model.second_derivation import SecondDerivation
from kinolab.show.film.animation import animate
from kinolab.verification import verify
from tests.javascript_engine import Engine
from tests.support import problem_of

Array = NDArray[np.float64]
ROUNDING = 1e-11  # relative to the largest derivative


def instants(system: System, states: Array) -> tuple[Model, Array]:
    """Return a machine's model, and an input within its limits for each state."""
    model = system.model()
    low, high = model.control_bounds.T
    return model, np.random.default_rng(2).uniform(low, high, (len(states), model.nu))


def both_derivations_agree(system: System, states: Array) -> None:
    model, u = instants(system, states)
    first = np.array([model.f(*instant) for instant in zip(states, u, strict=True)])
    second = SecondDerivation(model).derivative(states, u)
    np.testing.assert_allclose(second, first, rtol=0, atol=ROUNDING * np.abs(first).max())


def the_page_computes_it(system: System, states: Array) -> None:
    model, u = instants(system, states)
    engine = Engine()
    for x, given in zip(states, u, strict=True):
        body = f"return Array.from({engine.machine(model)}.step(a, b, 0.05))"
        found = engine.run(body, x.tolist(), given.tolist())
        np.testing.assert_allclose(found, model.step(x, given, 0.05), rtol=1e-11, atol=1e-11)


def its_file_tells_it_without_its_code(system: System, states: Array) -> System:
    """Read it back: known words, and the same motion."""
    back = machine_from_json(machine_to_json(system))
    for word in (*back.efforts, *back.inputs):
        assert type(word).__module__.startswith("kinolab.")
    assert machine_to_json(back) == machine_to_json(system)
    model, u = instants(system, states)
    for x, given in zip(states, u, strict=True):
        size = np.abs(model.f(x, given)).max()
        np.testing.assert_allclose(
            Model(back).f(x, given), model.f(x, given), rtol=0, atol=ROUNDING * size
        )
    return back


def a_plan_is_certified_and_shown(folder: Path, source: str, scenario: str) -> None:
    """Plan for a machine in a file of Python; verify, film and save the page of the plan."""
    (folder / "machine.py").write_text(source, encoding="utf-8")
    problem = problem_of(folder, scenario)
    plan = problem.solve(seed=1, time_limit=60.0)
    assert plan.trajectory is not None
    certificate = verify(problem, plan.trajectory)
    assert certificate.passed, certificate
    assert animate(problem, plan.trajectory).startswith(b"GIF8")
    page = kinolab.save_page(problem, plan, folder / "scene.html").read_text(encoding="utf-8")
    for body in problem.model.machine.bodies:
        assert f'"{body.name}"' in page
