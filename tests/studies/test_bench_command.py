"""``plan bench``: what it writes and says, goes on with, and refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from kinolab import cli
from tests.studies.tiny_study import LIMITED, TINY, kept, written
from tests.support import OPEN, needs

Capture = pytest.CaptureFixture[str]

# a scenario of one's own, beside the study
MINE = OPEN.replace('"rrt"', '"rrt_fast"')
STUDY = f"{TINY.replace('pendulum_swingup', 'mine.toml')}seeds = 3\n{LIMITED}"
QUICK = ("--jobs", "1", "--quiet")


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with a study and its scenario in a folder below."""
    (tmp_path / "work").mkdir()
    (tmp_path / "work" / "mine.toml").write_text(MINE)
    (tmp_path / "work" / "tiny.toml").write_text(STUDY.replace("kpiece_fast", "rrt_fast"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_a_study_is_run_kept_and_written_again(home: Path, capsys: Capture) -> None:
    pq = pytest.importorskip("pyarrow.parquet")
    assert cli.run(["bench", "work/tiny.toml", *QUICK, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    files = ["results.parquet", "ompl/mine.log", "planner_arena.db"]
    out = Path("studies/tiny")
    assert said == {
        "folder": str(out),
        "runs": 3,
        "of": 3,
        "solved": 3,
        "files": [str(out / file) for file in files],
    }
    rows = kept(out)
    table = pq.read_table(out / "results.parquet").to_pylist()
    assert table == rows
    assert (out / "study.toml").read_bytes() == (home / "work" / "tiny.toml").read_bytes()

    assert cli.run(["bench", "work/tiny.toml", *QUICK]) == 2
    told = f"error: {out}: there are 3 runs of a study. --resume keeps them and goes on"
    assert told in capsys.readouterr().err

    written(out, rows[:2])
    assert cli.run(["bench", "work/tiny.toml", *QUICK, "--resume"]) == 0
    assert capsys.readouterr().out.startswith(f"{out}: 3 of 3 runs, 3 solved\n")
    assert kept(out)[:2] == rows[:2]
    assert [row["motion"] for row in kept(out)] == [row["motion"] for row in rows]

    # the folder alone, with nothing beside it that the study names
    (home / "work" / "mine.toml").unlink()
    for file in files:
        (out / file).unlink()
    assert cli.run(["bench", str(out), "--report", "--quiet"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{out}: 3 of 3 runs, 3 solved"
    assert [line.strip() for line in lines[1:]] == [*files, "report.html", "report.md"]
    assert all((out / file).is_file() for file in (*files, "report.html", "report.md"))


@pytest.mark.usefixtures("home")
def test_parts_are_joined_by_rows_from(capsys: Capture) -> None:
    part = ["bench", "work/tiny.toml", *QUICK]
    assert cli.run([*part, "--part", "1/2", "--out", "one"]) == 0
    assert cli.run([*part, "--part", "2/2", "--out", "two"]) == 0
    assert capsys.readouterr().out.startswith("one: 2 of 3 runs, 2 solved\n")
    assert cli.run([*part, "--rows-from", "one", "--rows-from", "two", "--out", "all"]) == 0
    assert capsys.readouterr().out.startswith("all: 3 of 3 runs, 3 solved\n")
    assert kept(Path("all")) == kept(Path("one")) + kept(Path("two"))


@needs("pyarrow")
@pytest.mark.usefixtures("home")
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["work/tiny.toml", "--part", "3/2"], "error: --part: '3/2' is no part. Write 2/5"),
        (["work/tiny.toml", "--part", "x"], "error: --part: 'x' is no part. Write 2/5"),
        (["work/tiny.toml", "--dask", "local:0"], "error: --dask: 'local:0' is no cluster."),
        (["work/mine.toml"], "error: mine.toml: this is a scenario, not a study."),
        (["work/tinny.toml"], "error: work/tinny.toml: there is no file"),
        (["work"], "error: work/study.toml: there is no file"),
        (["work/tiny.toml", "--rows-from", "no"], "error: no: there are no rows of a study."),
        (
            ["work/tiny.toml", "--out", "work/mine.toml"],
            "error: work/mine.toml: this folder cannot",
        ),
    ],
)
def test_what_cannot_be_run_is_refused(arguments: list[str], said: str, capsys: Capture) -> None:
    assert cli.run(["bench", *arguments, "--quiet"]) == 2
    assert said in capsys.readouterr().err
