"""A dead end that opens towards the start: the plain field is stuck in it, the others are not."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinolab
from kinolab import cli
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.search import Budget
from kinolab.solve import PlanResult
from tests.support import OPEN, problem_of

PLAIN: dict[str, Any] = {"navigation": False, "random_walk_escapes": 0}


@pytest.fixture(scope="module")
def trap() -> PlanningTask:
    return kinolab.load("diffdrive_trap", overrides=["planner.improve=0"])


@pytest.fixture(scope="module")
def stuck(trap: PlanningTask) -> PlanResult:
    return trap.solve(seed=1, time_limit=600.0, **PLAIN)


def bits(found: PlanResult) -> bytes:
    assert found.trajectory is not None
    return found.trajectory.x.tobytes() + found.trajectory.u.tobytes()


def test_the_plain_field_is_stuck_and_says_so(stuck: PlanResult) -> None:
    assert (stuck.status, stuck.exit_code) == ("local_minimum", 4)
    assert stuck.message.startswith("Stuck in a local minimum of the potential;")
    assert "Raise [planner] random_walk_escapes or set navigation = true." in stuck.message
    assert stuck.certificate is not None
    assert {check.name for check in stuck.certificate.failures} == {"goal"}


def test_the_minimum_is_named_and_lies_in_the_dead_end(stuck: PlanResult) -> None:
    """The dead end reaches from x = 3.3 to 4.5 and from y = 2.1 to 3.9."""
    where = {name: stuck.statistics[f"minimum_{name}"] for name in ("x", "y", "psi")}
    assert 3.5 < where["x"] < 4.5
    assert 2.1 < where["y"] < 3.9
    assert stuck.statistics["minimum_potential"] > 1.0  # [m]; the goal is behind the wall
    assert stuck.statistics["minima"] == 1.0


@pytest.mark.parametrize("seed", range(1, 4))
def test_a_navigation_function_leads_around_it(seed: int, trap: PlanningTask) -> None:
    found = trap.solve(seed=seed, random_walk_escapes=0)
    assert found.status == "solved"
    assert found.trajectory is not None
    y = found.trajectory.x[:, 1]
    beside = np.abs(found.trajectory.x[:, 0] - 4.0) < 0.5
    assert (np.abs(y[beside] - 3.0) > 0.9).all()  # never inside


@pytest.mark.parametrize("seed", range(1, 3))
def test_escapes_lead_out_of_it(seed: int, trap: PlanningTask) -> None:
    found = trap.solve(seed=seed, navigation=False, time_limit=600.0)
    assert found.status == "solved"
    assert found.statistics["escapes"] >= 1.0


def test_the_same_seed_escapes_the_same_way_and_another_one_does_not(trap: PlanningTask) -> None:
    one, again, other = (
        trap.solve(seed=seed, navigation=False, time_limit=600.0, max_iterations=400)
        for seed in (7, 7, 8)
    )
    assert bits(one) == bits(again)
    assert one.statistics == again.statistics
    assert bits(one) != bits(other)


def test_a_search_with_escapes_ends_at_its_iterations_while_it_wanders(trap: PlanningTask) -> None:
    for most in (250, 331):
        found = trap.solve(seed=1, navigation=False, max_iterations=most)
        assert found.iterations == most
        assert found.status == "approximate"


def test_escapes_are_counted_and_then_the_search_ends(trap: PlanningTask) -> None:
    found = trap.solve(seed=1, navigation=False, random_walk_escapes=1, time_limit=600.0)
    assert found.status in {"local_minimum", "solved"}
    assert found.statistics["escapes"] <= 1.0


def test_a_minimum_no_nearer_than_the_start_leaves_no_motion(tmp_path: Path) -> None:
    """Rates may hardly differ from 0, so that the start itself is the minimum."""
    still = ("bounds.psi_dot=[-1e-9, 1e-9]", "bounds.phi_dot=[-1e-9, 1e-9]")
    found = problem_of(tmp_path, OPEN, *still).solve(
        planner="potential_field", random_walk_escapes=0
    )
    assert (found.status, found.exit_code) == ("local_minimum", 3)
    assert found.trajectory is None


def test_the_command_line_says_where_it_is_stuck(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ("--set", "planner.navigation=false", "--set", "planner.random_walk_escapes=0")
    silent = ("--no-animation", "--no-diagnosis", "--no-optimize", "--json")
    assert cli.run(["diffdrive_trap", *options, *silent, "--out", str(tmp_path / "run")]) == 4
    told = capsys.readouterr().out
    assert '"status": "local_minimum"' in told
    assert '"minimum_x": 4.' in told


def test_an_interrupt_while_the_field_is_built_ends_the_search(trap: PlanningTask) -> None:
    def stop(budget: Budget) -> None:
        budget.interrupted = True

    found = trap.solve(seed=1, watch=stop)
    assert (found.status, found.iterations) == ("interrupted", 0)


@pytest.mark.parametrize(
    ("setting", "value", "told"),
    [
        ("random_walk_escapes", -1, "-1 is out of range. Give at least 0."),
        ("navigation", 1, "1 does not fit. Give a truth value, such as the default True."),
        ("influence_distance", 0.0, "0.0 is out of range. Give at least 0.001."),
        ("grid_memory", "much", "'much' does not fit. Give a number, such as the default 16.0."),
    ],
)
def test_a_setting_that_does_not_fit_is_told_with_what_would_work(
    setting: str, value: object, told: str, trap: PlanningTask
) -> None:
    with pytest.raises(InputError) as caught:
        trap.solve(**{setting: value})
    assert str(caught.value) == f"[planner] {setting}: {told}"
