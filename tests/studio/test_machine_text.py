"""A machine's own Python file in the studio, and what a plan is tried for, without a browser."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

pytest.importorskip("tomlkit")
pytest.importorskip("viser")

from kinolab import systems
from kinolab.analyze.execute.conditions import Conditions
from kinolab.errors import InputError
from kinolab.scenario.starters.starter_files import STARTERS, write_starter
from kinolab.studio.core import edits
from kinolab.studio.core.chosen_folder import ChosenFolder
from kinolab.studio.core.machine_task import examine_machine
from kinolab.studio.core.machine_text import (
    machine_file,
    own_copy,
    read_machine,
    write_machine,
)
from kinolab.studio.core.meaning import meaning_of
from kinolab.studio.core.scenario_text import edited
from kinolab.studio.core.tolerance_box import tolerance_box
from kinolab.studio.core.trial_tasks import execute_plan, prove_plan
from tests.conftest import Solved


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("own.py:own", "own.py"),
        ("machines/own.py", "machines/own.py"),
        ("robot.urdf", None),
        ("machine.json", None),
        ("", None),
    ],
)
def test_a_scenario_s_python_file_is_found(tmp_path: Path, name: str, file: str | None) -> None:
    found = machine_file(ChosenFolder(tmp_path), {"system": {"file": name}})
    assert found == (None if file is None else tmp_path.resolve() / file)


def test_a_machine_outside_of_the_folder_is_not_edited(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="outside"):
        machine_file(ChosenFolder(tmp_path), {"system": {"file": "../own.py:own"}})


@pytest.mark.parametrize("name", systems.names())
def test_a_copy_of_a_registered_machine_s_file_means_the_same_machine(
    tmp_path: Path, name: str
) -> None:
    text = edits.empty("a world", name)
    folder, place = ChosenFolder(tmp_path), tmp_path / "world.toml"
    copied = edited(text, own_copy(folder, name))
    assert tomllib.loads(copied)["system"] == {"file": f"{name}.py:{name}"}
    before, after = meaning_of(text, place), meaning_of(copied, place)
    assert not after.stale, after.mistakes
    assert before.problem is not None
    assert after.problem is not None
    ours, theirs = before.problem.model, after.problem.model
    assert ours.state_names == theirs.state_names
    x = before.problem.start
    u = ours.control_bounds.mean(axis=1)
    assert np.array_equal(ours.step(x, u, 0.01), theirs.step(x, u, 0.01), equal_nan=True)


def test_a_mistake_in_a_machine_names_its_line_and_the_last_good_machine_stays(
    tmp_path: Path,
) -> None:
    _, path = write_starter("mine", tmp_path, "segway")
    scenario = path.read_text(encoding="utf-8")
    good = meaning_of(scenario, path)
    file = machine_file(ChosenFolder(tmp_path), tomllib.loads(scenario))
    assert file is not None
    text = read_machine(file)
    line = next(k for k, told in enumerate(text.splitlines(), 1) if "mass=M, inertia" in told)
    write_machine(file, text.replace("mass=M, inertia", "mass=MM, inertia"))
    broken = meaning_of(scenario, path, good)
    assert broken.stale
    assert broken.problem is good.problem
    assert f"on line {line} (NameError" in str(broken.mistakes[0])
    write_machine(file, text.replace("Box(0.12, 0.22, 0.5)", "Box(0.12, 0.22, 0.6)"))
    again = meaning_of(scenario, path, broken)
    assert again.problem is not None
    (shape,) = again.problem.bodies[0].shapes
    assert shape.span()[0][2] == pytest.approx(0.6)


@pytest.mark.parametrize("kind", STARTERS)
def test_every_template_is_a_scenario_that_can_be_planned_for(tmp_path: Path, kind: str) -> None:
    _, path = write_starter("mine", tmp_path, kind)
    meaning = meaning_of(path.read_text(encoding="utf-8"), path)
    assert meaning.ready, meaning.mistakes


def test_an_examination_has_the_equations_and_the_verdict(tmp_path: Path) -> None:
    _, path = write_starter("mine", tmp_path)
    problem = meaning_of(path.read_text(encoding="utf-8"), path).problem
    told: list[Any] = []
    found = examine_machine(told.append, problem)
    assert "laws of mechanics hold" in found.verdict
    assert found.told.endswith(found.verdict)
    assert "∂L/∂q" in found.equations
    assert [message.words for message in told] == ["deriving its equations", "examining its laws"]


def test_a_perfect_machine_arrives_every_time_and_one_that_differs_is_named(short: Solved) -> None:
    told: list[Any] = []
    found = execute_plan(told.append, short.problem, short.trajectory, Conditions(), 3, 1)
    assert found.lines[0] == "3 of 3 runs reached the goal"
    assert set(found.paths) == {"reached"}
    assert not found.failed
    blind = Conditions(parameters=0.9, tracked=False)
    found = execute_plan(told.append, short.problem, short.trajectory, blind, 5, 1)
    assert found.failed
    for name, x in found.failed.items():
        assert name.startswith("run ")
        assert x.shape[1] == short.problem.model.nx
    assert sum(len(each) for each in found.paths.values()) > 0


def test_a_proved_tube_contains_the_plan(short: Solved) -> None:
    found = prove_plan(lambda _: None, short.problem, short.trajectory, 0.1)
    assert found.lines[0].startswith("proved")
    places = short.problem.model.frames(short.trajectory.x)[:, short.problem.leading, 3::4]
    # 1e-6 [m]: the plan's stored states differ from the reference motion by its integration
    inside = (found.low - 1e-6 <= places[:, None]) & (places[:, None] <= found.high + 1e-6)
    assert inside.all(axis=2).any(axis=1).all()


def test_a_goal_s_region_is_as_wide_as_its_tolerances(tmp_path: Path) -> None:
    text = edits.empty("a world", "diff_drive").partition("[goal]")[0]
    text += "[goal]\nx = 3.0\ny = 2.0\npsi = 0.0\n[goal.tolerance]\nx = 0.2\ny = 0.1\npsi = 0.3\n"
    problem = meaning_of(text, tmp_path / "world.toml").problem
    assert problem is not None
    region = tolerance_box(problem)
    assert region is not None
    assert region[:, :2] == pytest.approx(np.array([[2.8, 1.9], [3.2, 2.1]]))
