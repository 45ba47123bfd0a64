"""No motion makes the verifier raise, whatever its numbers are: it is refused, check by check."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinolab
from kinolab.errors import InputError
from kinolab.problem import PlanningTask
from kinolab.trajectory import Trajectory
from kinolab.verification import Certificate, certificate, verify
from kinolab.verification.between_samples.clearance_margin import least_clearance
from kinolab.verification.between_samples.clearance_search import ClearanceSearch
from kinolab.verification.between_samples.dense_motion import TooFastError
from tests.support import detail, failed
from tests.verification.test_between_samples import cart, even, lane

HUGE = (np.nan, np.inf, 1e308, -1e154, 5e-324)


def rows(scenario: str, count: int = 3) -> tuple[PlanningTask, Trajectory]:
    """Return a problem, and a motion that stands still at its start, true or not."""
    problem = kinolab.load(scenario)
    model, plant = problem.model, problem.model.plant
    names = () if plant is model else model.control_names
    return problem, Trajectory(
        problem.step * np.arange(count + 1.0),
        np.tile(problem.start, (count + 1, 1)),
        np.zeros((count, plant.nu)),
        model.state_names,
        plant.control_names,
        np.zeros((count, len(names))),
        names,
    )


def test_a_motion_that_jumps_into_contact_at_a_knot_is_told_with_what_it_touches() -> None:
    """The forearms' angles are exchanged in all rows, so that the loops are open in the first."""
    problem, motion = rows("five_bar_table")
    left, right = (problem.model.state_names.index(name) for name in ("f_l", "f_r"))
    swapped = motion.x.copy()
    swapped[:, [left, right]] = swapped[:, [right, left]]
    found = verify(problem, replace(motion, x=swapped))
    assert {"start", "constraints", "collision"} <= failed(found)
    assert " touches post" in detail(found, "collision")


@pytest.mark.parametrize("turned", [0.4, -0.4, 1.0, 2.0, 3.0])
@pytest.mark.parametrize("name", ["f_l", "f_r", "a_l"])
def test_loops_that_are_open_at_the_start_are_refused(name: str, turned: float) -> None:
    problem, motion = rows("five_bar_table")
    x = motion.x.copy()
    x[:, problem.model.state_names.index(name)] += turned
    assert {"start", "constraints"} <= failed(verify(problem, replace(motion, x=x)))


@pytest.mark.parametrize("mode", [-1.0, 0.5, 2.0, 7.0, 1e300])
@pytest.mark.parametrize("row", [0, 1, 3])
def test_a_row_in_a_mode_that_does_not_exist_is_refused(mode: float, row: int) -> None:
    problem, motion = rows("biped_walk")
    x = motion.x.copy()
    x[row, -1] = mode
    found = verify(problem, replace(motion, x=x))
    assert failed(found) == {"numbers"}
    assert f"row {row} is in mode {mode:g}; they are 0 to 1" in detail(found, "numbers")


@pytest.mark.parametrize("scenario", ["pendulum_swingup", "falling_disk_slalom", "two_cranes"])
@pytest.mark.parametrize("number", HUGE)
@pytest.mark.parametrize("table", ["t", "x", "u"])
def test_numbers_of_any_size_are_refused(scenario: str, number: float, table: str) -> None:
    problem, motion = rows(scenario)
    changed = getattr(motion, table).copy()
    changed.reshape(len(changed), -1)[1, 0] = number
    assert not verify(problem, replace(motion, **{table: changed})).passed


def test_a_motion_that_is_too_fast_for_its_smallest_clearance_to_be_found_has_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def too_fast(_: ClearanceSearch) -> None:
        raise TooFastError(0.0, 1.0, 1e6)

    problem = lane(tmp_path, cart(), "[[world.obstacle]]\nbox = [1, 1, 1]\nposition = [0, 5, 0]\n")
    assert isinstance(verify(problem, even(problem)), Certificate)
    assert least_clearance is certificate.least_clearance
    monkeypatch.setattr(certificate, "least_clearance", too_fast)
    found = verify(problem, even(problem))
    assert found.passed
    assert found.margin is None


def test_the_motion_of_another_machine_is_no_question() -> None:
    problem, _ = rows("pendulum_swingup")
    _, motion = rows("rolling_disk_maze")
    with pytest.raises(InputError, match=r"of another machine\. Give one with the columns theta"):
        verify(problem, motion)
