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
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from kinolab.arguments import require_fit
from kinolab.errors import InputError, KinolabError, Mistake
from kinolab.lazy import library_of
from kinolab.problem import PlanningTask
from kinolab.testing.answers_from_afar import judging, processes_with
from kinolab.testing.exercises import RECORD, Mark, exercises, judged

CELL_SECONDS = 300  # [s] for each cell of a notebook
NOTEBOOK_SECONDS = 1800  # [s] for all of them
MOST_OUTPUT = 10_000_000  # [bytes] of all that a notebook prints, and of one message of it
SOUND, RICH, SOLVED, PROVED, NEAR = 4, 2, 3, 2, 1  # points of a project
PLAN_FOUND, PROOF, CENTRE = "a plan is found", "it is proved", "it ends in the goal's centre"
CENTRE_WIDTH = 1e-3  # in SI units
POLL = 0.1  # [s] between looks at a notebook

_interrupted = threading.Event()  # whether somebody who grades a class has given up


@dataclass(frozen=True)
class Report:
    """What one notebook or project is worth.

    Attributes:
        source: The file.
        marks: Of each exercise, in order.
        errors: Cells that failed, in words.
    """

    source: str
    marks: tuple[Mark, ...]
    errors: tuple[str, ...] = ()

    @property
    def points(self) -> int:
        """What was reached."""
        return sum(mark.points for mark in self.marks)

    @property
    def of(self) -> int:
        """What there is."""
        return sum(mark.of for mark in self.marks)

    def __str__(self) -> str:
        """List the exercises, then what failed."""
        lines = [f"{self.source}: {self.points} of {self.of} points"]
        lines += [f"  {mark!r}" for mark in self.marks]
        lines += [f"  {error}" for error in self.errors]
        return "\n".join(lines)


def grade(work: str | Path) -> Report:
    """Grade the notebook of a chapter, or a project.

    A notebook is run from its beginning, in a process and an empty folder of its own; the last
    answer to each exercise of its chapter counts. A project is a scenario; its machine must obey
    the laws of mechanics, do more than the upright rolling disk, and be planned for with a proof.

    Answers are judged in this process, which the notebook's can send data only: it cannot write
    marks. But its code is somebody else's, and runs with your rights: grade only the work of people
    you trust, or on a computer with nothing to lose.

    Args:
        work: A notebook (``.ipynb``), or what ``plan`` takes: a scenario's file or name.

    Raises:
        InputError: If it cannot be read, or what runs notebooks is not installed.
    """
    require_fit("grade work", str | Path, work)
    if str(work).endswith(".ipynb"):
        return _notebook(Path(work))
    return _project(str(work))


def grade_class(works: Sequence[str | Path], jobs: int = 1) -> str:
    """Grade many, and return a table as CSV: one row each, with the points of each exercise.

    Work that cannot be read has a row, too, which says why.

    Args:
        works: Notebooks of one chapter, or scenarios.
        jobs: How many are graded at once.
    """
    require_fit("grade_class works", Sequence[str | Path], works)
    require_fit("grade_class jobs", int, jobs)
    with ThreadPoolExecutor(max(jobs, 1)) as pool:  # each notebook runs in a process of its own
        try:
            reports = list(pool.map(_whatever_happens, works))
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


def _whatever_happens(work: str | Path) -> Report:
    try:
        return grade(work)
    except KinolabError as error:
        return Report(str(work), (), (" ".join(str(error).split()),))


def _notebook(path: Path) -> Report:
    library_of("course", "nbclient", "notebooks are run by nbclient")
    import nbformat
    from nbclient.exceptions import CellTimeoutError, DeadKernelError

    from kinolab.testing.notebook_client import client_of

    try:
        notebook: Any = nbformat.read(path, as_version=4)  # type: ignore[no-untyped-call]
    except Exception as error:  # nbformat's readers raise whatever the bytes provoke
        told = f"{type(error).__name__}: {error}".splitlines()[0]
        raise InputError([Mistake(str(path), f"is no readable notebook ({told}).")]) from error
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
            told = f"{type(error).__name__}: {error}"
            mark = Mark(name, 0, exercises()[name].points, f"it cannot be judged ({told}).")
        last[name] = mark
        return asdict(mark)

    with tempfile.TemporaryDirectory() as folder, judging(judge) as address:
        client = client_of(notebook, folder, CELL_SECONDS, MOST_OUTPUT)
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


def _project(what: str) -> Report:
    """Grade a scenario by the points at the top of this file."""
    from kinolab.analyze.describe.description import describe
    from kinolab.analyze.describe.each_mode import in_each_mode
    from kinolab.analyze.examine import examine
    from kinolab.dynamics import System
    from kinolab.loading import file_of_machine, find_scenario, find_system, load

    scenario = find_scenario(what)
    system = System.of(find_system(scenario))
    odd = examine(system, scenario.integration, file=file_of_machine(scenario)).faults
    richer = any(
        generalisation.shown
        for _, machine in in_each_mode(system)
        for generalisation in describe(machine).generalisations
    )
    machine = (
        _part("the laws of mechanics hold", SOUND, not odd, "; ".join(odd)),
        _part("more than the rolling disk", RICH, richer, "it generalises it in no way."),
    )
    try:
        return Report(what, (*machine, *_planned(load(what))))
    except KinolabError as error:
        return Report(what, (*machine, *_unplanned(" ".join(str(error).split()))))


def _planned(problem: PlanningTask) -> Iterator[Mark]:
    """Yield what the plan for a project is worth; where it starts in the goal, that is nothing."""
    from kinolab.problem.goal_entries import goal_entries
    from kinolab.solve import solve

    entries = goal_entries(problem, problem.start)
    if entries and all(entry.reached for entry in entries):
        yield from _unplanned("it starts in its goal.")
        return
    plan = solve(problem)
    yield _part(PLAN_FOUND, SOLVED, plan.status == "solved", plan.message or plan.status)
    certificate, motion = plan.certificate, plan.trajectory
    failures = [str(one) for one in certificate.failures] if certificate else ["there is no plan."]
    yield _part(PROOF, PROVED, not failures, "; ".join(failures))
    off = [
        f"{one.name} is off by {one.error:.3g}{f' {one.unit}' if one.unit else ''}"
        for one in (goal_entries(problem, motion.x[-1]) if motion else ())
        if one.error > CENTRE_WIDTH
    ]
    near = plan.status == "solved" and not off
    yield _part(CENTRE, NEAR, near, "; ".join(off) or "there is no plan.")


def _unplanned(reason: str) -> Iterator[Mark]:
    wanted = ((PLAN_FOUND, SOLVED), (PROOF, PROVED), (CENTRE, NEAR))
    yield from (Mark(name, 0, points, reason) for name, points in wanted)


def _part(name: str, points: int, reached: bool, reason: str) -> Mark:
    return Mark(name, points if reached else 0, points, "" if reached else reason)
