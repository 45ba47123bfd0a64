"""The benchmark of the gallery counts right, and says what it could not count."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from argparse import Namespace
from runpy import run_path
from typing import Any

import pytest

from tests.support import ROOT, environment

SCRIPT = ROOT / "benchmarks" / "gallery.py"
GALLERY = run_path(str(SCRIPT))
CASE = GALLERY["Case"]("maze", "rolling_disk", "rrt")
LIMIT = 100.0  # [s] of the search
SLEEP = [sys.executable, "-c", "import time; time.sleep(60)"]


def run(exit_code: int | None = 0, search: float | None = 1.0, **facts: Any) -> Any:
    given = {"check_code": 0, "wall": 2.0, "iterations": 10, "duration": 20.0, "complaint": ""}
    return GALLERY["Run"]("maze", 1, exit_code=exit_code, search=search, **given | facts)


def row(*runs: Any) -> list[str]:
    """Return the cells of the table's only row, without the names."""
    *_, last = GALLERY["table"]([CASE], runs, LIMIT).splitlines()
    names, cells = last.strip("| ").split(" | ")[:3], last.strip("| ").split(" | ")[3:]
    assert names == ["maze", "rolling_disk", "rrt"]
    return cells


def test_the_benchmark_explains_itself() -> None:
    done = subprocess.run(
        [sys.executable, str(SCRIPT), "--help"],
        env=environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0
    for option in ("--seeds", "--planner", "--time-limit", "--jobs", "--json", "--keep"):
        assert option in done.stdout


def test_where_all_is_solved_the_figures_are_plain() -> None:
    runs = [run(search=search, duration=10 * search) for search in (4.0, 1.0, 2.0)]
    assert row(*runs) == ["3/3", "3/3", "2.0", "4.0", "20.0", "–"]


def test_a_search_without_a_plan_counts_as_the_limit_and_is_marked() -> None:
    """The worst one always; the median once it is, or leans on, such a search."""
    solved, nothing = run(search=2.0), run(3, search=99.0, duration=None, check_code=None)
    assert row(solved, solved, nothing) == ["2/3", "2/2", "2.0", "≥ 100.0", "20.0", "3 (1)"]
    assert row(solved, nothing)[2:4] == ["≥ 51.0", "≥ 100.0"]
    assert row(solved, nothing, nothing)[2:4] == ["≥ 100.0", "≥ 100.0"]


def test_an_approximation_is_no_plan() -> None:
    """It has a motion, whose duration does not count."""
    assert row(run(), run(4, duration=500.0)) == [
        "1/2",
        "1/1",
        "≥ 50.5",
        "≥ 100.0",
        "20.0",
        "4 (1)",
    ]


def test_a_plan_that_the_check_refuses_shows() -> None:
    assert row(run(), run(check_code=7), run(check_code=None))[:2] == ["3/3", "1/3"]


def test_a_crash_leaves_a_row_without_figures() -> None:
    """No report, whatever else there is on stdout; a signal gives a negative exit code."""
    crashed = GALLERY["Ended"](70, "", "Traceback\n  a line\nerror: a mistake in kinolab\n")
    shot = GALLERY["Ended"](-11, '{"timings": ', "")
    runs = [GALLERY["result"](CASE, 1, ended, None, 1.0) for ended in (crashed, shot)]
    assert row(*runs) == ["0/2", "–", "≥ 100.0", "≥ 100.0", "–", "-11 (1), 70 (1)"]
    assert str(runs[0]) == "maze, seed 1: exit 70: error: a mistake in kinolab"


def test_killed_and_interrupted_runs_are_said() -> None:
    options = Namespace(time_limit=LIMIT, seeds=3, jobs=2)
    runs = [run(), run(None, search=None, duration=None, check_code=None)]
    text = " ".join(GALLERY["circumstances"](options, runs, 3))
    assert "2 runs side by side" in text
    assert "1 of the runs took longer than 220 s and were killed" in text
    assert "Interrupted after 2 of 3 runs" in text
    assert row(*runs)[-1] == "killed (1)"


def test_a_scenario_that_was_not_reached_has_no_row() -> None:
    assert len(GALLERY["table"]([CASE], [], LIMIT).splitlines()) == 2


def test_a_process_that_takes_too_long_is_killed() -> None:
    begun = time.monotonic()
    ended = GALLERY["Processes"]().run(SLEEP, 0.3)
    assert ended.code is None
    assert time.monotonic() - begun < 30  # [s]; it would sleep for 60


def test_an_interrupt_ends_what_runs_and_starts_nothing_more() -> None:
    processes = GALLERY["Processes"]()
    timer = threading.Timer(0.3, processes.close)
    timer.start()
    for _ in range(2):  # the first one is killed, the second one never begins
        with pytest.raises(InterruptedError):
            processes.run(SLEEP, 60.0)
    timer.join()
