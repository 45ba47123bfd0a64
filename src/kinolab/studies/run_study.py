"""A study, from its file to its rows: what is missing is run, what comes is kept at once."""

from __future__ import annotations

import codecs
import json
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from kinolab.concurrency.cancel import CancellationToken, never_cancelled
from kinolab.concurrency.forks import FORKS
from kinolab.concurrency.processors import processors
from kinolab.errors import InputError, Mistake
from kinolab.files import write_whole
from kinolab.lazy import library_of
from kinolab.studies.columns import COLUMNS, NEED
from kinolab.studies.engine import AbstractEngine, LocalEngine, MakeEngine
from kinolab.studies.expansion import RunSpec, StudyRuns, expanded
from kinolab.studies.journal import ROWS, Journal, read_rows
from kinolab.studies.orders import Answer, SearchOrder, as_told
from kinolab.studies.study_file import Study

STUDY = "study.toml"
NAMES = tuple(column.name for column in COLUMNS)


@dataclass(frozen=True)
class StudyPart:
    """One of several parts of a study: every ``of``-th run from the ``number``-th on."""

    number: int = 1
    of: int = 1

    def has(self, spec: RunSpec) -> bool:
        """Whether a run belongs to it."""
        return spec.index % self.of == self.number - 1


@dataclass(frozen=True)
class StudyProgress:
    """How far a study is.

    Attributes:
        done: Runs that have a row.
        of: All runs of the part.
        solved: Runs with a verified plan.
        left: Seconds that the others will take, about.
    """

    done: int
    of: int
    solved: int
    left: float


class StudyFolder:
    """A study, its runs, and the folder of its results.

    Args:
        folder: Of its results; made where it is missing.
        resume: Whether rows that are there are kept, and only the others made.

    Raises:
        InputError: With every mistake in the study; if there are rows and ``resume`` is not set, or
            rows of another study; if pyarrow is not installed.
    """

    def __init__(self, study: Study, folder: Path, *, resume: bool = False) -> None:
        library_of("bench", "pyarrow", NEED)
        _require_limits(study)
        self.study, self.folder = study, folder
        new = not folder.exists()
        earlier = _earlier(folder, resume)
        self.root = folder / "scenarios"  # folder of the files that runs are made from
        try:
            self.runs: StudyRuns = expanded(study, self.root)
        except InputError:
            if new:  # nothing is left behind by a study that cannot be run
                shutil.rmtree(folder, ignore_errors=True)
            raise
        limits = study.limits.model_dump()
        self._tasks = {spec.index: spec.identity(limits) for spec in self.runs.runs}
        self.rows: dict[int, dict[str, Any]] = {}
        self._take(earlier, str(folder))

    def _take(self, rows: Iterable[dict[str, Any]], where: str) -> list[dict[str, Any]]:
        """Add rows of this study; return those that were new.

        Raises:
            InputError: If one is of another study.
        """
        new = []
        for row in rows:
            if self._tasks.get(row["index"]) != row.get("task"):
                what = (
                    f"row {row['index']} there is of another study, or of this one before a "
                    "setting, a limit, a scenario or the number of seeds was changed."
                )
                remedy = f"{STUDY} there is the study of its rows; or name another --out."
                raise InputError([Mistake(where, what, remedy)])
            if row["index"] not in self.rows:
                self.rows[row["index"]] = row
                new.append(row)
        return new

    def run(
        self,
        engine: MakeEngine | None = None,
        *,
        part: StudyPart = StudyPart(),
        others: Sequence[Path] = (),
        stop: CancellationToken = never_cancelled,
        told: Callable[[StudyProgress], None] = lambda _: None,
    ) -> bool:
        """Make all runs that have no row, and keep each row as it comes.

        Args:
            engine: Makes what has runs done, from files and the folder they are in; processes here
                when left out, as many as there are processors.
            part: Which runs to make.
            others: Folders of the same study, other parts of it, whose rows are taken.
            stop: Polled; once set, open runs are given up.
            told: Called after each row.

        Returns:
            Whether all runs of the part have a row.

        Raises:
            InputError: If the engine is not there, or a row is of another study.
            EngineLostError: If the engine ends; rows so far are kept.
            FullError: If a row cannot be written; rows so far are kept.
        """
        for other in others:
            if not (other / ROWS).is_file():
                what, remedy = "there are no rows of a study.", "Name the folder of its results."
                raise InputError([Mistake(str(other), what, remedy)])
        with Journal(self.folder) as journal:
            self._take(read_rows(self.folder), str(self.folder))  # of a process just before
            content = self.study.path.read_bytes().removeprefix(codecs.BOM_UTF8)
            write_whole(self.folder / STUDY, content)  # which not every reader of TOML skips
            for other in others:
                for row in self._take(read_rows(other), str(other)):
                    journal.add(row)
            mine = [spec for spec in self.runs.runs if part.has(spec)]
            missing = [spec for spec in mine if spec.index not in self.rows]
            if missing:
                make = engine or (lambda _, root: LocalEngine(processors(), root))
                with make(self.runs.files.values(), self.root) as working:
                    self._make(working, missing, len(mine), journal, stop, told)
            return all(spec.index in self.rows for spec in mine)

    def _make(
        self,
        engine: AbstractEngine,
        missing: Sequence[RunSpec],
        of: int,
        journal: Journal,
        stop: CancellationToken,
        told: Callable[[StudyProgress], None],
    ) -> None:
        begun, known = time.monotonic(), of - len(missing)
        solved = sum(bool(row["solved"]) for row in self.rows.values())
        for made, answer in enumerate(engine.answers(self._orders(missing), stop), start=1):
            row = self._row(answer)
            journal.add(row)
            self.rows[row["index"]] = row
            solved += row["solved"]
            left = (time.monotonic() - begun) / made * (len(missing) - made)
            told(StudyProgress(known + made, of, solved, left))

    def _orders(self, specs: Iterable[RunSpec]) -> Iterator[SearchOrder]:
        limits = self.study.limits
        for spec in specs:
            yield SearchOrder(
                spec.index,
                spec.files,
                seed=spec.seed,
                overrides=spec.overrides,
                improve=spec.improve,
                check=spec.check,
                search=limits.search,
                iterations=limits.iterations,
                cpu_limit=limits.cpu,
                memory_limit=limits.memory,
            )

    def _row(self, answer: Answer) -> dict[str, Any]:
        spec = self.runs.runs[answer["index"]]
        told = {
            **as_told(answer),
            "task": self._tasks[spec.index],
            "scenario": spec.scenario,
            "planner": spec.planner,
            "seed": spec.seed,
            "settings": json.dumps(dict(spec.settings)),
            "fixed": json.dumps(dict(spec.fixed)),
            "solved": answer["status"] == "solved",
        }
        return {name: told.get(name) for name in NAMES}


def _require_limits(study: Study) -> None:
    """Refuse limits that cannot be kept here.

    Raises:
        InputError: If processes cannot be watched.
    """
    if study.limits.cpu is None and study.limits.memory is None:
        return
    if not FORKS:
        what = "limits of processor time and memory need Linux."
        raise InputError([Mistake(f"{study.path.name} limits", what, "Leave cpu and memory out.")])
    library_of("bench", "psutil", "limits of processor time and memory need psutil")


def _earlier(folder: Path, resume: bool) -> list[dict[str, Any]]:
    """Return the rows of a folder that is to be written into.

    Raises:
        InputError: If there are some and they shall not be kept, or it cannot be written.
    """
    rows = read_rows(folder) if (folder / ROWS).is_file() else []
    if rows and not resume:
        what = f"there are {len(rows)} runs of a study."
        remedy = "--resume keeps them and goes on; --out names another folder."
        raise InputError([Mistake(str(folder), what, remedy)])
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        what = f"this folder cannot be made: {error.strerror}."
        raise InputError([Mistake(str(folder), what, "Name another.")]) from None
    return rows
