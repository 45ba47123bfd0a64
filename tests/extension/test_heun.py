"""A method of integration from outside makes steps, slopes, pages and plans as the others do."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from kinolab import systems
from kinolab.dynamics import Model
from kinolab.dynamics.codegen.methods import METHODS, Method, add_method
from kinolab.errors import InputError
from kinolab.scenario import load_scenario, write_scenario
from kinolab.simulation.sensitivities import StepSensitivities
from kinolab.verification import verify
from tests.extension.heun import HEUN
from tests.javascript_engine import Engine
from tests.support import problem_of

MACHINES = ("pendulum", "rolling_disk", "satellite")
NUDGE = 1e-6  # of an entry

SWING = """\
schema = 1
title = "A pendulum swings by Heun's method"
[system]
name = "pendulum"
[bounds]
theta_dot = [-8, 8]
[goal]
theta = 3.14159
[integration]
method = "heun"
step = 0.02
truth = "discrete"
[integration.tableau]
order = 2
a = [[], [1.0]]
b = [0.5, 0.5]
"""


@pytest.fixture(autouse=True)
def known() -> None:
    add_method(HEUN)


@pytest.fixture
def engine() -> Engine:
    return Engine()


def moving(name: str) -> tuple[Model, np.ndarray, np.ndarray]:
    """A machine, a state of it that moves, and inputs."""
    model, random = systems.get(name).model(), np.random.default_rng(1)
    x = model.project(model.rest() + 0.3 * random.uniform(-1, 1, model.nx))
    return model, x, np.clip(random.uniform(-1, 1, model.nu), *model.control_bounds.T)


@pytest.mark.parametrize("name", ["pendulum", "satellite"])  # nothing is stiff in these
def test_half_a_step_errs_by_an_eighth(name: str) -> None:
    """The local error is O(h^3), until a state is projected: then constants differ."""
    model, x, u = moving(name)

    def error(h: float) -> float:
        fine = model.step(x, u, h, substeps=64)
        return float(np.abs(model.step(x, u, h, method="heun") - fine).max())

    assert error(0.02) / error(0.01) == pytest.approx(8.0, rel=0.1)


def test_a_step_is_the_mean_of_two_slopes() -> None:
    model, x, u = moving("pendulum")
    h = 0.05
    first = model.f(x, u)
    expected = x + h / 2 * (first + model.f(x + h * first, u))
    np.testing.assert_allclose(model.step(x, u, h, method="heun"), expected, rtol=1e-15)


@pytest.mark.parametrize("name", MACHINES)
def test_slopes_of_a_step_are_its_differences(name: str) -> None:
    model, x, u = moving(name)
    after, tangents = StepSensitivities(model, HEUN, 2).linearized(x[None], u[None], 0.05)

    def step(z: np.ndarray) -> np.ndarray:
        state, held, length = np.split(z, [model.nx, model.nx + model.nu])
        return model.step(state, held, float(length[0]), method="heun", substeps=2)

    z = np.concatenate([x, u, [0.05]])
    shifts = NUDGE * np.eye(len(z))
    expected = np.column_stack([(step(z + d) - step(z - d)) / (2 * NUDGE) for d in shifts])
    np.testing.assert_allclose(after[0], step(z), rtol=0, atol=1e-14)
    np.testing.assert_allclose(tangents[0], expected, rtol=1e-7, atol=1e-7)


@pytest.mark.parametrize("name", MACHINES)
def test_the_page_makes_the_same_step(name: str, engine: Engine) -> None:
    model, x, u = moving(name)
    body = f"return Array.from({engine.machine(model)}.step(a, b, 0.05, undefined, 'heun', 3))"
    found = engine.run(body, x.tolist(), u.tolist())
    expected = model.step(x, u, 0.05, method="heun", substeps=3)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)


def test_a_scenario_takes_it_and_its_plan_is_certified(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, SWING)
    plan = problem.solve(seed=1, time_limit=30.0)
    assert plan.trajectory is not None
    assert verify(problem, plan.trajectory).passed
    x = plan.trajectory.x
    step = problem.model.step(x[:-1], plan.trajectory.inputs, problem.step, method="heun")
    assert np.abs(problem.model.space.difference(step, x[1:])).max() < 1e-9


TABLEAUX = {
    "explicit": "order = 2\na = [[], [1.0]]\nb = [0.5, 0.5]\n",
    "of three stages": "order = 1\na = [[], [0.5], [-1.0, 2.0]]\nb = [0, 1, 0]\n",
    "implicit": "order = 2\na = [[], [1]]\nb = [1.5, 0.5]\nc = [[], [-2]]\ngamma = 0.25\n",
}


@pytest.mark.parametrize("which", TABLEAUX)
def test_a_scenario_is_written_with_its_coefficients(which: str, tmp_path: Path) -> None:
    head, table = "[integration.tableau]\n", TABLEAUX[which]
    name = f"own_{which.replace(' ', '_')}"
    text = SWING.partition(head)[0].replace('"heun"', f'"{name}"') + head + table
    scenario = problem_of(tmp_path, text).scenario
    METHODS.pop(name)
    (tmp_path / "again.toml").write_text(write_scenario(scenario), encoding="utf-8")
    assert load_scenario(tmp_path / "again.toml") == scenario
    METHODS.pop(name)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("order = 3", "it is not of order 3, but of order 2"),
        ("order = 15", "its order is 15. Give a whole number from 1 to 14"),
        ("a = [[], [0.66]]", "it is not of order 2, but of order 1"),
        ("a = [[1.0], [1.0]]", "a row of a or c is too long"),
        ("b = [0.5]", "it has 1 weights b, 2 rows a and 0 rows c"),
        ("gamma = -1.0", "gamma: -1.0 is too small"),
    ],
)
def test_coefficients_that_are_none_are_refused(line: str, said: str, tmp_path: Path) -> None:
    key = line.partition(" ")[0]
    lines = [kept for kept in SWING.splitlines() if not kept.startswith(f"{key} = ")]
    with pytest.raises(InputError, match=said):
        problem_of(tmp_path, "\n".join([*lines, line]))


def test_another_method_of_the_same_name_is_refused(tmp_path: Path) -> None:
    text = SWING.replace("[[], [1.0]]", "[[], [0.5]]").replace("[0.5, 0.5]", "[0.0, 1.0]")
    with pytest.raises(InputError, match="has another one of this name"):
        problem_of(tmp_path, text)


def test_a_run_has_the_coefficients_of_a_method_that_a_script_added(tmp_path: Path) -> None:
    """Its scenario had the method's name alone, so that no other process could read the run."""
    ralston = Method("ralston", 2, b=(0.25, 0.75), a=((), (2 / 3,)))
    add_method(ralston)
    text = SWING.partition("[integration.tableau]")[0].replace("heun", "ralston")
    (tmp_path / "swing.toml").write_text(text)
    written = write_scenario(load_scenario(tmp_path / "swing.toml"))
    METHODS.pop("ralston")
    (tmp_path / "again.toml").write_text(written)
    load_scenario(tmp_path / "again.toml")
    assert METHODS.pop("ralston") == ralston
