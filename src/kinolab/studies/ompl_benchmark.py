"""Results as OMPL keeps them: benchmark logs, and a database for Planner Arena.

Source: the log's format is that of OMPL 2.0's ``Benchmark.cpp`` and of the script that reads it,
``ompl_benchmark_statistics.py`` (ompl.kavrakilab.org/benchmark.html).
"""

from __future__ import annotations

import io
import json
import re
import tempfile
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import redirect_stdout
from dataclasses import dataclass
from datetime import UTC, datetime
from operator import itemgetter
from pathlib import Path
from typing import Any

from kinolab.files import utf_8, write_whole
from kinolab.studies.columns import Row
from kinolab.studies.study_file import Study

LOGS, DATABASE = "ompl", "planner_arena.db"
STATUSES = (
    *("solved", "approximate", "local_minimum", "not_found", "verification_failed", "interrupted"),
    *("error", "crashed", "killed", "out_of_memory", "cpu_limit", "memory_limit"),
)
PROPERTIES: tuple[tuple[str, str, Callable[[Row], float | int | None]], ...] = (
    # of a run, as OMPL names them where it has them, with their values; None where there is none
    ("time", "REAL", itemgetter("search")),
    ("solved", "BOOLEAN", lambda row: int(row["status"] == "solved")),
    (
        "approximate solution",
        "BOOLEAN",
        lambda row: int(row["status"] in ("approximate", "local_minimum")),
    ),
    ("solution length", "REAL", itemgetter("duration")),
    ("solution difference", "REAL", itemgetter("goal_distance")),
    ("solution clearance", "REAL", itemgetter("clearance")),
    ("solution segments", "INTEGER", itemgetter("steps")),
    ("iterations", "INTEGER", itemgetter("iterations")),
    ("memory", "REAL", itemgetter("memory")),
    ("cpu time", "REAL", itemgetter("cpu")),
    ("seed", "INTEGER", itemgetter("seed")),
    (
        "status",
        "ENUM",
        lambda row: STATUSES.index(row["status"]) if row["status"] in STATUSES else None,
    ),
)


@dataclass(frozen=True)
class Experiment:
    """All runs on a scenario that were made on equal computers.

    Attributes:
        name: Of the scenario, without spaces; with the computer's hash if there are several.
        rows: Of each planner with its settings, by its name.
        limits: Of a run: seconds and MB; 0 for none.
    """

    name: str
    rows: dict[str, list[Row]]
    limits: tuple[float, float]

    @property
    def facts(self) -> dict[str, Any]:
        """What stands once for all runs."""
        rows = [row for own in self.rows.values() for row in own]
        began = [row["began"] for row in rows if row["began"] is not None] or [0.0]
        first, last = min(began), max(began)
        known = next((row for row in rows if row["computer"]), rows[0])
        versions = json.loads(known["versions"] or "{}")
        return {
            "name": self.name,
            "totaltime": round(last - first + max((row["wall"] or 0.0) for row in rows), 6),
            "timelimit": self.limits[0],
            "memorylimit": self.limits[1],
            "runcount": max(map(len, self.rows.values())),
            "version": f"kinolab {versions.get('kinolab', '0')}",
            "hostname": _word(known["host"] or "UNKNOWN"),
            "cpuinfo": _line(f"{known['processor']}, {known['cores']} cores") + "\n",
            "date": datetime.fromtimestamp(first, UTC).strftime("%Y-%m-%d %H:%M:%S"),
            "seed": "0",
            "setup": f"{_line(rows[0]['scenario'])}\n{_line(known['versions'] or '{}')}\n",
        }


def experiments(study: Study, rows: Iterable[Row]) -> list[Experiment]:
    """Return rows by scenario, computer and planner, in the order of the study."""
    by_place: dict[tuple[str, str], dict[str, list[Row]]] = defaultdict(lambda: defaultdict(list))
    for row, computer in placed(rows):
        by_place[row["scenario"], computer][configuration(row)].append(row)
    computers = {computer for _, computer in by_place}
    limits = (study.limits.search or study.limits.cpu or 0.0, study.limits.memory or 0.0)
    return [
        Experiment(
            _word(scenario if len(computers) == 1 else f"{scenario}@{computer}"), dict(own), limits
        )
        for (scenario, computer), own in by_place.items()
    ]


def placed(rows: Iterable[Row]) -> Iterator[tuple[Row, str]]:
    """Yield rows in the order of the study, each with its computer's hash.

    A run that was lost with its process has none; it counts where the others were made, so that
    shares of solved runs miss none of them. Where these were made on several kinds of computers, it
    is that of the run before it.
    """
    ordered = sorted(rows, key=lambda row: row["index"])
    last = next((row["computer"] for row in ordered if row["computer"]), "")
    for row in ordered:
        last = row["computer"] or last
        yield row, last


def configuration(row: Row) -> str:
    """Return a planner's name with what was swept: ``rrt_fast[goal_bias=0.1]``."""
    swept = json.loads(row["settings"] or "{}")
    told = ",".join(f"{key.removeprefix('planner.')}={_short(v)}" for key, v in swept.items())
    return _line(f"{row['planner']}[{told}]" if told else str(row["planner"]))


def _line(text: str) -> str:
    """Return a text on one line, as logs and tables need it."""
    return "".join(c if c.isprintable() else " " for c in text)


def _short(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _word(text: str) -> str:
    """Return a text without white space, as logs need it for names."""
    return re.sub(r"\s+", "_", _line(text)) or "_"


def _log_lines(experiment: Experiment) -> Iterator[str]:
    """Yield the lines of a log that OMPL's own script reads."""
    facts = experiment.facts
    name, _, version = facts["version"].partition(" ")
    yield f"{name} version {version}"
    yield f"Experiment {facts['name']}"
    yield "0 experiment properties"
    yield f"Running on {facts['hostname']}"
    yield f"Starting at {facts['date']}"
    yield from ("<<<|", *facts["setup"].rstrip("\n").split("\n"), "|>>>")
    yield from ("<<<|", facts["cpuinfo"].rstrip("\n"), "|>>>")
    yield f"{facts['seed']} is the random seed"
    yield f"{facts['timelimit']!r} seconds per run"
    yield f"{facts['memorylimit']!r} MB per run"
    yield f"{facts['runcount']} runs per planner"
    yield f"{facts['totaltime']:.6f} seconds spent to collect the data"
    yield "1 enum type"
    yield "|".join(("status", *STATUSES))
    yield f"{len(experiment.rows)} planners"
    for planner, rows in experiment.rows.items():
        yield planner
        settings = settings_of(rows)
        yield f"{len(settings)} common properties"
        yield from settings
        yield f"{len(PROPERTIES)} properties for each run"
        yield from (f"{name} {kind}" for name, kind, _ in PROPERTIES)
        yield f"{len(rows)} runs"
        for row in rows:
            yield "".join(f"{_cell(value(row))}; " for *_, value in PROPERTIES)
        yield "2 progress properties for each run"
        yield from ("time REAL", "best cost REAL")
        yield f"{len(rows)} runs"
        yield from ("".join(f"{_cell(t)},{_cell(c)},;" for t, c in progress(row)) for row in rows)
        yield "."


def settings_of(rows: Sequence[Row]) -> list[str]:
    """Return what was set for a planner, as ``key = value``."""
    told = {**json.loads(rows[0]["fixed"] or "{}"), **json.loads(rows[0]["settings"] or "{}")}
    return [_line(f"{key} = {_short(value)}") for key, value in told.items()]


def progress(row: Row) -> list[tuple[float, float]]:
    """Return when motions were verified and how long they take, in s; each time once."""
    best: dict[float, float] = {}
    for after, duration in row["improvements"] or ():
        best[after] = min(duration, best.get(after, duration))
    return sorted(best.items())


def _cell(value: float | int | None) -> str:
    return "nan" if value is None else repr(value)


def write_logs(folder: Path, found: Sequence[Experiment]) -> list[Path]:
    """Write a log for each experiment below ``folder``; return their paths."""
    (folder / LOGS).mkdir(exist_ok=True)
    paths: list[Path] = []
    for one in found:
        name = re.sub("[^A-Za-z0-9_.@-]", "_", one.name)[:200]
        path = folder / LOGS / f"{name}.log"
        if path in paths:  # another one whose name differs in what file names do not have
            path = folder / LOGS / f"{name}.{len(paths) + 1}.log"
        write_whole(path, utf_8("\n".join([*_log_lines(one), ""])))
        paths.append(path)
    for old in {*(folder / LOGS).glob("*.log")}.difference(paths):  # of rows before
        old.unlink()
    return paths


def write_database(path: Path, logs: Iterable[Path]) -> None:
    """Write logs into an SQLite database for Planner Arena, whole or not at all.

    That is what OMPL's own script makes of them.
    """
    from ompl.tools import computeViews, readBenchmarkLog  # late: `comparison` needs no OMPL

    with (
        tempfile.TemporaryDirectory() as folder,
        redirect_stdout(io.StringIO()),  # which the script tells what it does
        warnings.catch_warnings(action="ignore", category=ResourceWarning),  # it closes nothing
    ):
        made = str(Path(folder) / DATABASE)
        readBenchmarkLog(made, [str(log) for log in logs], False)
        computeViews(made, False)
        write_whole(path, Path(made).read_bytes())
