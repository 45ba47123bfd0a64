"""``plan bench``: run a study, many runs of planners on scenarios, and report what it shows."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from kinolab.cli.common import PATH, quiet_option
from kinolab.cli.engines import dask_option, engine_of, jobs_option
from kinolab.cli.interrupts import EXIT_CODE as INTERRUPTED
from kinolab.cli.interrupts import INTERRUPTS
from kinolab.cli.progress import Progress
from kinolab.cli.terminal import echo_json, escaped, say
from kinolab.files import stem_of

if TYPE_CHECKING:
    from kinolab.studies.columns import Row
    from kinolab.studies.run_study import StudyFolder, StudyPart
    from kinolab.studies.study_file import Study


@click.command("bench")
@click.argument("study", type=PATH)
@click.option("--out", type=PATH, help="Folder of the results; by default studies/<name>.")
@jobs_option
@dask_option
@click.option("--resume", is_flag=True, help="Keep the runs that are there, and make the others.")
@click.option(
    "--part", metavar="K/N", help="Make only the K-th of N parts, as one of several computers."
)
@click.option(
    "--rows-from",
    "others",
    type=PATH,
    multiple=True,
    metavar="DIR",
    help="Take the runs of another folder of this study; may be repeated.",
)
@click.option("--report", is_flag=True, help="Write report.html and report.md at the end.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@quiet_option
def command(
    study: Path,
    out: Path | None,
    jobs: int | None,
    dask: str | None,
    resume: bool,
    part: str | None,
    others: tuple[Path, ...],
    report: bool,
    as_json: bool,
    quiet: bool,
) -> int:
    """Run STUDY, a TOML file: scenarios by planners by settings by seeds.

    Every run has a process of its own. Rows are kept as they come, in rows.jsonl; results.parquet,
    OMPL's benchmark logs and a database for Planner Arena are written at the end. If STUDY is a
    folder of results, only these and the report are written.
    """
    from kinolab.studies.expansion import run_count
    from kinolab.studies.journal import first_rows, read_rows
    from kinolab.studies.run_study import STUDY, StudyFolder
    from kinolab.studies.study_file import read_study

    progress = Progress(quiet)
    chosen = _part(part)
    complete = True
    if study.is_dir():
        out, read = study, read_study(study / STUDY)
        rows = first_rows(read_rows(out))
    else:
        progress("reading the study and its scenarios")
        read, out = read_study(study), out or Path("studies") / stem_of(study)
        folder = StudyFolder(read, out, resume=resume or bool(others))
        complete = _run(folder, jobs, dask, chosen, others, progress)
        rows = list(folder.rows.values())
    with INTERRUPTS.writing():
        written = _write(out, read, rows, report and not INTERRUPTS.seen, progress)
    progress.close()
    of, solved = run_count(read), sum(row["solved"] for row in rows)
    if as_json:
        facts = {"runs": len(rows), "of": of, "solved": solved}
        echo_json({"folder": str(out), **facts, "files": [str(path) for path in written]})
    else:
        say(escaped(f"{out}: {len(rows)} of {of} runs, {solved} solved"))
        for path in written:
            say(f"  {path.relative_to(out)}")
        if not complete:
            say("  interrupted; the same command with --resume goes on")
    return INTERRUPTED if INTERRUPTS.seen else 0


def _run(
    folder: StudyFolder,
    jobs: int | None,
    dask: str | None,
    part: StudyPart,
    others: tuple[Path, ...],
    progress: Progress,
) -> bool:
    from kinolab.studies.run_study import StudyProgress

    def told(done: StudyProgress) -> None:
        text = f"{done.done} of {done.of} runs, {done.solved} solved, {_spoken(done.left)} left"
        progress(text, passing=True)

    with engine_of(jobs, dask, progress) as (engine, stop):
        return folder.run(engine, part=part, others=others, stop=stop, told=told)


def _write(
    folder: Path, study: Study, rows: Sequence[Row], report: bool, progress: Progress
) -> list[Path]:
    """Write the table and what is made of it; return the paths."""
    from kinolab.studies.columns import PARQUET, write_parquet
    from kinolab.studies.ompl_benchmark import DATABASE, experiments, write_database, write_logs

    written = [folder / PARQUET]
    write_parquet(written[0], rows)
    if not rows:
        return written
    logs = write_logs(folder, experiments(study, rows))
    written += [*logs, folder / DATABASE]
    write_database(written[-1], logs)
    if report:
        progress("drawing the report")
        from kinolab.studies.report_page import write_report

        written += write_report(folder, study, rows)
    return written


def _part(text: str | None) -> StudyPart:
    from kinolab.errors import InputError, Mistake
    from kinolab.studies.run_study import StudyPart

    if text is None:
        return StudyPart()
    number, _, of = text.partition("/")
    if len(text) < 20 and number.isdecimal() and of.isdecimal() and 1 <= int(number) <= int(of):
        return StudyPart(int(number), int(of))
    what = f"{text!r} is no part."
    raise InputError([Mistake("--part", what, "Write 2/5 for the second of five.")])


def _spoken(seconds: float) -> str:
    """Return a time as one says it."""
    if seconds < 90:
        return f"{seconds:.0f} s"
    if seconds < 5400:
        return f"{seconds / 60:.0f} min"
    return f"{seconds / 3600:.1f} h"
