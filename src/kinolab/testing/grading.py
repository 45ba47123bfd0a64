"""Grades: the notebook of a chapter, or a machine and a scenario of somebody's own."""

from __future__ import annotations

import asyncio
import csv
import io
import os
import signal
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from kinolab.arguments import require_fit
from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.lazy import library_of
from kinolab.testing.answers.answers_from_afar import judging, processes_with
from kinolab.testing.exercises import RECORD, Mark, exercises, judged
from kinolab.testing.grade_report import Report
from kinolab.testing.project import Told, project_report

CELL_SECONDS = 300  # [s] for each cell of a notebook
NOTEBOOK_SECONDS = 1800  # [s] for all of them
MOST_OUTPUT = 10_000_000  # [bytes] of all that a notebook prints, and of one message of it
POLL = 0.1  # [s] between looks at a notebook

_interrupted = threading.Event()  # whether somebody who grades a class has given up


def grade(
    work: str | Path,
    *,
    against: str | Path | None = None,
    due: bool = False,
    told: Told | None = None,
) -> Report:
    """Grade the notebook of a chapter, or a project.

    A notebook is run from its beginning, in a process and an empty folder of its own; the last
    answer to each exercise of its chapter counts. A project is a scenario; its machine must
    be right, do more than the upright rolling disk, and be planned for with a proof. Right is one
    that ``plan examine`` has nothing against and that moves as the machine which was asked for.

    Answers are judged in this process, which the notebook's can send data only: it cannot write
    marks. But its code is somebody else's, and runs with your rights: grade only the work of people
    you trust, or on a computer with nothing to lose.

    Args:
        work: A notebook (``.ipynb``), or what ``plan`` takes: a scenario's file or name.
        against: What was asked for in a project: a scenario, by whose world and goal the plan is
            judged, too, or a machine; without it nothing is compared.
        due: Whether the report says what would be right; notebooks are not told.
        told: Called with what is being done, in words, and with the time that each cell took.

    Raises:
        InputError: If it cannot be read, or what runs notebooks is not installed.
    """
    require_fit("grade work", str | Path, work)
    require_fit("grade against", str | Path | None, against)
    say = told or (lambda _: None)
    if str(work).endswith(".ipynb"):
        return _notebook(Path(work), due, say)
    return project_report(str(work), None if against is None else str(against), due, say)


def grade_class(
    works: Sequence[str | Path],
    jobs: int = 1,
    *,
    against: str | Path | None = None,
    due: bool = False,
    told: Told | None = None,
) -> str:
    """Grade many, and return a table as CSV: one row each, with the points of each exercise.

    Work that cannot be read has a row, too, which says why.

    Args:
        works: Notebooks of one chapter, or scenarios.
        jobs: How many are graded at once.
        against: As ``grade`` takes it.
        due: As ``grade`` takes it.
        told: As ``grade`` takes it; what it is called with begins with the name of the work.
    """
    require_fit("grade_class works", Sequence[str | Path], works)
    require_fit("grade_class jobs", int, jobs)

    def graded(work: str | Path) -> Report:
        say = told and (lambda text: told(f"{Path(work).name}: {text}"))
        try:
            return grade(work, against=against, due=due, told=say)
        except KinolabError as error:
            return Report(str(work), (), (" ".join(str(error).split()),))

    with ThreadPoolExecutor(max(jobs, 1)) as pool:  # each notebook runs in a process of its own
        try:
            reports = list(pool.map(graded, works))
        except KeyboardInterrupt:
            _interrupted.set()
            pool.shutdown(wait=True, cancel_futures=True)
            _interrupted.clear()
            raise
    names = list(dict.fromkeys(v.exercise for report in reports for v in report.marks))
    table = io.StringIO()
    writer = csv.writer(table, lineterminator="\n")
    writer.writerow(["work", "points", "of", *names, "remarks"])
    for report in reports:
        points = {mark.exercise: mark.points for mark in report.marks}
        remarks = [repr(mark) for mark in report.marks if not mark]
        row = [report.source, report.points, report.of, *(points.get(name, "") for name in names)]
        writer.writerow([*row, "; ".join([*remarks, *report.errors])])
    return table.getvalue()


def _notebook(path: Path, due: bool, told: Told) -> Report:
    library_of("course", "nbclient", "notebooks are run by nbclient")
    import nbformat
    from nbclient.exceptions import CellTimeoutError, DeadKernelError

    from kinolab.testing.notebook_client import client_of

    try:
        notebook: Any = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    except Exception as error:  # nbformat's readers raise whatever the bytes provoke
        why = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError([Mistake(str(path), f"is no readable notebook ({why}).")]) from error
    wanted = _exercises_in(notebook)
    if not wanted:
        what, remedy = "no cell has a check(…).", "Grade a notebook that plan course has written."
        raise InputError([Mistake(str(path), what, remedy)])
    errors: list[str] = []
    last: dict[str, Mark] = {}

    def judge(name: str, answer: Any) -> dict[str, Any]:
        try:
            mark = judged(exercises()[name], answer)
        except Exception as error:  # of an answer that its exercise did not expect
            why = f"{type(error).__name__}: {error}"
            mark = Mark(name, 0, exercises()[name].points, f"it cannot be judged ({why}).")
        quiet = replace(mark, due="")
        last[name] = mark if due else quiet
        return asdict(quiet)  # a notebook could answer once more, with what is due

    with (
        tempfile.TemporaryDirectory() as folder,
        tempfile.TemporaryDirectory() as place,
        judging(judge) as address,
    ):
        client = client_of(notebook, folder, CELL_SECONDS, MOST_OUTPUT, place)
        client.on_cell_start, client.on_cell_executed = _clocks(notebook, told)
        try:
            _execute(client, {**os.environ, RECORD: address, "MPLBACKEND": "Agg"})
        except CellTimeoutError:
            errors.append(f"A cell took more than {CELL_SECONDS} s; nothing after it has run.")
        except TimeoutError:
            errors.append(f"It took more than {NOTEBOOK_SECONDS} s; what was left has not run.")
        except DeadKernelError:
            errors.append("Its process ended before the last cell.")
        except Exception as error:  # of Jupyter, about whatever the notebook's process sends
            if not client.started:
                raise
            errors.append(f"Its process sends what is no message ({type(error).__name__}).")
        finally:
            _end_all_of(address)
    if client.printed > MOST_OUTPUT:
        errors.append(f"It prints more than {MOST_OUTPUT // 10**6} MB, which nobody has kept.")
    missing = "it was not reached, or its check was removed."
    marks = [last.get(name, Mark(name, 0, exercises()[name].points, missing)) for name in wanted]
    return Report(str(path), tuple(marks), (*errors, *_failures(notebook)))


def _clocks(notebook: Any, told: Told) -> tuple[Callable[..., None], Callable[..., None]]:
    """Return what is called before and after each cell: it tells which runs, and what it took."""
    code = (k for k, cell in enumerate(notebook.cells) if cell.cell_type == "code")
    numbers = {k: n for n, k in enumerate(code, start=1)}
    begun = 0.0

    def begin(cell_index: int, **_: Any) -> None:
        nonlocal begun
        begun = time.monotonic()
        if cell_index in numbers:
            told(f"cell {numbers[cell_index]} of {len(numbers)}")

    def end(cell_index: int, **_: Any) -> None:
        if cell_index in numbers:
            took = time.monotonic() - begun
            told(f"cell {numbers[cell_index]} of {len(numbers)} took {took:.1f} s")

    return begin, end


def _execute(client: Any, environment: dict[str, str]) -> None:
    """Run a notebook in a thread, whose event loop is closed; the caller may have a loop itself.

    Whatever ends the waiting, such as Ctrl-C, ends the notebook.
    """

    async def run() -> None:
        held.append((asyncio.get_running_loop(), asyncio.current_task()))
        await client.async_execute(env=environment)

    held: list[tuple[asyncio.AbstractEventLoop, Any]] = []
    begun = time.monotonic()
    with ThreadPoolExecutor(1) as thread:
        waiting = thread.submit(asyncio.run, run())
        try:
            while not wait([waiting], POLL).done:
                if _interrupted.is_set():
                    raise KeyboardInterrupt
                if time.monotonic() - begun > NOTEBOOK_SECONDS:
                    raise TimeoutError
        except (KeyboardInterrupt, TimeoutError):
            for loop, task in held:
                loop.call_soon_threadsafe(task.cancel)
            raise
        waiting.result()


def _end_all_of(address: str) -> None:
    """End what a notebook has started, whatever session it is in."""
    while left := processes_with(RECORD, address):
        for process in left:
            with suppress(OSError):
                os.kill(process, signal.SIGKILL)
        time.sleep(POLL)


def _exercises_in(notebook: Any) -> list[str]:
    """Return the names of all exercises of the chapters that a notebook has exercises of."""
    text = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "code")
    there = [name for name in exercises() if f'check("{name}"' in text or f"check('{name}'" in text]
    begun = {name.split(".")[0] for name in there}
    return [name for name in exercises() if name.split(".")[0] in begun]


def _failures(notebook: Any) -> Iterator[str]:
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    for number, cell in enumerate(code, start=1):
        for output in cell.outputs:
            if output.output_type == "error":
                yield f"Cell {number} fails: {output.ename}: {output.evalue}".splitlines()[0]
