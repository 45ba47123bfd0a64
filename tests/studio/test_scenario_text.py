"""A scenario's text is changed where an edit means to, and comes back as it was."""

from __future__ import annotations

import difflib
import tomllib
from typing import Any

import numpy as np
import pytest

from kinolab.errors import InputError
from kinolab.scenario import builtin_scenarios

pytest.importorskip("tomlkit")

from kinolab.studio.core import edits
from kinolab.studio.core.scenario_text import Add, Drop, Put, ScenarioText, edited

FIRST = """\
schema = 1
title = "a world"   # of mine

[world]
obstacle = [
  { sphere = 1.0, name = "ball" },  # round
]

[goal]
x = 1.0  # [m]
"""


def lines_changed(before: str, after: str) -> list[str]:
    """Return the lines that differ, each with its sign."""
    compared = difflib.ndiff(before.splitlines(), after.splitlines())
    return [line for line in compared if line[:1] in "+-"]


@pytest.mark.parametrize("name", builtin_scenarios())
def test_no_byte_of_a_gallery_scenario_changes_but_what_was_changed(name: str) -> None:
    text = builtin_scenarios()[name].read_bytes().decode()
    assert edited(text, []) == text
    title = edited(text, [Put(("title",), "Another one")])
    was = tomllib.loads(text)["title"]
    assert title == text.replace(f'title = "{was}"', 'title = "Another one"', 1)
    moved = edited(title, [Put(("title",), was)])
    assert moved == text


@pytest.mark.parametrize("name", builtin_scenarios())
def test_an_obstacle_that_is_added_stands_alone_and_leaves_no_trace(name: str) -> None:
    text = builtin_scenarios()[name].read_text(encoding="utf-8")
    values = tomllib.loads(text)
    changes = edits.add_obstacle(values, "box", [1.0, 1.0, 1.0], [0.0, 0.0, 0.5])
    added = edited(text, changes)
    assert [line for line in lines_changed(text, added) if line[0] == "-"] == []
    assert added.count("\n[[world.obstacle]]\nname = ") >= 1
    there = tomllib.loads(added)
    assert edited(added, edits.remove(there, len(edits.obstacles(there)) - 1)) == text


def test_comments_stay_beside_what_they_are_about() -> None:
    after = edited(FIRST, [Put(("goal", "x"), 2.5), Put(("world", "obstacle", 0, "sphere"), 2.0)])
    assert after == FIRST.replace("x = 1.0", "x = 2.5").replace("sphere = 1.0", "sphere = 2.0")


def test_the_ends_of_lines_stay_what_they_were() -> None:
    windows = FIRST.replace("\n", "\r\n")
    after = edited(windows, [Put(("goal", "y"), 2.0)])
    assert after == windows + "y = 2.0\r\n"


def test_what_cannot_be_changed_is_refused_and_nothing_is_lost() -> None:
    document = ScenarioText(FIRST)
    for change in (Put(("goal", "x", "deep"), 1.0), Drop(("world", "obstacle", 5))):
        with pytest.raises(InputError):
            document.edit("a slip", [change])
    with pytest.raises(InputError, match="this is not TOML"):
        edited("x = [", [Put(("y",), 1)])
    assert document.text == FIRST
    assert document.undo() == ""


def some_edit(values: dict[str, Any], rng: np.random.Generator) -> list[Any]:
    """Return one of all kinds of edits, at random."""
    count = len(edits.obstacles(values))
    number = int(rng.integers(count)) if count else 0
    place, size = edits.tidy(rng.normal(size=3)), edits.tidy(rng.uniform(0.1, 2.0, 3))
    x, tolerance = float(rng.normal()), float(rng.uniform(0.1, 1.0))
    of_one = [
        edits.duplicate(values, number, 0.5),
        edits.remove(values, number),
        edits.alter(values, number, position=place, rpy=size),
        edits.alter(values, number, name=edits.fresh(values, "thing"), color="#aabbcc"),
        edits.alter(values, number, color=None),
    ]
    anywhere = [
        edits.add_obstacle(values, "box", size, place),
        edits.add_obstacle(values, "sphere", size[0], place),
        edits.add_wall(values, place, size, 1.0),
        edits.add_room(values, (0.0, 0.0), (3.0, 4.0), 0.5),
        edits.set_state("start", {"x": x, "psi": x}),
        edits.ask(values, "y", x, tolerance),
        edits.ask(values, "x", x, None),
        edits.choose_planner(values, "rrt", ("time_limit", "seed")),
        edits.choose_objective({"time": 1.0, "effort": tolerance}),
        edits.choose_objective({}),
        [Put(("system", "parameters", "R"), tolerance)],
        [Put(("world", "clearance"), tolerance)],
        [Put(("bounds", "x_dot"), [-tolerance, tolerance])],
    ]
    kinds = anywhere + (of_one if count else [])
    return kinds[int(rng.integers(len(kinds)))]


@pytest.mark.parametrize("name", ["rolling_disk_maze", "panda_shelves", "vehicle_parking"])
def test_two_hundred_edits_with_undo_and_redo_end_where_they_began(name: str) -> None:
    began = builtin_scenarios()[name].read_text(encoding="utf-8")
    document, rng = ScenarioText(began), np.random.default_rng(1)
    texts = [began]
    for k in range(200):
        if document.edit(f"edit {k}", some_edit(document.values, rng)):
            texts.append(document.text)
        if rng.random() < 0.2:  # back and forth on the way changes nothing
            steps = int(rng.integers(1, 5))
            taken = sum(bool(document.undo()) for _ in range(steps))
            assert sum(bool(document.redo()) for _ in range(taken)) == taken
        assert document.text == texts[-1]
    for text in reversed(texts[:-1]):
        assert document.undo()
        assert document.text == text
    assert document.undo() == ""
    assert document.text == began
    for text in texts[1:]:
        assert document.redo()
        assert document.text == text
    assert len(texts) > 150


def test_the_steps_of_one_drag_are_undone_at_once() -> None:
    document = ScenarioText(FIRST)
    for x in (1.1, 1.2, 1.3):
        document.edit("move the goal", [Put(("goal", "x"), x)], going_on=True)
    document.edit("name it", [Put(("title",), "b")], going_on=True)
    assert document.undo() == "name it"
    assert document.undo() == "move the goal"
    assert document.text == FIRST


def test_a_tolerance_of_one_coordinate_leaves_the_others_theirs() -> None:
    values = {"goal": {"x": 1.0, "y": 2.0, "at_rest": True, "tolerance": 0.2}}
    (change,) = edits.ask(values, "y", 2.0, 0.5)
    assert change == Put(("goal", "tolerance"), {"x": 0.2, "y": 0.5})
    assert edits.ask(values, "y", 2.0, 0.2) == []


def test_a_wall_reaches_from_one_point_to_the_other() -> None:
    (change,) = edits.add_wall({}, (0.0, 0.0), (0.0, 3.0), 1.0)
    assert isinstance(change, Add)
    assert change.value["box"] == [3.1, 0.1, 1.0]
    assert change.value["position"] == [0.0, 1.5, 0.5]
    assert change.value["rpy"] == [0.0, 0.0, pytest.approx(np.pi / 2, abs=1e-4)]
