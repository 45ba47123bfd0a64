"""docs/files.md explains every file, column and number of a run."""

from __future__ import annotations

import io
import json
import re
from dataclasses import fields

import numpy as np
import pytest

import kinolab
from kinolab import planners
from kinolab.analyze.diagnose.diagnosis import Diagnosis
from kinolab.analyze.execute.conditions import Conditions
from kinolab.analyze.execute.execution_report import execution_to_json
from kinolab.cli.manual.run_files import page as files_page
from kinolab.cli.manual.sections import sections_of
from kinolab.problem import PlanningTask
from kinolab.runs.folder import MOTION_FORMATS, OPTIONAL
from kinolab.runs.readme import README
from kinolab.trajectory import Trajectory
from kinolab.verification.checks import CHECKS
from tests.cli.manual.examples import examples_in
from tests.conftest import Finished, Solved
from tests.executions import execute

SECTIONS = {section.title: section for section in sections_of(files_page())}
NAMED = {"goal_distance_by_unit", "refused", "assets", "versions", "rejections"}  # keys are names


def rows_of(title: str) -> dict[str, str]:
    """Return what a section tells, by everything that it names in a first column."""
    rows = re.findall(r"^\| ([^|]*) \| (.*) \|$", SECTIONS[title].text, re.MULTILINE)
    return {name: text for cell, text in rows for name in re.findall(r"`([^`]+)`", cell)}


def test_every_file_of_a_run_is_on_the_page(maze_run: Finished) -> None:
    page = files_page()
    written = {p.relative_to(maze_run.folder).as_posix() for p in maze_run.folder.rglob("*.*")}
    promised = {*MOTION_FORMATS, *OPTIONAL, README, "report.json", "scenario.toml"}
    for name in {*written, *promised}:
        numbered = re.fullmatch(r"assets/\d+_.*", name)
        assert numbered or f"`{name.removeprefix('assets/')}`" in page, name


def test_every_key_of_the_report_is_on_the_page(maze_run: Finished) -> None:
    report = json.loads((maze_run.folder / "report.json").read_text())
    assert set(report) == set(rows_of("report.json"))
    for name, value in report.items():
        entries = value if isinstance(value, list) else [value]
        for entry in entries:
            if isinstance(entry, dict) and name not in NAMED:
                assert set(entry) <= set(rows_of(name)), name
    for name in ("attempts", "improvements", "margin"):
        assert report[name]


@pytest.mark.parametrize("planner", planners.built_in())
def test_the_counters_of_every_planner_are_on_the_page(planner: str, table: PlanningTask) -> None:
    found = table.solve(planner=planner, max_iterations=100)
    assert set(found.statistics) <= set(rows_of("statistics"))
    assert set(found.timings) <= set(rows_of("timings"))


def test_every_key_of_a_diagnosis_is_on_the_page() -> None:
    assert set(rows_of("diagnosis")) == {field.name for field in fields(Diagnosis)}


def test_every_check_is_on_the_page(maze_run: Finished) -> None:
    told = set(rows_of("verification"))
    assert {check["name"] for check in maze_run.report["verification"]} <= told
    functions = {check.__name__.replace("_", " ").replace("times", "time") for check in CHECKS}
    assert functions <= told


@pytest.mark.parametrize(
    ("machine", "column", "kind"),
    [
        ("rolling_disk", "t", "Time in s"),
        ("rolling_disk", "psi", "not wrapped"),
        ("rolling_disk", "psi_dot", "derivative of a coordinate"),
        ("rolling_disk", "drive", "Held from its row to the next"),
        ("satellite", "R_w", "in the order x, y, z, w"),
        ("satellite", "R_wx", "in the body's axes"),
        ("unicycle", "reference.speed", "feedback was asked for"),
    ],
)
def test_every_kind_of_column_is_on_the_page(machine: str, column: str, kind: str) -> None:
    model = kinolab.systems.get(machine).model()
    plant = model.plant
    rest = np.vstack([model.rest()] * 2)
    law = plant is not model
    motion = Trajectory(
        np.array([0.0, 0.1]),
        rest,
        np.zeros((1, plant.nu)),
        model.state_names,
        plant.control_names,
        np.zeros((1, model.nu)) if law else np.zeros((1, 0)),
        model.control_names if law else (),
    )
    header, _, last = motion.to_csv().splitlines()
    assert column in header.split(",")
    assert last.endswith("," * (plant.nu + law * model.nu))
    assert kind in rows_of("trajectory.csv")[column].replace("**", "")
    arrays = np.load(io.BytesIO(motion.to_npz()))
    assert set(arrays) <= set(rows_of("trajectory.npz"))


def test_quaternions_turn_the_bodys_axes_into_the_worlds_and_rates_are_the_bodys() -> None:
    """With the scalar last, q' = q (w, 0) / 2: here about z after a quarter turn about x."""
    model = kinolab.systems.get("satellite").model()
    x, names = model.rest(), model.state_names
    x[[names.index(f"R_{axis}") for axis in "xyzw"]] = np.sqrt([0.5, 0, 0, 0.5])  # y is up
    x[names.index("R_wy")] = (
        1.0  # so that turning about the body's y is turning about the world's z
    )
    change = model.f(x)[[names.index(f"R_{axis}") for axis in "xyzw"]]
    # (0, 0, 1, 0) q / 2, the same velocity given in the world's axes
    assert change == pytest.approx(0.5 * np.sqrt([0, 0.5, 0.5, 0]), abs=1e-12)


def test_what_the_search_explored_is_on_the_page(maze_run: Finished) -> None:
    assert set(np.load(maze_run.folder / "search.npz")) == set(rows_of("search.npz"))


def test_every_key_of_an_execution_is_on_the_page(short: Solved) -> None:
    found = execution_to_json(
        short.problem, execute(short.problem, short.trajectory, Conditions(), runs=1)
    )
    told = SECTIONS["execution.json"].text
    assert set(found) <= set(rows_of("execution.json"))
    for key in (*found["conditions"], *found["each"][0]):
        assert f"`{key}`" in told, key


def test_the_examples_read_a_run(maze_run: Finished, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(maze_run.folder)
    examples = [e for section in SECTIONS.values() for e in examples_in(section, "python")]
    assert len(examples) == 2
    for example in examples:
        exec(example, {})
