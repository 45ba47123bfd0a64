"""docs/benchmarking.md has every key of a study and every column; its studies can be run."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from kinolab.cli.manual.study_keys import page
from kinolab.studies import study_file
from kinolab.studies.columns import COLUMNS
from kinolab.studies.expansion import expanded
from kinolab.studies.study_file import read_study
from tests.support import ROOT

PAGE = page()
STUDIES = sorted((ROOT / "benchmarks" / "studies").glob("*.toml"))
RUNS = {
    "durations": 19 * 10 + 18,
    "goal_bias": 2 * 5 * 20,
    "gallery": 19 * 10,
    "drawn_seeds": 19 * 10,
    "matrix": (5 * 4 + 2 * 3 + 4 + 4 * 2) * 5,
}


@pytest.mark.parametrize("name", ["Study", "Limits", "NamedPlanner", "Sobol", "Range"])
def test_every_key_is_on_the_page(name: str) -> None:
    for field, about in getattr(study_file, name).model_fields.items():
        if field != "path":
            assert f"| `{about.alias or field}` |" in PAGE
            assert about.description


def test_every_column_is_on_the_page() -> None:
    for column in COLUMNS:
        assert re.search(
            rf"^\| `{column.name}` \| .* \| {re.escape(column.meaning)} \|$", PAGE, re.M
        )


@pytest.mark.parametrize("path", STUDIES, ids=lambda path: path.stem)
def test_the_studies_of_the_project_can_be_run(path: Path, tmp_path: Path) -> None:
    assert len(expanded(read_study(path), tmp_path).runs) == RUNS[path.stem]


def test_the_study_in_five_minutes_is_the_one_in_the_repository() -> None:
    shown = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)[-1]
    assert shown == (ROOT / "benchmarks/studies/goal_bias.toml").read_text(encoding="utf-8")


def test_the_first_study_of_the_page_can_be_read(tmp_path: Path) -> None:
    shown = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)[0]
    (tmp_path / "study.toml").write_text(shown, encoding="utf-8")
    maze = (ROOT / "scenarios/rolling_disk_maze.toml").read_text(encoding="utf-8")
    (tmp_path / "my_maze.toml").write_text(maze, encoding="utf-8")
    (tmp_path / "meshes").mkdir()
    shutil.copy(ROOT / "scenarios/meshes/rolling_disk_maze.stl", tmp_path / "meshes")
    study = read_study(tmp_path / "study.toml")
    assert study.limits.search == 10.0
    assert len(expanded(study, tmp_path / "files").runs) == 2 * 2 * 20 * 2 * 2
