"""Studies whose runs take a tenth of a second, rows that nobody ran, and how they are kept."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from kinolab.concurrency.cancel import CancellationToken, never_cancelled
from kinolab.studies.columns import COLUMNS
from kinolab.studies.engine import LocalEngine
from kinolab.studies.run_study import StudyFolder
from kinolab.studies.study_file import Study, read_study

Row = dict[str, Any]

TINY = """\
schema = 1
title = "Which one swings up?"
scenarios = ["pendulum_swingup"]
planners = ["kpiece_fast"]
"""
SWING = """\
schema = 1
title = "A pendulum swings up with nothing in its way"
[system]
name = "pendulum"
[goal]
theta = 3.141592653589793
tolerance = 0.5
"""
SWINGS = TINY.replace("pendulum_swingup", "swing.toml")  # without a mesh to be verified against
LIMITED = "[limits]\niterations = 3000\n"
VERSIONS = json.dumps({"kinolab": "1.2", "python": "3.11"})


def study_in(folder: Path, text: str, name: str = "tiny.toml") -> Study:
    """Write the file of a study and a scenario of its own beside it, and read the study."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / name).write_text(text, encoding="utf-8")
    (folder / "swing.toml").write_text(SWING, encoding="utf-8")
    return read_study(folder / name)


def rows_made(
    study: Study,
    folder: Path,
    *,
    workers: int = 1,
    resume: bool = False,
    stop: CancellationToken = never_cancelled,
    **options: Any,
) -> list[Row]:
    """Run a study by processes here; return its rows in their order."""
    home = StudyFolder(study, folder, resume=resume)
    home.run(lambda _, root: LocalEngine(workers, root), stop=stop, **options)
    return [home.rows[index] for index in sorted(home.rows)]


def kept(folder: Path) -> list[Row]:
    """Return the rows of a folder, as they stand in its file."""
    return [json.loads(line) for line in (folder / "rows.jsonl").read_text().splitlines()]


def written(folder: Path, rows: list[Row]) -> None:
    """Write rows into a folder, as a study keeps them."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rows.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))


def row(index: int, planner: str = "rrt", status: str = "solved", **further: Any) -> Row:
    """A row that nobody ran: its search takes 0.1 s, its motion 2 s unless it is said."""
    solved = status == "solved"
    told: Mapping[str, Any] = {
        "task": f"task {index}", "scenario": "table", "seed": index, "settings": "{}",
        "fixed": "{}", "solved": solved, "checked": None, "iterations": 100, "search": 0.1,
        "duration": 2.0 if solved else None, "first_duration": None, "duration_bound": None,
        "goal_distance": 0.05, "clearance": 0.01 if solved else None,
        "steps": 40 if solved else None, "motion": None,
        "statistics": "{}", "message": "", "prepare": 0.1, "verify": 0.1, "cpu": 0.5, "wall": 0.75,
        "memory": 150.5, "improvements": [], "began": 1.7e9 + index, "load": 0.5,
        "computer": "aaaaaaaa", "host": "one", "processor": "Some CPU", "cores": 8,
        "system": "Linux x86_64", "versions": VERSIONS,
    }  # fmt: skip
    return {"index": index, **told, "planner": planner, "status": status, **further}


def several(planner: str, times: list[float], first: int = 0, **further: Any) -> Iterator[Row]:
    """Rows of a planner by the times of its searches in [s]; one that is NaN is not solved."""
    for index, time in enumerate(times, start=first):
        solved = time == time  # noqa: PLR0124  # NaN is not
        ends = {"status": "solved", "search": time} if solved else {"status": "not_found"}
        yield row(index, planner, **{**ends, **further})


def differing(first: Iterable[Row], second: Iterable[Row]) -> list[int]:
    """Return the runs whose rows differ in more than times and computers, or that one lacks."""
    lasting = [column.name for column in COLUMNS if not column.timed]
    one, two = (
        {row["index"]: [row[n] for n in lasting] for row in rows} for rows in (first, second)
    )
    return sorted(index for index in {*one, *two} if one.get(index) != two.get(index))
