"""Is the way too narrow, by how much, and between what? Doors of known widths tell."""

from __future__ import annotations

from pathlib import Path

import pytest

from kinolab.analyze.diagnose.narrow_passage import passage as narrow_passage
from kinolab.analyze.diagnose.narrow_passage.passage import Passage, find_passage, is_applicable
from kinolab.problem.goal_states import goal_states
from tests.analyze.diagnose.scenarios import COIN, ROBOT, ROOM, box, door, ring
from tests.support import OPEN, problem_of

PLENTY = 300.0  # [s]: the looks end by their number, not by time
FINE = 0.003  # [m]: 2 mm of the estimate, and the way is bent at random


@pytest.fixture
def sparing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give up earlier than by default, both looking for a way and widening it."""
    monkeypatch.setattr(narrow_passage, "MAX_CHECKS", 10_000)
    monkeypatch.setattr(narrow_passage, "FINE", (0.008, 60))


def passage(folder: Path, text: str, *overrides: str) -> Passage:
    problem = problem_of(folder, text, *overrides)
    return find_passage(problem, goal_states(problem).inside, PLENTY)


@pytest.mark.parametrize(
    ("machine", "width"),
    [("diff_drive", ROBOT), pytest.param("rolling_disk", COIN, marks=pytest.mark.long)],
)
def test_a_door_2_cm_too_narrow_is_called_that(machine: str, width: float, tmp_path: Path) -> None:
    found = passage(tmp_path, door(width - 0.02, machine))
    assert found.narrow_by == pytest.approx(0.02, abs=FINE)
    assert found.sentence.startswith("The way is about 2 cm too narrow: ")
    assert {pair.split(" – ")[1] for pair in found.beside} == {"left wall", "right wall"}


@pytest.mark.usefixtures("sparing")
def test_a_door_that_is_narrower_by_more_than_a_wheel_is_thick(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The robot needs 37 cm over its wheels of 4 cm each; a door of 30 cm lacks 7 cm of it.

    A single way of a robot that is 16 cm narrower shows it.
    """
    monkeypatch.setattr(narrow_passage, "SLIMMER", {320: 1})
    thin = door(0.30).replace("box = [0.1, ", "box = [0.04, ")
    found = passage(tmp_path, thin)
    assert found.narrow_by == pytest.approx(0.07, abs=FINE)
    assert found.sentence.startswith("The way is about 7 cm too narrow: ")
    assert {pair.split(" – ")[0] for pair in found.beside} <= {"left wheel", "right wheel"}


@pytest.mark.parametrize(("machine", "width"), [("diff_drive", ROBOT), ("rolling_disk", COIN)])
def test_a_door_2_cm_wider_than_the_machine_is_not_too_narrow(
    machine: str, width: float, tmp_path: Path
) -> None:
    found = passage(tmp_path, door(width + 0.02, machine))
    assert found.open
    assert found.narrow_by is None
    assert found.sentence == "Its dynamics aside, there is a way from the start to the goal."


def test_a_narrow_door_beside_a_wide_one_is_no_matter(tmp_path: Path) -> None:
    beside = door(0.35).replace("2.0, 1.0]", "1.2, 1.0]")
    assert passage(tmp_path, beside).open


@pytest.mark.usefixtures("sparing")
def test_a_gate_that_is_1_cm_too_low_is_not_called_2_cm_too_narrow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing but the gate is in the way: slimming takes as much off below, where it is free.

    A single way of a robot that is 4 cm slimmer shows it.
    """
    monkeypatch.setattr(narrow_passage, "SLIMMER", {80: 1})
    top = 0.0975 + 0.18 + 0.02  # [m] above the ground: the turret of the robot
    beam = box("beam", (0.1, 4.2, 0.2), (0.0, 0.0, top - 0.01 + 0.1))
    found = passage(tmp_path, ROOM + beam)
    assert found.narrow_by == pytest.approx(0.01, abs=FINE)
    assert found.beside == ("robot – beam",)


@pytest.mark.usefixtures("sparing")
def test_a_wall_all_around_lets_no_shrunk_machine_through(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """However often it is looked: twice for each width instead of six times."""
    few = {slim: min(searches, 2) for slim, searches in narrow_passage.SLIMMER.items()}
    monkeypatch.setattr(narrow_passage, "SLIMMER", few)
    found = passage(tmp_path, ring(1.0), "start.x=-2")
    assert not found.open
    assert found.narrow_by is None
    assert found.sentence == "No way was found even for a machine 64 cm narrower."
    assert found.blocked


def test_where_nothing_can_be_touched_there_is_nothing_to_look_at(tmp_path: Path) -> None:
    assert not is_applicable(problem_of(tmp_path / "open", OPEN))
    assert is_applicable(problem_of(tmp_path / "ring", ring(1.0)))


def test_small_gaps_are_given_in_millimetres() -> None:
    assert "at most 1 mm too" in Passage(False, 0.00025, ("a – b",)).sentence
    assert "about 3 mm too" in Passage(False, 0.0031, ("a – b",)).sentence
    assert "about 2 cm too" in Passage(False, 0.0213, ("a – b",)).sentence
    assert "about 12.5 cm too" in Passage(False, 0.126, ("a – b",)).sentence


def test_a_look_that_had_no_time_claims_nothing(tmp_path: Path) -> None:
    problem = problem_of(tmp_path, door(0.35))
    found = find_passage(problem, goal_states(problem).inside, 0.0)
    assert not found.open
    assert not found.blocked
    assert found.sentence == "No way was found in time, its dynamics aside."
    unsure = Passage(False, 0.05, ("a – b",), finished=False).sentence
    assert unsure == "No way was found in time, but one for a machine 5 cm narrower: a – b."
