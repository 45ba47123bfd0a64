"""The folder of a problem has the content that its name is a hash of, whoever wrote it before."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from kinolab.studies.problem_files import ProblemFiles
from tests.studies.tiny_study import LIMITED, SWINGS, Row, rows_made, study_in
from tests.support import needs

FILES = {"scenario.toml": b"schema = 1\n", "assets/machine.json": b"{}"}


def _another_machine(folder: Path) -> None:
    """A machine of Python, which says that it was run, in place of the study's own."""
    code = f"open({str(folder.parents[2] / 'RAN')!r}, 'w').close()\n"
    (folder / "assets" / "evil.py").write_text(code)
    text = (folder / "scenario.toml").read_text()
    lines = [line for line in text.splitlines() if not line.startswith("parameters")]
    named = ['file = "assets/evil.py:make"' if x.startswith("file =") else x for x in lines]
    (folder / "scenario.toml").write_text("\n".join(named))


def _another_goal(folder: Path) -> None:
    text = (folder / "scenario.toml").read_text()
    assert "3.14159" in text
    (folder / "scenario.toml").write_text(text.replace("3.141592653589793", "0.3"))


def _further_file(folder: Path) -> None:
    (folder / "assets" / "__pycache__").mkdir()
    (folder / "assets" / "__pycache__" / "machine.nbi").write_bytes(b"a pickle")


def _missing_file(folder: Path) -> None:
    shutil.rmtree(folder / "assets")


def _linked_file(folder: Path) -> None:
    """The right content for now, where anybody may change it."""
    away = folder.parents[2] / "away.toml"
    shutil.move(folder / "scenario.toml", away)
    (folder / "scenario.toml").symlink_to(away)


def _linked_folder(folder: Path) -> None:
    away = folder.parents[2] / "away"
    shutil.move(folder, away)
    folder.symlink_to(away)


def _a_file(folder: Path) -> None:
    shutil.rmtree(folder)
    folder.write_bytes(b"")


CHANGES = [_another_goal, _further_file, _missing_file, _linked_file, _linked_folder, _a_file]


def content(folder: Path) -> dict[str, bytes]:
    assert not folder.is_symlink()
    there = [path for path in folder.rglob("*") if not path.is_dir()]
    assert not any(path.is_symlink() for path in there)
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in there}


@pytest.mark.parametrize("change", CHANGES)
def test_a_folder_with_another_content_is_replaced(
    change: Callable[[Path], None], tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    files = ProblemFiles({**FILES, "scenario.toml": b"theta = 3.141592653589793\n"})
    folder = files.written(tmp_path / "out" / "scenarios")
    change(folder)
    assert files.written(folder.parent) == folder
    assert content(folder) == files.files
    assert [path.name for path in folder.parent.iterdir()] == [files.key]
    assert "of another content than its name says" in caplog.text


def test_a_folder_with_its_content_stays(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    files = ProblemFiles(FILES)
    made = files.written(tmp_path).stat().st_ino
    assert files.written(tmp_path).stat().st_ino == made
    assert not caplog.text


@pytest.fixture(scope="module")
def first(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Row]]:
    """Results of a study, and its rows."""
    folder = tmp_path_factory.mktemp("first")
    return folder / "out", rows_made(study_in(folder, SWINGS + LIMITED), folder / "out")


@needs("pyarrow")
@pytest.mark.parametrize("change", [_another_machine, _another_goal])
@pytest.mark.parametrize("resume", [False, True])
def test_nothing_of_somebodys_results_is_run(
    change: Callable[[Path], None], resume: bool, first: tuple[Path, list[Row]], tmp_path: Path
) -> None:
    """A study goes into a folder from elsewhere; its rows are those of the study."""
    out, rows = first
    shutil.copytree(out / "scenarios", tmp_path / "out" / "scenarios")
    (folder,) = (tmp_path / "out" / "scenarios").iterdir()
    change(folder)
    found = rows_made(study_in(tmp_path, SWINGS + LIMITED), tmp_path / "out", resume=resume)
    assert not (tmp_path / "RAN").exists()
    assert [row["motion"] for row in found] == [row["motion"] for row in rows]
    assert content(folder) == content(out / "scenarios" / folder.name)
