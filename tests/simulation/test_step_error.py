"""How far the planner's steps err, and which would not."""

from pathlib import Path

import numpy as np
import pytest

from kinolab.problem import PlanningTask
from kinolab.simulation.reference import resimulate
from kinolab.simulation.step_error import TOLERATED, StepError, step_error
from tests.support import problem_of


def problem(folder: Path, *overrides: str) -> PlanningTask:
    """A double pendulum of the gymnasium kind, which swings fast."""
    text = """
schema = 1
title = "An acrobot swings"
[system]
name = "acrobot_v0"
[bounds]
q1_dot = [-8, 8]
q2_dot = [-8, 8]
[start]
q1 = 0.5
[goal]
q1 = 3.0
tolerance = 0.1
"""
    return problem_of(folder, text, *overrides)


def swing(folder: Path, step: float, *overrides: str) -> StepError | None:
    """The error of steps along two seconds of falling."""
    made = problem(folder, f"integration.step={step}", *overrides)
    t = np.arange(0.0, 2.0 + step / 2, step)
    return step_error(made, resimulate(made, t, np.zeros((len(t) - 1, made.model.nu))))


def test_fine_steps_say_nothing(tmp_path: Path) -> None:
    assert swing(tmp_path, 0.01) is None


def test_an_error_is_the_difference_from_the_exact_flow(tmp_path: Path) -> None:
    """Euler's error of one step is h^2/2 x'' + O(h^3): a quarter at half the step."""
    coarse = swing(tmp_path, 0.04, "integration.method=euler")
    fine = swing(tmp_path, 0.02, "integration.method=euler")
    assert coarse is not None
    assert fine is not None
    assert coarse.share / fine.share == pytest.approx(4, rel=0.15)
    assert coarse.share > TOLERATED


@pytest.mark.parametrize("method", ["euler", "rk4"])
def test_what_is_named_as_a_cure_cures(tmp_path: Path, method: str) -> None:
    step = 0.05 if method == "euler" else 0.4
    found = swing(tmp_path, step, f"integration.method={method}")
    assert found is not None
    assert found.substeps is not None
    finer = [f"integration.method={method}", f"integration.substeps={found.substeps}"]
    assert swing(tmp_path, step, *finer) is None
    fewer = [finer[0], f"integration.substeps={found.substeps // 2}"]
    assert swing(tmp_path, step, *fewer) is not None
    if found.other:
        assert swing(tmp_path, step, f"integration.method={found.other}") is None


def test_euler_is_told_of_a_better_method(tmp_path: Path) -> None:
    found = swing(tmp_path, 0.05, "integration.method=euler")
    assert found is not None
    assert found.other == "rk4"
    assert found.sentence.startswith("The search's steps of 0.05 s by euler err by up to ")
    assert f"[integration] substeps = {found.substeps} (steps of " in found.sentence
    assert found.sentence.endswith(' or method = "rk4" would not.')


@pytest.mark.parametrize(("rate", "least"), [(1.0, 1), (500.0, 72), (1000.0, 144)])
def test_what_is_named_as_a_cure_is_stable(
    rate: float, least: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """RK4 is stable up to 2.785 / rate, as examine says: 0.4 s / 0.00557 s = 71.8."""
    monkeypatch.setattr("kinolab.simulation.step_error.fastest_rate", lambda _: rate)
    found = swing(tmp_path, 0.4, "integration.method=rk4")
    assert found is not None
    assert found.substeps is not None
    assert found.substeps >= least
    assert (found.substeps == least) == (least > 64)  # which errs little enough
    assert found.other in {"", "rosenbrock"} or rate * 0.4 <= 2.785


def test_steps_that_count_as_true_do_not_err(tmp_path: Path) -> None:
    assert swing(tmp_path, 0.05, "integration.method=euler", "integration.truth=discrete") is None
